"""Tables of the centres over all proteins: the best of each range compared with the centres filled up uniformly."""

import pandas as pd

from measures.tables import cpu_table, read_tables, write_tables
from sparsurf.study.relation import with_interval
from sparsurf.workflow.jobs import job

MEASURES = ("n_S_percent", "d_mean", "d_centres_mean", "d", "d_centres")


def means(table: pd.DataFrame) -> pd.DataFrame:
    """Return means of d over proteins by reading and range: of all combinations, of the best and of the control."""
    rows = []
    for (reading, number), part in table.groupby(["reading", "range"], sort=False):
        row = {"reading": reading, "range": number, "n": int(part["d"].notna().sum())}
        for measure in MEASURES:
            row |= with_interval(measure, part[measure])
        row |= {key: 100 * part[key].sum() / part["n_combinations"].sum() for key in ("n_above", "n_below")}
        rows.append(row)
    return pd.DataFrame(rows)


def main(tables: list[str], centres: str, centres_means: str, centres_cpu: str, logs: str) -> None:
    """Write the rows of all proteins, their means and the CPU time."""
    rows = read_tables(tables)
    write_tables({centres: rows, centres_means: means(rows), centres_cpu: cpu_table(logs)})


if __name__ == "__main__":
    with job(snakemake):
        main(
            tables=snakemake.input.tables,
            centres=snakemake.output.centres,
            centres_means=snakemake.output.centres_means,
            centres_cpu=snakemake.output.centres_cpu,
            logs=snakemake.params.logs,
        )
