"""Compile the numba kernels once, into the cache that all later jobs read."""

import numpy as np

from sparsurf.dots import molecular_surface
from sparsurf.evaluation import Evaluator
from sparsurf.workflow import job


def main(path_to_mark):
    """Run the whole chain of kernels on two atoms and note that it ran."""
    dots = molecular_surface(np.array([[0.0, 0, 0], [2.5, 0, 0], [0.0, 2.5, 0]]), np.full(3, 1.7))
    Evaluator(dots).grid(np.array([[0.5, 0.5, 1.0, 1.0]]), 4)
    with open(path_to_mark, "w", encoding="utf-8") as stream:
        stream.write("kernels compiled\n")


if __name__ == "__main__":
    with job(snakemake) as output:
        main(output["mark"])
