"""Tables of the minimal subsets of dense surfaces."""

from measures import recovery
from measures.tables import cpu_table, read_tables, write_tables
from sparsurf.workflow.jobs import job


def main(tables: list[str], recover_dense: str, recover_dense_means: str, dense_cpu: str, logs: str) -> None:
    """Write the rows of all structures, their means and the CPU time."""
    rows = read_tables(tables)
    write_tables(
        {
            recover_dense: rows,
            recover_dense_means: recovery.dense_means(rows),
            dense_cpu: cpu_table(logs),
        }
    )


if __name__ == "__main__":
    with job(snakemake):
        main(
            tables=snakemake.input.tables,
            recover_dense=snakemake.output.recover_dense,
            recover_dense_means=snakemake.output.recover_dense_means,
            dense_cpu=snakemake.output.dense_cpu,
            logs=snakemake.params.logs,
        )
