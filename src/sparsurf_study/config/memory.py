"""Memory that the grid of a study needs, and memory of this machine."""

import math
import os
from collections.abc import Iterator

from sparsurf.settings import Evaluation

# A test dot has one to the sampling and one to a random subset, in single precision.
BYTES_PER_DISTANCE = 8
# So many copies of one reading's distances exist while the interval of a mean is computed.
COPIES_DURING_MEAN = 4
DOTS_PER_TEST_DOT = 200  # where the config asks for as many test dots as published
THOUSAND_DOTS = 20  # dots of a surface like the paper's, in thousands


def memory_of_grid(config: dict) -> float:
    """Return the bytes that the distances of one surface, as large as those of the paper, need at most."""
    sampling, evaluation = config["sampling"], config["evaluation"]
    test_dots = evaluation["test_dots"]
    if test_dots == "published":
        test_dots = 1000 * THOUSAND_DOTS / DOTS_PER_TEST_DOT
    n_combinations = math.prod(len(sampling[parameter]) for parameter in ("alpha", "beta", "gamma", "delta"))
    one_reading = BYTES_PER_DISTANCE * n_combinations * evaluation["draws"] * test_dots
    return one_reading * (len(Evaluation(**evaluation).grid_readings) + COPIES_DURING_MEAN)


def too_large(config: dict) -> Iterator[str]:
    """Yield a sentence if the grid needs more memory than this machine has."""
    needed, available = memory_of_grid(config), memory_of_machine()
    if needed > available:
        yield (
            f"sampling and evaluation need {needed / 2**30:.1f} GB of memory (combinations x draws x test_dots x "
            f"readings), but this machine has {available / 2**30:.1f} GB; lower one of them."
        )


def memory_of_machine() -> float:
    """Return the bytes of memory of this machine; infinite where the system does not say."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return math.inf
