"""Write a structure from an archive to a file of its own."""

from pathlib import Path

from sparsurf.files import read_bytes
from sparsurf.workflow.jobs import job


def main(member: str, structure: str) -> None:
    """Copy a member of an archive, uncompressed.

    Parameters
    ----------
    member : path of the member, see `archives`
    structure : file to be written
    """
    Path(structure).write_bytes(read_bytes(member))


if __name__ == "__main__":
    with job(snakemake):
        main(member=snakemake.params.member, structure=snakemake.output.structure)
