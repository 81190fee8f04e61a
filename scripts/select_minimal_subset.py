"""The subset of a surface that is handed out, which is enough to have the surface back."""

import logging
from dataclasses import replace

import numpy as np
import pandas as pd

from sparsurf.dot_fields.registry import FIELDS, values
from sparsurf.molecules.read_molecule import read_own
from sparsurf.patches.readings import TEXT
from sparsurf.recovery.errors import DENSE, curvature, off_recovered, tails
from sparsurf.recovery.fields import recovery_table
from sparsurf.sampling.combination import OF_PAPER, choices_of
from sparsurf.sampling.samplers import farthest
from sparsurf.study.enough import CLOSE, UNIFORM, Trials, curves_table, enough_dots
from sparsurf.study.evaluator import Evaluator, number_of_tests
from sparsurf.study.handing_out import hand_out
from sparsurf.study.tables import read_roughness, read_table
from sparsurf.surfaces.components import FIELD, fields_alone
from sparsurf.surfaces.formats.csv import write_csv
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf.workflow.jobs import run

log = logging.getLogger("sparsurf")


def main(inputs, outputs, settings, name, threads=1, whole=True):
    """Write the subset, what is enough, Z over n_S, the errors of the surface that the subset gives back, and meshes.

    The paper's sampler takes its parameters from ranges.csv. Unless the `whole` curve of recovered surfaces is asked for, it ends
    at the lowest floor.
    """
    surface, own = read_npz(inputs["surface"]), inputs.get("structure")
    molecule = read_own(own) if own else None
    fields = fields_alone(surface)
    parts = {FIELD: surface.fields[FIELD].astype(int)} if FIELD in surface.fields else {}
    if molecule is not None:
        table = inputs.get("table") or None
        names = [name for name in settings["fields"] if table or name in FIELDS]
        fields |= values(names, molecule, surface.points, table=table)
    surface = replace(surface, fields=fields)
    rough = read_roughness(inputs["roughness"], surface)
    asked = settings["minimal"]
    evaluator = Evaluator.from_settings(surface, settings, rough, name, 1).nameless
    choices = choices_of(read_table(inputs["ranges"]) if "ranges" in inputs else None)
    if "ranges" in inputs and choices is OF_PAPER:
        log.warning(
            "%s: nothing was evaluated as coded, so the paper's sampling takes the paper's parameters", name
        )
    n_tests = number_of_tests(settings["evaluation"]["test_dots"], len(surface))
    floors = read_table(inputs["floors"])
    trials = Trials(evaluator, asked["sampler"], n_tests, choices, asked["settle"])
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
    table = subset.table.assign(**subset.surface.fields)
    write_csv(outputs["table"], table, subset.surface.fields)
    columns = {key: table[key].to_numpy(float) for key in ("spacing", "reach")}
    columns |= subset.surface.fields
    write_ply(outputs["ply"], subset.surface, subset.weight.astype(float), "weight", columns)
    write_ply(outputs["whole"], surface, rough, "roughness", parts | fields)
    if "fields" in outputs:
        with open(outputs["fields"], "wb") as stream:
            np.savez(stream, **fields)
        order = farthest(evaluator, len(surface) // 5, evaluator.stream("minimal", "farthest"))
        back = recovery_table(surface, order, subset.dots, subset.surface.points)
        back.to_csv(outputs["given_back"], index=False, float_format="%.5g")


if __name__ == "__main__":
    run(main, snakemake)
