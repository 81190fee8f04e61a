"""How often places are found on the same protein and on relatives, by family and over all, next to alignments."""

import pandas as pd

from measures.tables import read_tables, write_tables
from sparsurf.study.relation import with_interval
from sparsurf.workflow.jobs import job

SAME, RELATIVES = "the same protein", "all relatives"
WITH_INTERVALS = ("first", "first_percent", "auc", "first_moved")
MEANS = ("chance", "there", "whole")


def main(tables: list[str], table: str, means: str, identity: list[float]) -> None:
    """Write all rows of pairs as alike as `identity` says, and means over proteins with 95 % intervals."""
    rows = read_tables(tables)
    same = rows["family"] == SAME
    rows = rows[same | rows["identity"].between(*identity)]
    every = rows[rows["family"] != SAME].assign(family=RELATIVES)
    write_tables({table: rows, means: means_over_proteins(pd.concat([rows, every]))}, "%.4g")


def means_over_proteins(rows: pd.DataFrame) -> pd.DataFrame:
    """Average over the relatives of each query, then over the queries, as the pairs of one protein are not independent.

    Returns
    -------
    DataFrame, a row per family, channels and kind of place: pairs, proteins (queries), least and most identity, means of
    `MEANS`, and means of `WITH_INTERVALS` with `_low` and `_high`
    """
    out = []
    for key, group in rows.groupby(["family", "channels", "places"], sort=False):
        by_query = group.groupby("query")[[*WITH_INTERVALS, *MEANS]].mean()
        row = dict(zip(("family", "channels", "places"), key, strict=True))
        row |= {"pairs": len(group), "proteins": len(by_query)}
        row |= {"least": group["identity"].min(), "most": group["identity"].max()}
        for name in WITH_INTERVALS:
            row |= with_interval(name, by_query[name])
        out.append(row | by_query[list(MEANS)].mean().to_dict())
    return pd.DataFrame(out)


if __name__ == "__main__":
    with job(snakemake):
        main(
            tables=snakemake.input.tables,
            table=snakemake.output.table,
            means=snakemake.output.means,
            identity=snakemake.params.identity,
        )
