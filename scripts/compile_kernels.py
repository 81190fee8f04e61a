"""Compile the numba kernels once, into the cache that all later jobs read."""

import numpy as np

from sparsurf.recovery.recovering import recover
from sparsurf.report.figures import render
from sparsurf.sampling import samplers
from sparsurf.study import grid, matching
from sparsurf.study.evaluator import Evaluator
from sparsurf.study.partners import partner_of
from sparsurf.surfaces.making import molecular_surface
from sparsurf.workflow.jobs import run


def main(outputs, descriptor):
    """Run every kernel of a study on three atoms and note that they ran."""
    dots = molecular_surface(np.array([[0.0, 0, 0], [2.5, 0, 0], [0.0, 2.5, 0]]), np.full(3, 1.7))
    evaluator = Evaluator(dots, descriptor=descriptor)
    grid.run(evaluator, np.array([[0.5, 0.5, 1.0, 1.0]]), 4)
    for choose in samplers.SAMPLERS.values():
        choose(evaluator, 20, np.random.default_rng(0))
    partner = partner_of(dots)
    matching.maps(matching.match(partner, partner), 0)
    recover(dots.points[::3], dots.normals[::3])
    camera = render.aim(dots.points, np.eye(3), (20, 20))
    render.draw_surface(dots.points, dots.normals, (0.5, 0.5, 0.5), camera)
    with open(outputs["mark"], "w", encoding="utf-8") as stream:
        stream.write("kernels compiled\n")


if __name__ == "__main__":
    run(main, snakemake)
