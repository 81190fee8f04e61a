"""Agreement of the maps with the interface, over all pairs of a run.

Run by hand, `python scripts/summarise_pairs.py results/<run> PAIR ...` sums up the pairs that are named, also of a run in
which others failed.
"""

import argparse
import os
import sys
from pathlib import Path

import pandas as pd

from sparsurf.report.front_page import links_to_pairs
from sparsurf.report.html import write_first_page
from sparsurf.report.pair_page import pairs_markdown
from sparsurf.study.complexes import means_over_complexes
from sparsurf.workflow.jobs import run


def main(inputs, outputs, without=()):
    """Write pairs.csv, a row per pair, partner and score, and their means; tables end in pairs/<pair>/agreement.csv.

    In a run of pairs alone the page is the run's first, too; it begins with those it is `without`, see `front_page`.
    """
    tables = [pd.read_csv(path).assign(complex=Path(path).parent.name) for path in inputs["tables"]]
    table = pd.concat(tables)
    means = means_over_complexes(table, ["score"])
    table.to_csv(outputs["table"], index=False)
    means.to_csv(outputs["means"], index=False)
    known = (means, len(tables), table["complex"].nunique())
    Path(outputs["page"]).write_text(pairs_markdown(*known), encoding="utf-8")
    if "html" in outputs:
        folder = Path(inputs["tables"][0]).parents[2]
        held, beside = (
            [str(Path(path).relative_to(folder)) for path in inputs[key]] for key in ("pages", "beside")
        )
        links = links_to_pairs([*beside, *held])
        page = pairs_markdown(*known, f"Results of the run {folder.name}", links, without)
        write_first_page(page, folder, outputs, held)


def by_hand(arguments=None):
    """Sum up pairs whose tables are complete; what is written is older than they, so that Snakemake makes it anew."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=Path, help="results/<run>")
    parser.add_argument("pairs", nargs="+", help="names of pairs, in this order")
    parser.add_argument(
        "--without", nargs=2, action="append", default=[], metavar=("PAIR", "REASON"),
        help="in a run of pairs alone, whose first page is written: pairs/<name> that could not be finished, and why",
    )  # fmt: skip
    wish = parser.parse_args(arguments)
    pairs = wish.run / "pairs"
    tables = [pairs / name / "agreement.csv" for name in wish.pairs]
    for path in tables:
        if not path.is_file():
            parser.error(f"{path} is not there: this pair is not finished.")
    inputs = {"tables": tables, "pages": []}
    inputs["beside"] = [path for table in tables for path in sorted(table.parent.iterdir())]
    outputs = {"table": pairs / "pairs.csv", "means": pairs / "means.csv", "page": pairs / "pairs.md"}
    if wish.without:
        outputs |= {key: wish.run / f"index.{key}" for key in ("md", "html")}
    main(inputs, outputs, wish.without)
    before = min(path.stat().st_mtime for path in tables) - 1
    for key in ("table", "means", "page"):
        os.utime(outputs[key], (before, before))


if __name__ == "__main__":
    if "snakemake" not in globals():
        by_hand()
        sys.exit()
    run(main, snakemake)
