"""Sites of cofactors sought on proteins of other folds, by `find` and by simpler ways."""

from measures import cofactors
from measures.tables import write_tables
from sparsurf.workflow.jobs import job


def main(sites: str, table: str, means: str) -> None:
    """Write a row per query, target and method, and their means; files of each site lie next to the table of sites."""
    entries, molecules, ligands = cofactors.read_sites(sites)
    rows = cofactors.measure(
        entries["name"].to_list(),
        entries["class"].to_list(),
        [text.split() for text in entries["site_residues"]],
        molecules,
        ligands,
    )
    write_tables({table: rows, means: cofactors.means(rows)}, "%.4g")


if __name__ == "__main__":
    with job(snakemake):
        main(
            sites=snakemake.input.sites,
            table=snakemake.output.table,
            means=snakemake.output.means,
        )
