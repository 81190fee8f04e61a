"""Join the tables of `measure_answers` of all structures."""

import pandas as pd

from sparsurf.workflow.jobs import job


def main(tables: list[str], answers: str) -> None:
    """Write the rows of all structures, the smallest first."""
    rows = pd.concat([pd.read_csv(table) for table in tables], ignore_index=True)
    rows.sort_values("N", kind="stable").to_csv(answers, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(tables=list(snakemake.input.tables), answers=snakemake.output.answers)
