"""Equal ranges of a number, n_S or roughness, and which one a value falls into."""

import numpy as np


def range_limits(values, n_ranges):
    """Limits of equal ranges between the smallest and the largest value: (n_ranges + 1,) float64."""
    return np.linspace(np.min(values), np.max(values), n_ranges + 1)


def range_of(values, limits, closed=True):
    """Number of the range, from 0, that each value falls into.

    A range holds its lower limit and not its upper one. The largest value belongs to the last range where that is
    `closed`; else to none, and gets the number of ranges.
    """
    place = np.searchsorted(limits, values, side="right") - 1
    return np.clip(place, 0, len(limits) - 2 if closed else len(limits) - 1)
