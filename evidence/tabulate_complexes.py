"""Tables over many complexes, with every descriptor."""

from measures.complex_tables import tables_of
from measures.tables import cpu_table, read_tables, write_tables
from sparsurf.workflow.jobs import job


def main(
    areas: list[str],
    contacts: list[str],
    control: list[str],
    complexes: str,
    complexes_means: str,
    complexes_variants: str,
    complexes_contacts: str,
    complexes_control: str,
    complexes_cpu: str,
    chosen_on: int,
    logs: str,
) -> None:
    """Write every table; contacts are those of the bound forms."""
    touching = read_tables(contacts)
    touching = touching[touching["form"] == "bound"]
    tables = tables_of(read_tables(areas), touching, read_tables(control), chosen_on)
    write_tables(
        {
            complexes: tables["complexes"],
            complexes_means: tables["complexes_means"],
            complexes_variants: tables["complexes_variants"],
            complexes_contacts: tables["complexes_contacts"],
            complexes_control: tables["complexes_control"],
            complexes_cpu: cpu_table(logs),
        },
        "%.4f",
    )


if __name__ == "__main__":
    with job(snakemake):
        main(
            areas=snakemake.input.areas,
            contacts=snakemake.input.contacts,
            control=snakemake.input.control,
            complexes=snakemake.output.complexes,
            complexes_means=snakemake.output.complexes_means,
            complexes_variants=snakemake.output.complexes_variants,
            complexes_contacts=snakemake.output.complexes_contacts,
            complexes_control=snakemake.output.complexes_control,
            complexes_cpu=snakemake.output.complexes_cpu,
            chosen_on=snakemake.params.chosen_on,
            logs=snakemake.params.logs,
        )
