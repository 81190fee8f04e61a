"""Runs of Table I made by one changed rule."""

import numpy as np
import pandas as pd

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.paper.published_runs import as_published, centres_in_any_order
from sparsurf.sampling import law
from sparsurf.study.evaluator import Evaluator
from sparsurf.surfaces.molecular_surface import surface_of
from sparsurf.surfaces.radii import radii
from sparsurf.workflow.jobs import reporter, run


def main(inputs, outputs, settings, variant, threads):
    """Write the winners of every run, and for each run the centres in an order of the dots of its own."""
    molecule = read_molecule(inputs["structure"])
    surface = surface_of(molecule, 0, radii(molecule, "dms"), settings["surface"])
    combinations = law.grid(**settings["sampling"])
    rules, runs = {key.lower(): value for key, value in settings["rules"].items()}, settings["runs"]
    alpha, name = rules.pop("alpha", 1.0), f"power {variant}"
    evaluator = Evaluator(
        surface, **settings["patches"] | rules, seed=settings["seed"], name=name, threads=threads
    )
    table = as_published(evaluator, combinations, runs, reporter(variant, "runs of the grid"), alpha)
    centres = pd.Series(centres_in_any_order(evaluator, runs), index=np.arange(1, runs + 1))
    table.assign(centres=table["run"].map(centres)).to_csv(outputs["table"], index=False)


if __name__ == "__main__":
    run(main, snakemake)
