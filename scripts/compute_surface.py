"""The molecular surface of one conformation."""

import shutil
from dataclasses import replace
from pathlib import Path

from sparsurf.molecules.read_molecule import read_own
from sparsurf.surfaces.components import FIELD, table_of_components
from sparsurf.surfaces.formats.dms import write_dms
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.molecular_surface import components_in, fitting_surface
from sparsurf.surfaces.radii import radii
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, name, tell=True):
    """Write the dots of a structure as npz and as a DMS file, its components, and the structure itself beside them.

    Unless `tell`, the log is silent on a raised density, which d of a grid depends on.
    """
    rules, path_to_input = settings["surface"], f"{inputs['structures']}/{Path(name).name}.pdb"
    molecule = read_own(path_to_input)
    atom_radii = radii(molecule, rules["radii"])
    d_link = settings["patches"]["D_link"]
    surface, _ = fitting_surface(molecule, 0, atom_radii, rules, d_link, name, tell)
    component = components_in(surface, molecule, 0, atom_radii, rules["probe_radius"])
    table_of_components(surface, component).to_csv(outputs["components"], index=False, float_format="%.2f")
    write_npz(outputs["surface"], replace(surface, fields={FIELD: component}))
    write_dms(
        outputs["dms"], surface, molecule.residue_name, molecule.residue, molecule.name, molecule.xyz[0]
    )
    shutil.copyfile(path_to_input, outputs["structure"])


if __name__ == "__main__":
    run(main, snakemake)
