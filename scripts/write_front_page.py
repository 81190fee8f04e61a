"""The first page of a run, as Markdown, as HTML, and as the first page of the report."""

import json
from pathlib import Path

import pandas as pd

from sparsurf.patches.readings import TEXT
from sparsurf.report.front_page import SHOWN, YARDSTICKS, front_page, links_to_pairs
from sparsurf.report.html import first_page
from sparsurf.study.enough import enough
from sparsurf.workflow.jobs import run

OF_RUN = {"summary.csv": "best combination per range of n_S", "summary.png": "against mean roughness"}
OF_RUN |= {"verdict.html": "the paper, claim by claim", "compare.png": "samplers compared"}
OF_PROTEIN = {
    "figures/frames.png": "frames",
    "figures/ensemble.png": "over time",
    "figures/residues.png": "residues over time",
}
OF_CONFORMATION = {"view.html": "to turn and sample", "figures/roughness.png": "roughness"}
OF_CONFORMATION |= {"figures/d_over_grid.png": "d over the grid", "figures/subsets.png": "the subsets"}
OF_CONFORMATION |= {
    "enough.csv": "how many dots are enough",
    "ranges.csv": "best combinations",
    "residues.csv": "residues",
}


def main(inputs, outputs):
    """Write index.md, index.html and the part of the report, with links to `pages`."""
    folder = Path(inputs["surfaces"]).parent
    surfaces = pd.read_csv(inputs["surfaces"])
    fewer = pd.read_csv(inputs["needed"][0]) if inputs["needed"] else None
    places = [tuple(Path(path).parts[-3:-1]) for path in inputs["minimal"]]
    handed_out = pd.DataFrame(places, columns=["protein", "conformation"])
    handed_out["dots"] = [len(pd.read_csv(path)) for path in inputs["minimal"]]
    reached = pd.concat([pd.read_csv(path) for path in inputs["enough"]])
    found = []
    for place, path in zip(places, inputs["best"], strict=True):
        grid = pd.read_csv(Path(path).with_name("grid.csv"))
        best = json.loads(Path(path).read_text(encoding="utf-8"))
        reading = TEXT if TEXT in best else next(name for name in best if f"d_{name}" in grid)
        sticks = best["yardsticks"]
        wanted = {"null_model": sticks["null_model"]} | {
            words: z for words, z in sticks.get("floors", {}).items() if words in YARDSTICKS
        }
        own = enough(grid, wanted, reading)
        found.append(own.assign(protein=place[0], conformation=place[1]))
    shown = [str(Path(path).relative_to(folder)) for path in inputs["pages"]]
    links = links_to(places, shown) + links_to_pairs(shown)
    page = front_page(folder.name, surfaces, pd.concat(found), reached, handed_out, fewer, links)
    for key, text in first_page(page, folder).items():
        Path(outputs[key]).write_text(text, encoding="utf-8")


def links_to(places, shown):
    """Headings with what there is of each: the run, its proteins, its conformations (the first ones of many)."""
    proteins = list(dict.fromkeys(protein for protein, _ in places))
    wanted = [("the run", "", OF_RUN)] + [(name, f"{name}/", OF_PROTEIN) for name in proteins]
    wanted += [("/".join(place), "/".join(place) + "/", OF_CONFORMATION) for place in places[:SHOWN]]
    links = [
        (heading, [(words, start + path) for path, words in pages.items() if start + path in shown])
        for heading, start, pages in wanted
    ]
    return [(heading, pages) for heading, pages in links if pages]


if __name__ == "__main__":
    run(main, snakemake)
