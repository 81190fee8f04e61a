"""Compile the numba kernels once, into the cache that all later jobs read."""

import numpy as np

from sparsurf import render, samplers
from sparsurf.dots import molecular_surface
from sparsurf.evaluation import Evaluator
from sparsurf.workflow import job


def main(path_to_mark):
    """Run every kernel of a study on three atoms and note that they ran."""
    dots = molecular_surface(np.array([[0.0, 0, 0], [2.5, 0, 0], [0.0, 2.5, 0]]), np.full(3, 1.7))
    evaluator = Evaluator(dots)
    evaluator.grid(np.array([[0.5, 0.5, 1.0, 1.0]]), 4)
    for choose in samplers.SAMPLERS.values():
        choose(evaluator, 20, np.random.default_rng(0))
    camera = render.aim(dots.points, np.eye(3), (20, 20))
    render.draw_surface(dots.points, dots.normals, (0.5, 0.5, 0.5), camera)
    with open(path_to_mark, "w", encoding="utf-8") as stream:
        stream.write("kernels compiled\n")


if __name__ == "__main__":
    with job(snakemake) as output:
        main(output["mark"])
