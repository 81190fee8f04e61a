"""How many dots are enough: thresholds on made-up Z, whose answers can be read off."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from sparsurf.study import minimal_by_floor
from sparsurf.study.enough import enough, percents

GRID = pd.DataFrame(
    {
        "n_S_percent": [5.0, 10.0, 20.0],
        "Z_tR_surface": [3.0, 2.0, 1.0],
        "Z_tR_high_surface": [3.2, 2.2, 1.2],
        "Z_tS_surface": [2.0, 1.0, 0.5],
        "Z_tS_high_surface": [2.5, np.nan, 0.6],
    }
)


def test_enough_is_the_least_whose_interval_lies_below():
    found = enough(GRID, {"high": 2.2, "low": 0.55, "any": 9.0}).set_index(["sampler", "yardstick"])
    # an upper end that touches the yardstick is not below it; of one without an interval, Z itself counts
    assert found["n_S_percent"]["uniform"].tolist() == pytest.approx([20.0, np.nan, 5.0], nan_ok=True)
    assert found["n_S_percent"]["paper"].tolist() == pytest.approx([10.0, np.nan, 5.0], nan_ok=True)
    assert found["smallest"]["uniform"].tolist() == [False, False, True]
    assert (found["islands"] == "surface").all()


def test_percents_are_columns_by_floor_and_reading():
    table = pd.DataFrame(
        {"floor": ["fresh dots", "turned"], "islands": ["surface", "recovered"], "n_S_percent": [80.0, 2.5]}
    )
    assert percents(table) == {"enough_fresh_dots_surface": 80.0, "enough_turned_recovered": 2.5}


@pytest.fixture
def made_up(monkeypatch):
    """A surface of 1000 dots whose Z is 100 / n_S, twice that unless recovered, each with an error of 0.3."""

    def tools(evaluator, *_):
        def z_of(dots, reading):
            return 100 / len(dots) * (1 if reading == "recovered" else 2), 0.3

        return np.arange, z_of

    monkeypatch.setattr(minimal_by_floor, "_tools", tools)
    return SimpleNamespace(points=np.zeros((1000, 3)), name="made up")


def one_floor(value, se):
    return pd.DataFrame({"floor": ["turned"], "Z": [value], "se": [se]})


def test_a_floor_is_reached_within_the_error_of_the_difference(made_up):
    # errors 0.3 and 0.4: 0.5 of the difference, so up to 1.0 + 0.98 counts: 100 / n <= 1.98 from n = 51 on
    found = minimal_by_floor.enough_dots(made_up, "farthest", one_floor(1.0, 0.4), 60).set_index("islands")
    assert found["n_S"].to_dict() == {"surface": 120, "recovered": 60}  # of 50, 60, .. 100, 120: the first
    assert found["n_S_percent"].to_dict() == {"surface": 12.0, "recovered": 6.0}
    assert found["Z"].to_dict() == pytest.approx({"surface": 200 / 120, "recovered": 100 / 60})
    never = minimal_by_floor.enough_dots(made_up, "farthest", one_floor(-9.0, 0.4), 60)
    assert never["n_S"].tolist() == [1000, 1000] and never["Z"].tolist() == [0, 0]


def test_no_subset_is_smaller_than_the_fewest(made_up):
    found = minimal_by_floor.enough_dots(made_up, "farthest", one_floor(99.0, 0.4), 60)
    assert found["n_S"].tolist() == [12, 12]


@pytest.mark.parametrize(
    ("value", "n"),
    [
        (1.0, 51),  # between 50 and 60: 55, 52 (1.92) and 51 (1.96) do, which are three halvings
        (0.85, 55),  # up to 1.83: 55 (1.82) does, 52 (1.92) and 53 (1.89) do not
    ],
)
def test_the_step_before_is_halved_three_times(made_up, value, n):
    floors = one_floor(value, 0.4)
    enough = minimal_by_floor.enough_dots(made_up, "farthest", floors, 60)
    found = minimal_by_floor.smallest(made_up, "farthest", floors, "turned", enough, 60)
    assert len(found) == n
