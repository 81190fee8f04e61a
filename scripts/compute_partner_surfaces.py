"""The surfaces of both partners of a pair that is given by structures."""

from sparsurf import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.molecular_surface import fitting_surface
from sparsurf.surfaces.radii import radii
from sparsurf.workflow.jobs import run
from sparsurf.workflow.partner_files import SIDES


def main(inputs, outputs, pair, settings, name):
    """Write surface and structure of each partner: the chains named of one complex, or two files."""
    if "complex" in pair:
        molecules = [read_molecule(inputs["complex"], chains=chains) for chains in pair["chains"]]
    else:
        molecules = [read_molecule(inputs[key]) for key in ("first", "second")]
    for side, molecule in zip(SIDES, molecules, strict=True):
        if molecule.n_frames > 1:
            raise InputError(f"{name}: partner {side} has {molecule.n_frames} models; give a file with one.")
        sizes = radii(molecule, settings["surface"]["radii"])
        rules, which = settings["surface"], f"{name}, partner {side}"
        surface, _ = fitting_surface(molecule, 0, sizes, rules, settings["patches"]["D_link"], which)
        write_npz(outputs[f"surface_{side}"], surface)
        molecule.write_pdb(outputs[f"structure_{side}"])


if __name__ == "__main__":
    run(main, snakemake)
