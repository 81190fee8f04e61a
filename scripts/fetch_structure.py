"""A structure from the network enters the study."""

from sparsurf.download import fetch, source
from sparsurf.workflow import job


def main(protein, path_to_structure, path_to_record, name):
    """Fetch and verify a structure."""
    fetch(source(protein), protein.get("sha256"), path_to_structure, path_to_record, name)


if __name__ == "__main__":
    with job(snakemake) as output:
        main(
            protein=snakemake.params.protein,
            path_to_structure=output["structure"],
            path_to_record=output["record"],
            name=snakemake.wildcards.protein,
        )
