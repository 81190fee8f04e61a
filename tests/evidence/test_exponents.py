"""Subsets denser where the surface is rough: what they are made of, and what is said of them."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from measures import exponents


@pytest.fixture(scope="module")
def plane():
    """A square of dots, rough on one side (R = 0.2) and flat on the other (R = 0.8)."""
    places = np.random.default_rng(0).uniform(0, 60, (3600, 2))
    rough = np.where(places[:, 0] < 30, 0.2, 0.8)
    return SimpleNamespace(points=np.column_stack([places, np.zeros(3600)]), roughness=rough)


@pytest.mark.parametrize("name", exponents.SAMPLERS)
@pytest.mark.parametrize(("k", "ratio"), [(-1, 1 / 4), (0, 1), (0.5, 2), (1, 4)])
def test_the_density_goes_with_the_power_of_one_less_the_roughness(plane, name, k, ratio):
    dots = exponents.SAMPLERS[name](plane, 200, k, np.random.default_rng(0))
    assert len(set(dots.tolist())) == 200
    rough = (plane.roughness[dots] < 0.5).sum()
    # the scatter of a count of 40 is a sixth: 0.45 is nearly three standard errors of random dots; spaced ones scatter less
    assert rough / (200 - rough) == pytest.approx(ratio, rel=0.45 if name == "random" else 0.3)


def test_spaced_dots_of_even_density_are_farthest_points(plane):
    dots = exponents.spaced_dots(plane, 50, 0, np.random.default_rng(1))
    gap = np.full(3600, np.inf)
    for one, following in pairwise(dots):
        gap = np.minimum(gap, np.linalg.norm(plane.points - plane.points[one], axis=1))
        assert gap[following] == gap.max()


def made_up(protein, at):
    """Z over k with its minimum 1 - 0.1 * protein at one k."""
    rows = [("random", 5.0, k, "recovered", 2.0 * (1 - 0.1 * (k == at))) for k in (-1.0, 0.0, 1.0)]
    return pd.DataFrame(rows, columns=["sampler", "percent", "k", "reading", "Z"]).assign(protein=protein)


def test_ratios_are_taken_protein_by_protein():
    table = pd.concat([made_up("a", 1.0), made_up("b", 0.0)])
    found = exponents.ratios(table).set_index("k")
    assert found.loc[0.0, "ratio"] == 1 and found.loc[1.0, "ratio"] == pytest.approx((0.9 + 1 / 0.9) / 2)
    assert (found["n"] == 2).all()


def test_the_gain_of_an_exponent_is_that_of_the_choice_of_all_others():
    table = pd.concat([*(made_up(name, 1.0) for name in "abd"), made_up("c", -1.0)])
    row = exponents.best(table).iloc[0]
    # all choose k = 1, also for c, which gains nothing by it
    assert row["k"] == 1 and row["gain"] == pytest.approx(100 * 0.3 / 4)
