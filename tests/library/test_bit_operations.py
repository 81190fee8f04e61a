"""Bits of words, against their binary digits."""

import numpy as np
import pytest
from numba import njit

from sparsurf.bit_operations import count_bits, lowest_bit


@njit
def both(x):
    return lowest_bit(x), count_bits(x)


@pytest.mark.parametrize("kind", [np.uint32, np.uint64])
def test_the_lowest_bit_and_how_many_are_set(kind):
    most = np.iinfo(kind).max
    for x in (1, 2, 12, most // 2 + 1, most, most - 7):
        digits = f"{x:b}"
        assert both(kind(x)) == (len(digits) - 1 - digits.rindex("1"), digits.count("1"))
