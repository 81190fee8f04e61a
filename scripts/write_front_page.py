"""The first page of a run, as Markdown, as HTML, and as the first page of the report.

Run by hand, `python scripts/write_front_page.py results/<run> --without PROTEIN REASON` writes the first two of what there
is, also of a run that failed in part.
"""

import argparse
import json
import sys
from pathlib import Path

import pandas as pd

from sparsurf.patches.readings import TEXT
from sparsurf.report.front_page import SHOWN, YARDSTICKS, front_page, links_to_pairs
from sparsurf.report.html import write_first_page
from sparsurf.study.enough import enough
from sparsurf.workflow.jobs import run

NAMES = {"protein": str, "conformation": str}  # "012" is a name
PART = ".front_page.html"
OF_RUN = {"summary.md": "all surfaces, range by range", "summary.csv": "as a table"}
OF_RUN |= {"summary.png": "against mean roughness", "verdict.html": "the paper, claim by claim"}
OF_RUN |= {"compare.md": "samplers compared", "compare.png": "as a figure", "pairs/pairs.md": "all pairs"}
OF_RUN |= {"report.html": "all in one page"}
OF_PROTEIN = {"figures/simulation.png": "simulation", "simulation/quality.csv": "its quality"}
OF_PROTEIN |= {"figures/frames.png": "frames", "figures/ensemble.png": "over time"}
OF_PROTEIN |= {"figures/residues.png": "residues over time"}
OF_CONFORMATION = {"view.html": "to turn and sample", "figures/roughness.png": "roughness"}
OF_CONFORMATION |= {
    "figures/number_of_dots.png": "number of dots",
    "figures/d_over_grid.png": "d over the grid",
}
OF_CONFORMATION |= {"figures/rough_and_flat.png": "rough and flat", "figures/subsets.png": "the subsets"}
OF_CONFORMATION |= {"minimal.csv": "minimal subset", "enough.csv": "how many dots are enough"}
OF_CONFORMATION |= {"floors.csv": "noise floors", "best.md": "best of all", "ranges.csv": "best per range"}
OF_CONFORMATION |= {"ranges.md": "as text", "residues.csv": "residues"}
OF_CONFORMATION |= {"compare.md": "samplers compared", "figures/compare.png": "as a figure"}


def main(inputs, outputs, without=()):
    """Write index.md, index.html and the part of the report; see `front_page` for `without`.

    They link to `pages`, which the report holds, and to what is `beside` it.
    """
    folder = Path(inputs["surfaces"]).parent
    needed = (pd.read_csv(path, dtype={"bound": str}).fillna({"bound": ""}) for path in inputs["needed"])
    fewer = next(needed, None)
    places = [tuple(Path(path).parts[-3:-1]) for path in inputs["minimal"]]
    surfaces = pd.read_csv(inputs["surfaces"], dtype=NAMES).set_index([*NAMES]).loc[places].reset_index()
    handed_out = pd.DataFrame(places, columns=[*NAMES])
    handed_out["dots"] = [len(pd.read_csv(path)) for path in inputs["minimal"]]
    reached = pd.concat([pd.read_csv(path) for path in inputs["enough"]])
    found = []
    for place, path in zip(places, inputs["best"], strict=True):
        grid = pd.read_csv(Path(path).with_name("grid.csv"))
        best = json.loads(Path(path).read_text(encoding="utf-8"))
        reading = TEXT if TEXT in best else next(name for name in best if f"d_{name}" in grid)
        sticks = best["yardsticks"]
        floors = {name: z for name, z in sticks.get("floors", {}).items() if name in YARDSTICKS}
        own = enough(grid, sticks["null_model"], floors, reading)
        found.append(own.assign(protein=place[0], conformation=place[1]))
    held, beside = (
        [str(Path(path).relative_to(folder)) for path in inputs[key]] for key in ("pages", "beside")
    )
    shown = dict.fromkeys([*held, *beside, *(["report.html"] if "part" in outputs else [])])
    links = links_to(places, shown) + links_to_pairs(shown)
    draws = best.get("draws")  # the same of all: the config's
    page = front_page(
        folder.name, surfaces, pd.concat(found), reached, handed_out, fewer, links, without, draws
    )
    write_first_page(page, folder, outputs, held)


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


def are_there(folder, files):
    """Whether a conformation has all files, none older than its surface where that was kept."""
    surface = folder / "surface.npz"
    since = surface.stat().st_mtime if surface.is_file() else 0
    return all((folder / file).is_file() and (folder / file).stat().st_mtime >= since for file in files)


def by_hand(arguments=None):
    """Write the page of the conformations of surfaces.csv whose results are complete."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=Path, help="results/<run>")
    parser.add_argument(
        "--without", nargs=2, action="append", default=[], metavar=("PROTEIN", "REASON"),
        help="a protein, or pairs/<name>, that could not be finished, and why",
    )  # fmt: skip
    wish = parser.parse_args(arguments)
    surfaces = wish.run / "surfaces.csv"
    if not surfaces.is_file():
        parser.error(f"{wish.run} has no surfaces.csv: scripts/summarise_run.py writes it.")
    names = pd.read_csv(surfaces, dtype=NAMES)[[*NAMES]].to_numpy()
    files = {
        key: f"{key}.{'json' if key == 'best' else 'csv'}" for key in ("best", "minimal", "enough", "grid")
    }
    folders = [wish.run / protein / conformation for protein, conformation in names]
    folders = [folder for folder in folders if are_there(folder, files.values())]
    if not folders:
        sys.exit(f"{wish.run} holds no finished conformation: there is nothing to write a page of.")
    inputs = {key: [str(folder / file) for folder in folders] for key, file in files.items()}
    compared = wish.run / "compare_needed.csv"
    since = max(path.stat().st_mtime for path in map(Path, inputs["grid"]))
    of_these = compared.is_file() and compared.stat().st_mtime >= since  # not of an earlier run
    inputs |= {"needed": [compared] if of_these else []}
    # the report is of an earlier run
    beside = [path for path in sorted(wish.run.rglob("*.*")) if path.name != "report.html"]
    inputs |= {"surfaces": surfaces, "pages": [], "beside": beside}
    (wish.run / PART).unlink(missing_ok=True)  # asks Snakemake to make all three anew
    main(inputs, {key: wish.run / f"index.{key}" for key in ("md", "html")}, wish.without)


if __name__ == "__main__":
    if "snakemake" not in globals():
        by_hand()
        sys.exit()
    run(main, snakemake)
