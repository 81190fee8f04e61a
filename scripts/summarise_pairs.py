"""Agreement of the maps with the interface, over all pairs of a run."""

from pathlib import Path

import pandas as pd

from sparsurf.pairs.complexes import means_over_complexes
from sparsurf.report.figures import layout
from sparsurf.report.figures.pair_figures import over_pairs
from sparsurf.report.page import write
from sparsurf.report.pair_page import OF_ALL, pairs_page
from sparsurf.workflow.jobs import run


def main(inputs, outputs):
    """Write pairs.csv, a row per pair, partner and score, their means, figure and page; tables end in <pair>/agreement.csv."""
    paths = [Path(path) for path in inputs["tables"]]
    table = pd.concat([pd.read_csv(path).assign(complex=path.parent.name) for path in paths])
    means = means_over_complexes(table, ["score"])
    table.to_csv(outputs["table"], index=False)
    means.to_csv(outputs["means"], index=False)
    layout.save(over_pairs(paths[0].parts[-4], table, means), outputs["png"].removesuffix(".png"))
    known = pairs_page(paths[0].parts[-4], means, len(paths), table["complex"].nunique(), table)
    write(outputs["page"], OF_ALL, **known)


if __name__ == "__main__":
    run(main, snakemake)
