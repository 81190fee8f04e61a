"""Tables of recovered surfaces over all structures: means with intervals, and pairs of samplers."""

import pandas as pd

from measures import recovery
from measures.tables import cpu_table, read_tables, write_tables
from sparsurf.workflow.jobs import job

PAIRS = (("adaptive", "farthest"), ("roughness", "uniform"))


def main(
    subsets: list[str],
    floors: list[str],
    cost: str,
    recover: str,
    recover_floors: str,
    recover_means: str,
    recover_pairs: str,
    recover_a1: str,
    recover_cpu: str,
    a1: str,
    logs: str,
) -> None:
    """Write every table; the paper's structure, `a1`, has a table of its own."""
    subset_rows, floor_rows = read_tables(subsets), read_tables(floors)
    a1_rows = subset_rows[subset_rows["protein"] == a1].merge(read_tables([cost]), how="cross")
    if subset_rows["protein"].nunique() > 1:
        subset_rows = subset_rows[subset_rows["protein"] != a1]
        floor_rows = floor_rows[floor_rows["protein"] != a1]
    pairs = [recovery.paired(subset_rows, *pair) for pair in PAIRS]
    write_tables(
        {
            recover: subset_rows,
            recover_floors: floor_rows,
            recover_means: recovery.means(subset_rows),
            recover_pairs: pd.concat(pairs, ignore_index=True),
            recover_a1: a1_rows,
            recover_cpu: cpu_table(logs),
        }
    )


if __name__ == "__main__":
    with job(snakemake):
        main(
            subsets=snakemake.input.subsets,
            floors=snakemake.input.floors,
            cost=snakemake.input.cost,
            recover=snakemake.output.recover,
            recover_floors=snakemake.output.recover_floors,
            recover_means=snakemake.output.recover_means,
            recover_pairs=snakemake.output.recover_pairs,
            recover_a1=snakemake.output.recover_a1,
            recover_cpu=snakemake.output.recover_cpu,
            a1=snakemake.params.a1,
            logs=snakemake.params.logs,
        )
