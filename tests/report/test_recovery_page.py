"""The page on recovered surfaces is what its tables say."""

import pandas as pd

from conftest import ROOT
from sparsurf.report import recovery_page


def test_the_stored_page_follows_from_the_stored_tables():
    tables = recovery_page.read(ROOT / "docs" / "tables")
    assert recovery_page.page(*tables) == (ROOT / "docs" / "recover.md").read_text(encoding="utf-8")
    rows = tables[2].set_index(["sampler", "percent", "measure"])["mean"]
    assert f"comes back {rows['farthest', 10.0, 'distance']:.3f} Å" in recovery_page.answer(tables[2])
    assert rows["farthest", 10.0, "Z"] < rows["farthest", 10.0, "Z_kept"]


def test_a_change_counts_where_its_interval_leaves_zero():
    row = {"first": "a", "second": "b", "measure": "Z", "n": 5}
    pairs = pd.DataFrame(
        [
            row | {"percent": 5.0, "mean": -4.0, "low": -6.0, "high": -1.0},
            row | {"percent": 10.0, "mean": 2.0, "low": -1.0, "high": 5.0},
            row | {"percent": 20.0, "mean": 3.0, "low": 1.0, "high": 5.0},
        ]
    )
    assert "a instead of b: lower Z at 5 % and higher Z at 20 %." in recovery_page.paying(pairs)


def test_a_row_of_each_table():
    ends = {"low": 0.1, "high": 0.3, "n": 7, "sampler": "farthest"}
    means = pd.DataFrame(
        [
            ends | {"percent": p, "measure": measure, "mean": mean}
            for p in (2.5, 5.0, 10.0)
            for measure, mean in (("Z_over_floor", 1.1), ("Z", 0.5), ("Z_kept", 2.0), ("distance", 0.15))
        ]
    )
    assert recovery_page.answer(means).splitlines()[0] == (
        "From 10 % of the dots the surface comes back 0.150 Å from the true one; its Z is 1.10 (0.10 to 0.30) times that of "
        "other dots of the same surface, 0.50 instead of 2.00."
    )
    matrix = recovery_page._matrix(means)
    assert "| Z, the dots as they are | 2.00 (0.10 to 0.30) |" in matrix
    assert "| distance to the true surface, Å | 0.150 (0.100 to 0.300) |" in matrix
    table = pd.DataFrame(
        [("b", "farthest", 5.0, 900, 0.7), ("a", "farthest", 5.0, 800, 0.6), ("a", "uniform", 5.0, 800, 9.9)],
        columns=["protein", "sampler", "percent", "N", "Z"],
    )
    floors = pd.DataFrame(
        [("a", "fresh dots", 0.25), ("b", "fresh dots", 0.5), ("a", "turned", 9.9)],
        columns=["protein", "floor", "Z"],
    )
    assert recovery_page._each(table, floors).splitlines()[2:] == [
        "| b | 900 | 0.50 | 0.70 |",
        "| a | 800 | 0.25 | 0.60 |",
    ]
