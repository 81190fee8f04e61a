"""Compute the surfaces of both partners of a pair that is given by structures."""

from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.settings import Surface as SurfaceSettings
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.molecular_surface import surface_of_molecule
from sparsurf.workflow.jobs import job


def main(
    files: list[str],
    surface_1: str,
    surface_2: str,
    structure_1: str,
    structure_2: str,
    chains: list[list[str]] | None,
    settings: SurfaceSettings,
    d_link: float,
    name: str,
) -> None:
    """Write surface and structure of each partner.

    Parameters
    ----------
    files : two structures, or one complex
    chains : of each partner in the complex; None for two structures
    d_link : float, Å
    name : of the pair
    """
    if chains:
        molecules = [read_molecule(files[0], chains=chains_of_partner) for chains_of_partner in chains]
    else:
        molecules = [read_molecule(file) for file in files]
    outputs = (surface_1, structure_1), (surface_2, structure_2)
    for side, (molecule, (surface, structure)) in enumerate(zip(molecules, outputs, strict=True), 1):
        partner = f"{name}, partner {side}"
        if molecule.n_frames > 1:
            raise InputError(f"{name}: partner {side} has {molecule.n_frames} models; give a file with one.")
        dots = surface_of_molecule(molecule, settings, d_link, partner)
        write_npz(surface, dots)
        molecule.write_pdb(structure)


if __name__ == "__main__":
    with job(snakemake):
        main(
            files=list(snakemake.input),
            surface_1=snakemake.output.surface_1,
            surface_2=snakemake.output.surface_2,
            structure_1=snakemake.output.structure_1,
            structure_2=snakemake.output.structure_2,
            chains=snakemake.params.pair.get("chains"),
            settings=SurfaceSettings(**snakemake.params.surface),
            d_link=snakemake.params.d_link,
            name=snakemake.wildcards.pair,
        )
