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
