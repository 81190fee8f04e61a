"""The subset of a surface that is handed out, which is enough to have the surface back."""

import pandas as pd

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.patches.readings import TEXT
from sparsurf.recovery.errors import DENSE, curvature, off_recovered, tails
from sparsurf.sampling.combination import choices_of
from sparsurf.study.enough import CLOSE, UNIFORM, Trials, curves_table, enough_dots
from sparsurf.study.evaluator import Evaluator, number_of_tests
from sparsurf.study.handing_out import hand_out
from sparsurf.surfaces.formats.csv import DIGITS
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, name, threads=1, whole=True):
    """Write the subset, what is enough, Z over n_S, and the errors of the surface that the subset gives back.

    The paper's sampler takes its parameters from ranges.csv. Unless the `whole` curve of recovered surfaces is asked for, it ends
    at the lowest floor.
    """
    surface = read_npz(inputs["surface"])
    rough = pd.read_csv(inputs["roughness"])["roughness"].to_numpy()
    asked = settings["minimal"]
    evaluator = Evaluator.from_settings(surface, settings, rough, name, 1).nameless
    choices = choices_of(pd.read_csv(inputs["ranges"]) if "ranges" in inputs else None)
    n_tests = number_of_tests(settings["evaluation"]["test_dots"], len(surface))
    floors = pd.read_csv(inputs["floors"])
    trials = Trials(evaluator, asked["sampler"], n_tests, choices, asked["settle"])
    own = inputs.get("structure")
    molecule = read_molecule(own, selection="all", whole=False) if own else None
    subset = hand_out(trials, asked, floors, molecule)
    trials.down_to = -1 if whole else CLOSE * floors["Z"].min()
    handed_out = (asked["floor"], len(subset.dots)) if "floor" in asked else None
    enough_dots(trials, floors, handed_out=handed_out).to_csv(outputs["enough"], index=False)
    curves = [curves_table(trials)]
    if asked["sampler"] != UNIFORM:
        curves.append(curves_table(Trials(evaluator, UNIFORM, n_tests), (TEXT,)))
    pd.concat(curves).to_csv(outputs["curves"], index=False)
    off = off_recovered(surface.points, subset.surface.points, subset.surface.normals, threads, DENSE)
    tails(off, curvature(evaluator.index, threads=threads)).to_csv(outputs["recovered"], index=False)
    table = subset.table
    table.to_csv(outputs["table"], index=False, float_format=DIGITS)
    columns = {key: table[key].to_numpy(float) for key in ("spacing", "reach")}
    write_ply(outputs["ply"], subset.surface, subset.weight.astype(float), "weight", columns)


if __name__ == "__main__":
    run(main, snakemake)
