"""Tables of other ways to store a surface over all structures: means with intervals, pairs, and where errors are."""

import pandas as pd

from measures import opponents as ways
from measures import recovery
from measures.rebuilding import rebuilders
from measures.tables import cpu_table, read_tables, write_tables
from sparsurf.workflow.jobs import job

COMPARED = (
    *(
        ways.UNIFORM,
        ways.SETTLED,
        ways.WORST,
        ways.WORST_SETTLED,
        ways.SPARSE,
        ways.MESH,
        ways.CORNERS,
        ways.QUANTISED,
    ),
    *rebuilders(),
)
PAIRED = ("Z", "distance", "distance_99", "largest", "back_most", "angle")
WHERE_MEASURES = ("dots_percent", "worst_percent", "mean", "high_99", "largest")
WHERE_GROUPS = ("sampler", "percent", "where")


def main(
    opponents: list[str],
    where: list[str],
    recover_opponents: str,
    recover_opponents_means: str,
    recover_opponents_pairs: str,
    recover_atoms_means: str,
    recover_where: str,
    recover_where_means: str,
    opponents_cpu: str,
    logs: str,
) -> None:
    """Write every table."""
    rows, rows_where = read_tables(opponents), read_tables(where)
    common = ways.in_common(rows)
    atoms = rows[rows["sampler"].isin((ways.ATOMS, ways.ROUNDED_ATOMS))].assign(percent=0)
    measured = set(common["sampler"])
    pairs = [recovery.paired(common, way, ways.KEPT, PAIRED) for way in COMPARED if way in measured]
    write_tables(
        {
            recover_opponents: rows,
            recover_opponents_means: recovery.means(common, ways.MEASURES),
            recover_opponents_pairs: pd.concat(pairs, ignore_index=True),
            recover_atoms_means: recovery.means(atoms, ways.MEASURES).drop(columns="percent"),
            recover_where: rows_where,
            recover_where_means: recovery.means(ways.in_common(rows_where), WHERE_MEASURES, WHERE_GROUPS),
            opponents_cpu: cpu_table(logs),
        }
    )


if __name__ == "__main__":
    with job(snakemake):
        main(
            opponents=snakemake.input.opponents,
            where=snakemake.input.where,
            recover_opponents=snakemake.output.recover_opponents,
            recover_opponents_means=snakemake.output.recover_opponents_means,
            recover_opponents_pairs=snakemake.output.recover_opponents_pairs,
            recover_atoms_means=snakemake.output.recover_atoms_means,
            recover_where=snakemake.output.recover_where,
            recover_where_means=snakemake.output.recover_where_means,
            opponents_cpu=snakemake.output.opponents_cpu,
            logs=snakemake.params.logs,
        )
