"""How many dots are enough: thresholds on made-up Z, whose answers can be read off."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sparsurf.evaluation.required_dots import (
    CURVE_PERCENTS,
    Trials,
    curves_table,
    required_dots_table,
    required_for_error,
    smallest_n_s,
)
from sparsurf.evaluation.subset_search import smallest_recovered_subset, smallest_subset_of_error


class MadeUp(Trials):
    """A surface of 1000 dots whose Z is 100 / n_S, twice that unless recovered, at every test dot and in every draw."""

    def __init__(self):
        self.prepared = SimpleNamespace(name="made up", threads=1, stream=lambda *_: np.random.default_rng(0))
        self.sampler, self.n_dots, self._measured = "farthest", 1000, {}
        self.down_to, self.with_tail = -1, False

    def draw(self, n):
        return np.arange(n)

    def draws(self, n, reading):
        return [np.arange(n)] * (3 if reading == "recovered" else 1)

    def distances(self, subsets, reading):
        z = np.array([100 / len(dots) * (1 if reading == "recovered" else 2) for dots in subsets])
        return np.tile(z[:, None], 4)

    def errors_of(self, sizes):
        self.tried_errors = [*getattr(self, "tried_errors", []), *map(int, sizes)]
        return np.array(sizes, float), np.tile(2 / np.array(sizes)[:, None], 3)  # Å, in every draw


def test_the_fewest_dots_of_an_error_are_found_with_few_trials():
    """The error is 2 / n: it falls to 2 / 50.5 Å between 50 and 51 dots."""
    trials = MadeUp()
    required = required_for_error(trials, 2 / 50.5)
    assert (required.n_s, required.bound) == (51, "")
    assert (required.low, required.high) == pytest.approx((50.5, 50.5), abs=0.05)  # nothing varies
    assert len(set(trials.tried_errors)) < 10 < len(trials.sizes)
    subset, interval = smallest_subset_of_error(MadeUp(), 2 / 50.5)
    assert len(subset) == 51 and interval == (required.low, required.high)
    for error, n, bound in ((1.0, 12, "at most"), (0.001, 1000, "more")):
        required = required_for_error(MadeUp(), error)
        assert (required.n_s, required.bound) == (n, bound) and np.isnan(required.low)


def one_floor(value):
    return {"turned": np.full((10, 4), value)}


def test_a_floor_is_reached_within_a_fifth():
    # Z is exactly what is fitted, and ln Z is a straight line over ln n_S: 100 / n = 1.98 at 50.5
    found = required_dots_table(MadeUp(), one_floor(1.65)).set_index("reading")
    assert found["n_S"].to_dict() == {"full": 102, "recovered": 51}
    assert found["n_S_percent"].to_dict() == {"full": 10.2, "recovered": 5.1}
    assert found["Z"].tolist() == pytest.approx([1.98, 1.98]) and found["bound"].tolist() == ["", ""]
    ends = found.loc["recovered", ["n_S_percent_low", "n_S_percent_high"]].astype(float)
    assert ends.tolist() == pytest.approx(
        [5.05, 5.05], abs=0.005
    )  # nothing varies; steps of the fitted curve
    assert found.loc["full", ["n_S_percent_low", "n_S_percent_high"]].isna().all()
    subset, interval = smallest_recovered_subset(MadeUp(), one_floor(1.65), "turned")
    assert len(subset) == 51 and interval == pytest.approx((50.5, 50.5), abs=0.05)


@pytest.mark.parametrize(
    ("value", "n", "z", "bound"), [(99, 12, 100 / 12, "at most"), (0.05, 1000, 0, "more")]
)
def test_beyond_what_was_measured_there_is_a_bound(value, n, z, bound):
    found = required_dots_table(MadeUp(), one_floor(value), ("recovered",)).iloc[0]
    assert (found["n_S"], found["bound"]) == (n, bound) and found["Z"] == pytest.approx(z)
    assert np.isnan(found["n_S_percent_low"])
    subset, interval = smallest_recovered_subset(MadeUp(), one_floor(value), "turned")
    assert len(subset) == n and interval is None


def test_only_sizes_around_the_crossing_are_measured():
    """Z is 1.98 at 50.5: up to 60, the first that is enough, and then to 5 x 60 and a margin of a fifth."""
    trials = MadeUp()
    smallest_recovered_subset(trials, one_floor(1.65), "turned")
    sizes = [12, *(10 * p for p in CURVE_PERCENTS if p >= 1.5 and 10 * p <= 60 * 5 * 1.2)]
    assert sorted(trials._measured["recovered"]) == sizes
    assert curves_table(trials, ("recovered",))["n_S"].tolist() == [
        12,
        *(10 * p for p in CURVE_PERCENTS if p >= 1.5),
    ]


def test_a_curve_ends_where_the_lowest_floor_is_reached_but_for_a_tail():
    trials, floors = MadeUp(), one_floor(1.65)
    whole = required_dots_table(MadeUp(), floors)
    trials.down_to = 1.98
    assert curves_table(trials, ("recovered",))["n_S"].tolist() == [12, 15, 20, 25, 30, 40, 50, 60]
    trials.with_tail = True
    sizes = [12, 15, 20, 25, 30, 40, 50, 60, 100, 250, 600]
    assert curves_table(trials, ("recovered",))["n_S"].tolist() == sizes
    assert len(curves_table(trials, ("full",))) == len(trials.sizes)
    pd.testing.assert_frame_equal(required_dots_table(trials, floors), whole)


@given(st.lists(st.floats(0.01, 9), min_size=2, max_size=12), st.floats(0.005, 10))
def test_the_smallest_n_s_on_any_curve(values, z):
    n = np.geomspace(1, 90, len(values))
    found = smallest_n_s(z, n, np.array(values))
    reached = [k for k, value in enumerate(values) if value <= z]
    if not reached:
        assert found == np.inf
    elif reached[0] == 0:
        assert found == (n[0] if z == values[0] else 0)
    else:
        before, there = n[reached[0] - 1], n[reached[0]]
        assert before <= found <= there * (1 + 1e-12)
        lowest = min(values[: reached[0]])
        line = np.exp(np.interp(np.log(found), np.log([before, there]), np.log([lowest, values[reached[0]]])))
        assert line == pytest.approx(z, rel=1e-9)
