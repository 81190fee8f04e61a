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
        "- From 10 % of the dots the surface comes back 0.150 Å from the true one. Its Z is 0.50, 1.10 (0.10 to 0.30) times "
        "what other dots of the same surface give; the kept dots as they are give 2.00."
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
    over = pd.DataFrame({"settled dots": {"a": 1.051, "b": float("nan")}})
    assert recovery_page._each(table, floors, over).splitlines() == [
        "| structure | N | fresh dots | Z at 5 % | settled dots, 10 %, over fresh |",
        "| --- | --- | --- | --- | --- |",
        "| b | 900 | 0.50 | 0.70 |  |",
        "| a | 800 | 0.25 | 0.60 | 1.05 |",
    ]


def test_a_structure_is_held_to_its_own_floor():
    columns = ["protein", "sampler", "percent", "Z"]
    table = [("a", "farthest", 10.0, 0.525), ("b", "farthest", 10.0, 0.55), ("a", "farthest", 5.0, 9.0)]
    table += [("a", "adaptive", 10.0, 0.54), ("b", "adaptive", 10.0, 0.4)]
    settled = pd.DataFrame([("a", "settled dots", 10.0, 0.6)], columns=columns)
    floors = [("a", "fresh dots", 0.5), ("b", "fresh dots", 0.5), ("b", "turned", 0.1)]
    over = recovery_page.over_floor(
        pd.DataFrame(table, columns=columns), pd.DataFrame(floors, columns=["protein", "floor", "Z"]), settled
    )
    assert over.loc["b"].round(3).tolist()[:2] == [1.1, 0.8] and over.loc["a", "settled dots"] == 1.2
    assert recovery_page.everywhere(over).splitlines() == [
        "- farthest: Z at 10 % is at most 1.08 times the fresh-dots floor on 1 of 2 structures; the most is 1.100 (b): not met.",
        "- adaptive: Z at 10 % is at most 1.08 times the fresh-dots floor on 2 of 2 structures; the most is 1.080 (a): met.",
        "- settled dots: Z at 10 % is at most 1.08 times the fresh-dots floor on 0 of 1 structures; the most is 1.200 (a): not "
        "met.",
    ]
