"""The molecular surface of one conformation."""

import shutil

from sparsurf.dots import fitting_density, molecular_surface, surface_by_dms_program
from sparsurf.exports import write_dms
from sparsurf.radii import radii
from sparsurf.structure import read_molecule
from sparsurf.surface import write_npz
from sparsurf.workflow import job


def main(path_to_input, path_to_structure, path_to_surface, path_to_dms, settings, d_link, name):
    """Write the dots of a structure as npz and as a DMS file, and the structure itself beside them."""
    molecule = read_molecule(path_to_input, selection="all", whole=False)
    xyz, r = molecule.xyz[0], radii(molecule, settings["radii"])
    density = fitting_density(xyz, r, settings, d_link, name)
    if settings["method"] == "dms":
        surface = surface_by_dms_program(path_to_input, settings["probe_radius"], density)
    else:
        surface = molecular_surface(xyz, r, settings["probe_radius"], density, settings["reentrant"])
    write_npz(path_to_surface, surface)
    write_dms(path_to_dms, surface, molecule.residue_name, molecule.residue, molecule.name, xyz)
    shutil.copyfile(path_to_input, path_to_structure)


if __name__ == "__main__":
    with job(snakemake) as output:
        main(
            path_to_input=f"{snakemake.input.structures}/{snakemake.wildcards.conformation}.pdb",
            path_to_structure=output["structure"],
            path_to_surface=output["surface"],
            path_to_dms=output["dms"],
            settings=snakemake.params.settings,
            d_link=snakemake.params.d_link,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
        )
