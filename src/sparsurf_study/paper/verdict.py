"""Whether Table I is reproduced: one decision for the first page, the terminal and the page on the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

MIN_RUNS = 40  # with fewer, no rank lies outside of the central 95 %, and nothing is decided
MIN_P = 0.05  # below it, published values do not look like those of another run


def is_one_more_run(tests: pd.DataFrame) -> bool:
    """Return whether all of Table I could be one more run as published, from the rows of paper_tests.csv."""
    return bool(tests.loc[tests["measure"] == "together", "p"].iloc[0] >= MIN_P)
