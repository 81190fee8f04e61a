"""Describe the places of one conformation by numbers, so that a site can be found on other surfaces."""

from sparsurf.molecules.read_molecule import read_study_structure
from sparsurf.sites.describing import describe_surface
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import job


def main(surface: str, structure: str | None, sites: str, name: str, threads: int = 1) -> None:
    """Write the places of a surface, with their residues where there is a structure.

    Parameters
    ----------
    structure : None for a ready surface
    sites : file to be written
    name : protein/conformation
    """
    molecule = read_study_structure(structure) if structure else None
    describe_surface(read_npz(surface), molecule, name, threads=threads).save(sites)


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface=snakemake.input.surface,
            structure=snakemake.input.structure or None,
            sites=snakemake.output.sites,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            threads=snakemake.threads,
        )
