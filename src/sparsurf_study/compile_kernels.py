"""Compile the kernels of a grid that `sparsurf.compile_kernels` does not: `python -m sparsurf_study.compile_kernels`.

The kernels of pairs are compiled when they are first called.
"""

import numpy as np

from sparsurf.compile_kernels import ball
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.surfaces.surface import Surface
from sparsurf_study.analysis.grid import evaluate_grid


def compile_grid() -> None:
    """Evaluate a grid of one combination on a tiny surface."""
    evaluate_grid(PreparedSurface(Surface(*ball())), np.array([[0.5, 0.5, 1.0, 1.0]]), 4)


if __name__ == "__main__":
    compile_grid()
