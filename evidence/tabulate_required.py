"""How many dots are enough on many proteins, and how much of the differences is error."""

import pandas as pd

from measures import over_proteins
from measures.tables import cpu_table, write_tables
from sparsurf.workflow.jobs import job


def main(
    tables: list[str], required: str, required_means: str, cpu: str, proteins: list[str], logs: str
) -> None:
    """Write the number of each protein and its distribution."""
    of_proteins = {name: pd.read_csv(path) for name, path in zip(proteins, tables, strict=True)}
    table = over_proteins.required(of_proteins)
    write_tables({required: table, required_means: over_proteins.required_means(table), cpu: cpu_table(logs)})


if __name__ == "__main__":
    with job(snakemake):
        main(
            tables=snakemake.input.tables,
            required=snakemake.output.required,
            required_means=snakemake.output.required_means,
            cpu=snakemake.output.cpu,
            proteins=snakemake.params.proteins,
            logs=snakemake.params.logs,
        )
