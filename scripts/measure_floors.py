"""How far two descriptions of one surface differ: the floors that every Z of a subset is judged by."""

from dataclasses import replace

import numpy as np
import pandas as pd

from sparsurf.molecules.reading import read_molecule
from sparsurf.study.evaluator import Evaluator, number_of_tests
from sparsurf.study.floors import APART, floors, frames_apart
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.making import fitting_density, surface_of
from sparsurf.surfaces.radii import radii
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, reading, name, threads):
    """Write floors.csv; for a ready surface with those floors that need no atoms."""
    surface = read_npz(inputs["surface"])
    rough = pd.read_csv(inputs["roughness"])["roughness"].to_numpy()
    evaluator = Evaluator.from_settings(surface, settings, rough, name, threads)
    atoms = (
        _with_atoms(inputs, settings["surface"], settings["patches"]["D_link"], reading, name)
        if "own" in inputs
        else {}
    )
    n_tests = number_of_tests(settings["evaluation"]["test_dots"], len(surface))
    floors(evaluator, n_tests, **atoms).to_csv(outputs["floors"], index=False)


def _with_atoms(inputs, rules, d_link, reading, name):
    """What `floors` needs of the atoms: their places, how dots are laid on them, and frames before and after."""
    molecule = read_molecule(inputs["own"], selection="all", whole=False)
    atom_radii, atoms = radii(molecule, rules["radii"]), molecule.xyz[0]
    rules = rules | {"density": fitting_density(molecule, 0, atom_radii, rules, d_link, name, tell=False)}

    def lay(xyz):
        return surface_of(replace(molecule, xyz=xyz[None]), 0, atom_radii, rules)

    frames = None
    if "trajectory" in inputs:
        table = pd.read_csv(inputs["frames"]).set_index("conformation")
        time = table.loc[name.split("/")[-1], "time_ps"]
        if np.isfinite(time):  # its own time, too: none of the others need be there
            times = [time, *(time + sign * gap for gap in APART for sign in (-1, 1))]
            near = read_molecule(inputs["structure"], inputs["trajectory"], times=times, **reading)
            frames = frames_apart(near, atoms, time)
    return {"lay": lay, "atoms": atoms, "frames": frames}


if __name__ == "__main__":
    run(main, snakemake)
