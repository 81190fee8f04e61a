"""Fetch a structure from the network."""

from sparsurf.workflow.download import fetch
from sparsurf.workflow.jobs import job


def main(structure: str, record: str, url: str, sha256: str | None, name: str) -> None:
    """Fetch and verify a structure, and record where it came from.

    Parameters
    ----------
    structure, record : files to be written
    sha256 : checksum that the file must have; None to take any
    name : of the protein
    """
    fetch(url, sha256, structure, record, name)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.output.structure,
            record=snakemake.output.record,
            url=snakemake.params.url,
            sha256=snakemake.params.sha256,
            name=snakemake.wildcards.protein,
        )
