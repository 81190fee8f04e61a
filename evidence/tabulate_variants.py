"""The claims of the study of many proteins under each variant of the rules."""

from measures.protein_variants import table
from measures.studies import read_study
from measures.tables import cpu_table, write_tables
from sparsurf.workflow.jobs import job


def main(runs: dict[str, str], proteins: dict[str, list[str]], variants: str, cpu: str) -> None:
    """Write the claims under every variant, from the folder and the proteins of its study."""
    studies = {variant: read_study(run, proteins[variant]) for variant, run in runs.items()}
    logs = [f"{run}/logs" for run in runs.values()]
    write_tables({variants: table(studies), cpu: cpu_table(*logs)})


if __name__ == "__main__":
    with job(snakemake):
        main(
            runs=snakemake.params.runs,
            proteins=snakemake.params.proteins,
            variants=snakemake.output.variants,
            cpu=snakemake.output.cpu,
        )
