"""How many dots are enough: thresholds on made-up Z, whose answers can be read off."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sparsurf.study.required_dots import (
    CURVE_PERCENTS,
    Trials,
    curves_table,
    percent_columns,
    required_dots_table,
    required_on_grid,
    smallest_n_s,
)
from sparsurf.study.subset_search import smallest_recovered_subset

GRID = pd.DataFrame(
    {
        "n_S_percent": [5.0, 10.0, 20.0],
        "Z_tR_as_written": [3.0, 2.0, 1.0],
        "Z_tR_high_as_written": [3.2, 2.2, 1.2],
        "Z_tS_as_written": [2.0, 1.0, 0.5],
        "Z_tS_high_as_written": [2.5, np.nan, 0.6],
    }
)


def between(z, n, values):
    """Where a straight line of ln Z over ln n_S through two points comes down to z."""
    return n[0] * (n[1] / n[0]) ** (np.log(z / values[0]) / np.log(values[1] / values[0]))


def test_the_null_model_is_undercut_by_the_interval():
    """Upper ends 3.2, 2.2, 1.2 and 2.5, 1 (without an interval: Z itself), .6."""
    cases = (
        (2.0, between(2, (10, 20), (2.2, 1.2)), between(2, (5, 10), (2.5, 1))),
        (0.55, np.nan, np.nan),
        (9.0, 5, 5),
    )
    for z_mean_descriptor, uniform, paper in cases:
        found = required_on_grid(GRID, z_mean_descriptor, {}).set_index("sampler")
        assert found["n_S_percent"].tolist() == pytest.approx([uniform, paper], nan_ok=True)
        assert found["smallest"].tolist() == [uniform == 5.0, paper == 5.0]
        assert (found["reading"] == "as_written").all() and found["Z"].tolist() == [z_mean_descriptor] * 2


def test_a_floor_is_reached_within_a_fifth_of_it_whatever_the_interval():
    floors = {"turned": 1.375, "fresh dots": 0.4, "far": 9.0}  # times 1.2: 1.65, .48, 10.8
    found = required_on_grid(GRID.iloc[[2, 0, 1]], 9.0, floors).set_index(["reference", "sampler"])[
        "n_S_percent"
    ]
    wanted = {
        ("turned", "uniform"): between(1.65, (10, 20), (2, 1)), ("turned", "paper"): between(1.65, (5, 10), (2, 1)),
        ("fresh dots", "uniform"): np.nan, ("fresh dots", "paper"): np.nan, ("far", "uniform"): 5, ("far", "paper"): 5,
    }  # fmt: skip
    assert found[found.index.get_level_values(0) != "Z_mean_descriptor"].to_dict() == pytest.approx(
        wanted, nan_ok=True
    )


def test_no_row_of_uniform_dots_wins_by_luck():
    """Of 200 rows with Z = 100 / n_S, one at 20 % and one at 81 % are as low as at 50 %."""
    percent = np.linspace(1, 100, 200)
    z = 100 / percent
    z[[38, 160]] = 2.0
    shuffled = np.random.default_rng(0).permutation(200)
    grid = pd.DataFrame({"n_S_percent": percent, "Z_tR_as_written": z, "Z_tS_as_written": z}).iloc[shuffled]
    grid = grid.assign(
        Z_tR_high_as_written=grid["Z_tR_as_written"], Z_tS_high_as_written=grid["Z_tS_as_written"]
    )
    found = required_on_grid(grid, 1.0, {"turned": 2.0 / 1.2}).set_index(["reference", "sampler"])[
        "n_S_percent"
    ]
    assert found["turned", "uniform"] == pytest.approx(50, abs=0.5)
    assert (
        percent[37] < found["turned", "paper"] <= percent[38] * (1 + 1e-9)
    )  # of whichever combination does it


def test_percents_are_columns_by_floor_and_reading_with_the_interval_of_the_recovered():
    table = pd.DataFrame(
        {
            "floor": ["fresh dots", "turned"],
            "reading": ["as_written", "recovered"],
            "n_S_percent": [80.0, 2.5],
            "n_S_percent_low": [np.nan, 2.0],
            "n_S_percent_high": [np.nan, 3.5],
        }
    )
    assert percent_columns(table) == {
        "required_percent_fresh_dots_as_written": 80.0,
        "required_percent_turned_recovered": 2.5,
        "required_percent_turned_recovered_low": 2.0,
        "required_percent_turned_recovered_high": 3.5,
    }


class MadeUp(Trials):
    """A surface of 1000 dots whose Z is 100 / n_S, twice that unless recovered, at every test dot and in every draw."""

    def __init__(self):
        self.prepared = SimpleNamespace(name="made up", threads=1, stream=lambda *_: np.random.default_rng(0))
        self.sampler, self.n_dots, self._measured, self.down_to = "farthest", 1000, {}, -1

    def draw(self, n):
        return np.arange(n)

    def draws(self, n, reading):
        return [np.arange(n)] * (3 if reading == "recovered" else 1)

    def distances(self, subsets, reading):
        z = np.array([100 / len(dots) * (1 if reading == "recovered" else 2) for dots in subsets])
        return np.tile(z[:, None], 4)


def one_floor(value):
    return {"turned": np.full((10, 4), value)}


def test_a_floor_is_reached_within_a_fifth():
    # Z is exactly what is fitted, and ln Z is a straight line over ln n_S: 100 / n = 1.98 at 50.5
    found = required_dots_table(MadeUp(), one_floor(1.65)).set_index("reading")
    assert found["n_S"].to_dict() == {"as_written": 102, "recovered": 51}
    assert found["n_S_percent"].to_dict() == {"as_written": 10.2, "recovered": 5.1}
    assert found["Z"].tolist() == pytest.approx([1.98, 1.98]) and found["bound"].tolist() == ["", ""]
    ends = found.loc["recovered", ["n_S_percent_low", "n_S_percent_high"]].astype(float)
    assert ends.tolist() == pytest.approx(
        [5.05, 5.05], abs=0.005
    )  # nothing varies; steps of the fitted curve
    assert found.loc["as_written", ["n_S_percent_low", "n_S_percent_high"]].isna().all()
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


def test_a_curve_ends_where_the_lowest_floor_is_reached():
    trials, floors = MadeUp(), one_floor(1.65)
    whole = required_dots_table(MadeUp(), floors)
    trials.down_to = 1.98
    assert curves_table(trials, ("recovered",))["n_S"].tolist() == [12, 15, 20, 25, 30, 40, 50, 60]
    assert len(curves_table(trials, ("as_written",))) == len(trials.sizes)
    pd.testing.assert_frame_equal(required_dots_table(trials, floors), whole)


@given(
    st.lists(st.floats(0.01, 9), min_size=2, max_size=12),
    st.floats(0.005, 10),
)
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


def test_a_curve_that_rises_at_its_end_still_needs_its_first_crossing():
    # from 2 to 1 between 10 and 20 %: ln 2 - ln 1.2 of ln 2 on the way
    share = np.log(2 / 1.2) / np.log(2)
    found = smallest_n_s(1.2, np.array([10.0, 20, 40]), np.array([2.0, 1, 1.5]))
    assert found == pytest.approx(10 * 2**share)
