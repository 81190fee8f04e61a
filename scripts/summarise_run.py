"""All surfaces of a run in one table, and the best parameters against their mean roughness.

Run by hand, `python scripts/summarise_run.py results/<run> --R-patch 4 --D-link 0.5` sums up what is there, also of a
run that failed in part; `p/c1 p/c2 ...` behind it, only that, in that order.
"""

import argparse
import sys
from pathlib import Path

from sparsurf import InputError
from sparsurf.report.figures import few_surfaces, layout, summary_figures
from sparsurf.report.summary_page import summary_markdown
from sparsurf.streams import stream
from sparsurf.study.summary import (
    FILES,
    read_result,
    relation_table,
    summary_table,
    surfaces_table,
)
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings):
    """Write surfaces.csv, summary.csv, relation.csv, summary.md and the figure."""
    results = [
        read_result(folder) for folder in dict.fromkeys(Path(path).parent for path in inputs["results"])
    ]
    surfaces, summary = surfaces_table(results, settings["patches"]), summary_table(results)
    relations = relation_table(results, summary, stream(settings["seed"], "summary"))
    for key, table in {"surfaces": surfaces, "summary": summary, "relation": relations}.items():
        table.to_csv(outputs[key], index=False)
    page = summary_markdown(surfaces, relations, results[0].best.get("draws"))
    Path(outputs["markdown"]).write_text(page, encoding="utf-8")
    few = len(results) < few_surfaces.FEW
    figure = few_surfaces.draw(summary) if few else summary_figures.summary_figure(summary, relations)
    layout.save(figure, outputs["png"].removesuffix(".png"))


def by_hand(arguments=None):
    """Sum up the conformations of a folder whose results are complete; without the svg, which Snakemake makes anew."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=Path, help="results/<run>")
    parser.add_argument("places", nargs="*", help="<protein>/<conformation>, in this order (default: all)")
    parser.add_argument("--R-patch", type=float, required=True, help="Å, as in the run's config")
    parser.add_argument("--D-link", type=float, required=True, help="Å, as in the run's config")
    parser.add_argument("--seed", type=int, default=0, help="as in the run's config (default 0)")
    wish = parser.parse_args(arguments)
    folders = [wish.run / place for place in wish.places]
    folders = folders or sorted(path.parent for path in wish.run.glob(f"*/*/{FILES[-1]}"))
    folders = [folder for folder in folders if all((folder / file).is_file() for file in FILES)]
    if not folders:
        parser.error(f"{wish.run} holds no finished conformation.")
    outputs = {key: wish.run / f"{key}.csv" for key in ("surfaces", "summary", "relation")}
    outputs |= {"markdown": wish.run / "summary.md", "png": str(wish.run / "summary.png")}
    settings = {"patches": {"R_patch": wish.R_patch, "D_link": wish.D_link}, "seed": wish.seed}
    try:
        main({"results": [folder / FILES[0] for folder in folders]}, outputs, settings)
    except InputError as error:
        parser.error(str(error))
    (wish.run / "summary.svg").unlink()  # and with it all the others


if __name__ == "__main__":
    if "snakemake" not in globals():
        by_hand()
        sys.exit()
    run(main, snakemake)
