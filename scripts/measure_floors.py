"""How far two descriptions of one surface differ: the floors that every Z of a subset is judged by."""

import numpy as np

from sparsurf.molecules.read_molecule import read_molecule, read_own
from sparsurf.study.evaluator import Evaluator, number_of_tests
from sparsurf.study.floors import APART, floors, frames_apart
from sparsurf.study.tables import read_roughness, read_table
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.molecular_surface import layer
from sparsurf.surfaces.radii import radii
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, molecule_options, name, threads):
    """Write floors.csv; for a ready surface with those floors that need no atoms."""
    surface = read_npz(inputs["surface"])
    rough = read_roughness(inputs["roughness"], surface)
    evaluator = Evaluator.from_settings(surface, settings, rough, name, threads).nameless
    atoms = (
        _with_atoms(inputs, settings["surface"], settings["patches"]["D_link"], molecule_options, name)
        if "own" in inputs
        else {}
    )
    n_tests = number_of_tests(settings["evaluation"]["test_dots"], len(surface))
    floors(evaluator, n_tests, **atoms).to_csv(outputs["floors"], index=False)


def _with_atoms(inputs, rules, d_link, molecule_options, name):
    """What `floors` needs of the atoms: their places, how dots are laid on them, and frames before and after."""
    molecule = read_own(inputs["own"])
    own = layer(molecule, 0, radii(molecule, rules["radii"]), rules, d_link, name)
    frames = None
    if "trajectory" in inputs:
        table = read_table(inputs["frames"]).set_index("conformation")
        time = table.loc[name.split("/")[-1], "time_ps"]
        if np.isfinite(time):  # its own time, too: none of the others need be there
            times = [time, *(time + sign * gap for gap in APART for sign in (-1, 1))]
            near = read_molecule(inputs["structure"], inputs["trajectory"], times=times, **molecule_options)
            frames = frames_apart(near, own["atoms"], time)
    return own | {"frames": frames}


if __name__ == "__main__":
    run(main, snakemake)
