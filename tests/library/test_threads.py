"""Slices of work: whole, in order, whatever the threads."""

import pytest

from sparsurf.threads import available_cores, parallel_map


@pytest.mark.parametrize("threads", [1, 3])
def test_slices_cover_the_range_in_order(threads):
    assert parallel_map(lambda a, b: (a, b), 10, threads, 4) == [(0, 4), (4, 8), (8, 10)]
    assert parallel_map(lambda a, b: (a, b), 8, threads, 4) == [(0, 4), (4, 8)]
    assert parallel_map(lambda a, b: (a, b), 0, threads, 4) == []
    assert available_cores() >= 1
