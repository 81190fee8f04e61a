"""Agreement of the maps with the interface, over all pairs of a run."""

from pathlib import Path

import pandas as pd

from sparsurf.pairs.complexes import means_over_complexes
from sparsurf.report.page import write
from sparsurf.report.pair_page import OF_ALL, pairs_page
from sparsurf.workflow.jobs import run


def main(inputs, outputs):
    """Write pairs.csv, a row per pair, partner and score, their means and a page; tables end in pairs/<pair>/agreement.csv."""
    paths = [Path(path) for path in inputs["tables"]]
    table = pd.concat([pd.read_csv(path).assign(complex=path.parent.name) for path in paths])
    means = means_over_complexes(table, ["score"])
    table.to_csv(outputs["table"], index=False)
    means.to_csv(outputs["means"], index=False)
    known = pairs_page(paths[0].parts[-4], means, len(paths), table["complex"].nunique(), table)
    write(outputs["page"], OF_ALL, **known)


if __name__ == "__main__":
    run(main, snakemake)
