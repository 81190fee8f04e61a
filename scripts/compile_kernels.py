"""Compile the numba kernels once, into the cache that later jobs read: in two parts that take as long.

What runs them is imported where it is needed: where all are compiled, a study need not wait for it. Those of pairs are
compiled by the first job of a pair.
"""

import gc

import numpy as np

from sparsurf import kernel_cache
from sparsurf.workflow.jobs import run

BALL = 300  # dots of a made-up surface


def main(outputs, part, descriptor):
    """Run every kernel of one part on next to nothing, unless that was done before, and note that they ran."""
    before = kernel_cache.mark(part, descriptor)
    if not before.exists():
        gc.disable()  # a compiler leaves little garbage; looking for it takes a tenth of the time
        try:
            if part == "surfaces":
                _surfaces_and_pictures()
                _recovery()
            else:
                _patches(descriptor)
                _choices()
        finally:
            gc.enable()
        before.touch()
    with open(outputs["mark"], "w", encoding="utf-8") as stream:
        stream.write("kernels compiled\n")


def _surfaces_and_pictures():
    from sparsurf.report.figures import render
    from sparsurf.surfaces.molecular_surface import molecular_surface

    dots = molecular_surface(np.array([[0.0, 0, 0], [2.5, 0, 0], [0.0, 2.5, 0]]), np.full(3, 1.7))
    camera = render.aim(dots.points, np.eye(3), (20, 20))
    render.picture(render.draw_surface(dots.points, dots.normals, (0.5, 0.5, 0.5), camera))


def _patches(descriptor):
    from sparsurf.study import grid
    from sparsurf.study.evaluator import Evaluator

    grid.run(Evaluator(_ball(), descriptor=descriptor), np.array([[0.5, 0.5, 1.0, 1.0]]), 4)


def _recovery():
    from sparsurf.recovery.recovering import recover

    dots = _ball()
    recover(dots.points, dots.normals)


def _choices():
    from sparsurf.sampling import samplers
    from sparsurf.study.evaluator import Evaluator

    evaluator = Evaluator(_ball())
    for choose in samplers.SAMPLERS.values():
        choose(evaluator, 20, np.random.default_rng(0))


def _ball():
    from sparsurf.surfaces.surface import Surface

    outward = np.random.default_rng(0).normal(size=(BALL, 3))
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    return Surface(2 * outward, outward)


if __name__ == "__main__":
    run(main, snakemake)
