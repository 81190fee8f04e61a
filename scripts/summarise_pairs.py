"""Agreement of the maps with the interface, over all pairs of a run."""

from pathlib import Path

import pandas as pd

from sparsurf.report.pair_page import pairs_markdown
from sparsurf.study.complexes import means_over_complexes
from sparsurf.workflow.jobs import run


def main(inputs, outputs):
    """Write pairs.csv, a row per pair, partner and score, and their means; tables end in <pair>/agreement.csv."""
    tables = [pd.read_csv(path).assign(complex=Path(path).parent.name) for path in inputs["tables"]]
    table = pd.concat(tables)
    means = means_over_complexes(table, ["score"])
    table.to_csv(outputs["table"], index=False)
    means.to_csv(outputs["means"], index=False)
    with open(outputs["page"], "w", encoding="utf-8") as stream:
        stream.write(pairs_markdown(means, len(tables), table["complex"].nunique()))


if __name__ == "__main__":
    run(main, snakemake)
