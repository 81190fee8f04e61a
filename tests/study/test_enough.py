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


def test_the_null_model_is_undercut_by_the_interval():
    """An upper end that touches it is not below it; of one without an interval, Z itself counts."""
    for null_model, uniform, paper in ((2.2, 20.0, 10.0), (0.55, np.nan, np.nan), (9.0, 5.0, 5.0)):
        found = enough(GRID, null_model, {}).set_index("sampler")
        assert found["n_S_percent"].tolist() == pytest.approx([uniform, paper], nan_ok=True)
        assert found["smallest"].tolist() == [uniform == 5.0, paper == 5.0]
        assert (found["islands"] == "surface").all() and found["Z"].tolist() == [null_model] * 2


def test_a_floor_is_reached_within_a_tenth_of_it_whatever_the_interval():
    found = enough(GRID, 9.0, {"turned": 1.0 / 1.1, "more": 0.909, "fresh dots": 0.4}).set_index(
        ["yardstick", "sampler"]
    )
    # Z 2, 1, 0.5 and, of uniform dots, 3, 2, 1: 1.1 times 0.909 is just below 1
    assert found["n_S_percent"].to_dict() == pytest.approx(
        {
            ("null_model", "uniform"): 5.0, ("turned", "uniform"): 20.0, ("more", "uniform"): np.nan,
            ("fresh dots", "uniform"): np.nan, ("null_model", "paper"): 5.0, ("turned", "paper"): 10.0,
            ("more", "paper"): 20.0, ("fresh dots", "paper"): np.nan,
        },
        nan_ok=True,
    )  # fmt: skip


def test_no_row_of_uniform_dots_wins_by_luck():
    """Of 200 rows with Z = 100 / n_S, one at 20 % and one at 81 % are as low as at 50 %."""
    percent = np.linspace(1, 100, 200)
    z = 100 / percent
    z[[38, 160]] = 2.0
    shuffled = np.random.default_rng(0).permutation(200)
    grid = pd.DataFrame({"n_S_percent": percent, "Z_tR_surface": z, "Z_tS_surface": z}).iloc[shuffled]
    grid = grid.assign(Z_tR_high_surface=grid["Z_tR_surface"], Z_tS_high_surface=grid["Z_tS_surface"])
    found = enough(grid, 1.0, {"turned": 2.0 / 1.1}).set_index(["yardstick", "sampler"])["n_S_percent"]
    assert found["turned", "uniform"] == pytest.approx(50, abs=0.5)
    assert found["turned", "paper"] == pytest.approx(percent[38])  # of whichever combination does it


def test_percents_are_columns_by_floor_and_reading():
    table = pd.DataFrame(
        {"floor": ["fresh dots", "turned"], "islands": ["surface", "recovered"], "n_S_percent": [80.0, 2.5]}
    )
    assert percents(table) == {"enough_fresh_dots_surface": 80.0, "enough_turned_recovered": 2.5}


@pytest.fixture
def made_up(monkeypatch):
    """A surface of 1000 dots whose Z is 100 / n_S, twice that unless recovered."""

    def tools(evaluator, *_):
        def z_of(dots, reading):
            return 100 / len(dots) * (1 if reading == "recovered" else 2)

        return np.arange, z_of

    monkeypatch.setattr(minimal_by_floor, "_tools", tools)
    return SimpleNamespace(points=np.zeros((1000, 3)), name="made up")


def one_floor(value):
    return pd.DataFrame({"floor": ["turned"], "Z": [value], "se": [0.4]})


def test_a_floor_is_reached_within_a_tenth_however_well_it_is_known(made_up):
    # 100 / n <= 1.98 from n = 51 on
    found = minimal_by_floor.enough_dots(made_up, "farthest", one_floor(1.8), 60).set_index("islands")
    assert found["n_S"].to_dict() == {"surface": 120, "recovered": 60}  # of 50, 60, .. 100, 120: the first
    assert found["n_S_percent"].to_dict() == {"surface": 12.0, "recovered": 6.0}
    assert found["Z"].to_dict() == pytest.approx({"surface": 200 / 120, "recovered": 100 / 60})
    never = minimal_by_floor.enough_dots(made_up, "farthest", one_floor(-9.0), 60)
    assert never["n_S"].tolist() == [1000, 1000] and never["Z"].tolist() == [0, 0]
    most = minimal_by_floor.enough_dots(made_up, "farthest", one_floor(0.21), 60)  # 0.231: 866 and 433 dots
    assert most["n_S"].tolist() == [900, 500]
    assert minimal_by_floor.enough_dots(made_up, "farthest", one_floor(0.27), 60)["n_S"].tolist() == [
        700,
        400,
    ]


def test_no_subset_is_smaller_than_the_fewest(made_up):
    found = minimal_by_floor.enough_dots(made_up, "farthest", one_floor(99.0), 60)
    assert found["n_S"].tolist() == [12, 12]


@pytest.mark.parametrize(
    ("value", "n"),
    [
        (1.8, 51),  # up to 1.98, between 50 and 60: 55, 52 (1.92) and 51 (1.96) do, which are three halvings
        (1.66, 55),  # up to 1.83: 55 (1.82) does, 52 (1.92) and 53 (1.89) do not
    ],
)
def test_the_step_before_is_halved_three_times(made_up, value, n):
    floors = one_floor(value)
    enough = minimal_by_floor.enough_dots(made_up, "farthest", floors, 60)
    found = minimal_by_floor.smallest(made_up, "farthest", floors, "turned", enough, 60)
    assert len(found) == n
