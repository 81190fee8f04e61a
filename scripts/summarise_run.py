"""All surfaces of a run in one table, and the best parameters against their mean roughness.

Run by hand, `python scripts/summarise_run.py results/<run>` sums up what is there, also of a run that failed in part.
"""

import argparse
import sys
from pathlib import Path

from sparsurf import InputError, page, summary_figures
from sparsurf.parallel import stream
from sparsurf.patches import D_LINK, R_PATCH
from sparsurf.summary import (
    FILES,
    read_result,
    relation_table,
    summary_markdown,
    summary_table,
    surfaces_table,
)
from sparsurf.workflow import job


def main(folders, paths, path_to_figure, patches, seed):
    """Write surfaces.csv, summary.csv, relation.csv, summary.md and the figure."""
    results = [read_result(folder) for folder in folders]
    surfaces, summary = surfaces_table(results, patches), summary_table(results)
    relations = relation_table(results, summary, stream(seed, "summary"))
    for key, table in {"surfaces": surfaces, "summary": summary, "relation": relations}.items():
        table.to_csv(paths[key], index=False)
    Path(paths["markdown"]).write_text(summary_markdown(surfaces, relations), encoding="utf-8")
    page.save(summary_figures.summary_figure(summary, relations), path_to_figure)


def by_hand(arguments=None):
    """Sum up the conformations of a folder whose results are complete."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=Path, help="results/<run>")
    parser.add_argument(
        "--R-patch", type=float, default=R_PATCH, help="Å, as in the run's config (default 4)"
    )
    parser.add_argument(
        "--D-link", type=float, default=D_LINK, help="Å, as in the run's config (default 0.5)"
    )
    wish = parser.parse_args(arguments)
    folders = sorted({path.parent for path in wish.run.glob(f"*/*/{FILES[-1]}")})
    folders = [folder for folder in folders if all((folder / file).is_file() for file in FILES)]
    if not folders:
        parser.error(f"{wish.run} holds no finished conformation.")
    paths = {key: wish.run / f"{key}.csv" for key in ("surfaces", "summary", "relation")}
    paths["markdown"] = wish.run / "summary.md"
    try:
        main(folders, paths, wish.run / "summary", {"R_patch": wish.R_patch, "D_link": wish.D_link}, 0)
    except InputError as error:
        parser.error(str(error))


if __name__ == "__main__":
    if "snakemake" not in globals():
        by_hand()
        sys.exit()
    with job(snakemake) as output:
        main(
            folders=list(dict.fromkeys(Path(path).parent for path in snakemake.input)),
            paths={key: output[key] for key in ("surfaces", "summary", "relation", "markdown")},
            path_to_figure=output["png"].removesuffix(".png"),
            patches=snakemake.params.patches,
            seed=snakemake.params.seed,
        )
