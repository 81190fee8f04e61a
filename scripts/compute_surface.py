"""Compute the molecular surface of one conformation."""

import shutil
from dataclasses import replace
from pathlib import Path

from sparsurf.molecules.read_molecule import read_study_structure
from sparsurf.settings import Surface as SurfaceSettings
from sparsurf.surfaces.components import COMPONENT_FIELD, table_of_components
from sparsurf.surfaces.formats.dms import write_dms
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.molecular_surface import surface_of_molecule
from sparsurf.workflow.jobs import job


def main(
    structures: str,
    surface: str,
    structure: str,
    dms: str,
    components: str,
    settings: SurfaceSettings,
    d_link: float,
    name: str,
) -> None:
    """Write the dots of a structure as npz and DMS file, the components of its surface, and the structure itself.

    Parameters
    ----------
    structures : folder with a PDB file for each conformation
    name : protein/conformation
    """
    path = Path(structures, f"{Path(name).name}.pdb")
    molecule = read_study_structure(path)
    dots = surface_of_molecule(molecule, settings, d_link, name)
    component = dots.known_origin(name).components(dots)
    table_of_components(dots, component).to_csv(components, index=False, float_format="%.2f")
    write_npz(surface, replace(dots, fields={COMPONENT_FIELD: component}))
    write_dms(dms, dots, molecule.residue_name, molecule.residue, molecule.name, molecule.xyz[0])
    shutil.copyfile(path, structure)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structures=snakemake.input.structures,
            surface=snakemake.output.surface,
            structure=snakemake.output.structure,
            dms=snakemake.output.dms,
            components=snakemake.output.components,
            settings=SurfaceSettings(**snakemake.params.surface),
            d_link=snakemake.params.d_link,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
        )
