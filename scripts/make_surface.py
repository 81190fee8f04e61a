"""The molecular surface of one conformation."""

import shutil

from sparsurf.radii import radii
from sparsurf.structure import read_molecule
from sparsurf.surface import molecular_surface, surface_by_dms_program, write_npz
from sparsurf.workflow import job


def main(path_to_input, path_to_structure, path_to_surface, settings):
    """Write the dots of a structure, and the structure itself beside them."""
    molecule = read_molecule(path_to_input, selection="all", whole=False)
    xyz, r = molecule.xyz[0], radii(molecule, settings["radii"])
    if settings["method"] == "dms":
        surface = surface_by_dms_program(path_to_input, settings["probe_radius"], settings["density"])
    else:
        surface = molecular_surface(
            xyz, r, settings["probe_radius"], settings["density"], settings["reentrant"]
        )
    write_npz(path_to_surface, surface)
    shutil.copyfile(path_to_input, path_to_structure)


if __name__ == "__main__":
    with job(snakemake) as output:
        main(
            path_to_input=f"{snakemake.input.structures}/{snakemake.wildcards.conformation}.pdb",
            path_to_structure=output["structure"],
            path_to_surface=output["surface"],
            settings=snakemake.params.settings,
        )
