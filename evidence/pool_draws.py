"""Many draws of the combinations of one surface that may be the best: the population that intervals are tried on."""

import numpy as np
import pandas as pd

from measures import coverage
from sparsurf.patches.readings import OF_GRID
from sparsurf.study.evaluator import Evaluator
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, name, threads):
    """Write d of every contender, draw and test dot, and the range of each contender."""
    surface = read_npz(inputs["surface"])
    rough = pd.read_csv(inputs["roughness"])["roughness"].to_numpy()
    evaluator = Evaluator(
        surface, roughness_values=rough, seed=1, name=f"coverage of {name}", threads=threads
    )
    size = settings["draws"], settings["test_dots"]
    d, member = coverage.pool(evaluator, pd.read_csv(inputs["grid"]), OF_GRID, *size)
    np.savez(outputs["pool"], d=d, member=member)


if __name__ == "__main__":
    run(main, snakemake)
