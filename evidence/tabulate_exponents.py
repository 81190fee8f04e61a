"""Whether any exponent gains over evenly distributed dots."""

from measures import exponents as exponents_of
from measures.tables import cpu_table, read_tables, write_tables
from sparsurf.workflow.jobs import job


def main(
    tables: list[str],
    exponents: str,
    exponents_means: str,
    exponents_best: str,
    exponents_cpu: str,
    logs: str,
) -> None:
    """Write the measured Z, their ratios to k = 0, and the gain of the best exponent."""
    rows = read_tables(tables)
    write_tables(
        {
            exponents: rows,
            exponents_means: exponents_of.ratios(rows),
            exponents_best: exponents_of.best(rows),
            exponents_cpu: cpu_table(logs),
        }
    )


if __name__ == "__main__":
    with job(snakemake):
        main(
            tables=snakemake.input.tables,
            exponents=snakemake.output.exponents,
            exponents_means=snakemake.output.exponents_means,
            exponents_best=snakemake.output.exponents_best,
            exponents_cpu=snakemake.output.exponents_cpu,
            logs=snakemake.params.logs,
        )
