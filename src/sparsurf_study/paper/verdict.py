"""Whether Table I is reproduced: one decision for the first page, the terminal and the page on the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

MIN_RUNS = 40  # with fewer, no rank lies outside of the central 95 %, and nothing is decided
MEASURES = ("d", "Z_tS")
MIN_P = 0.05  # below it, published values do not look like those of another run


def count_inside(places: pd.DataFrame) -> dict[str, int]:
    """Count the published d and Z_tS in the central 95 % of the runs, of `n` rows; the others have too few runs."""
    decided = places[places["n_runs"] >= MIN_RUNS]
    inside = {name: int(decided[f"{name}_inside"].sum()) for name in MEASURES}
    return inside | {"n": len(decided), "too_few": len(places) - len(decided)}


def is_one_more_run(tests: pd.DataFrame) -> bool:
    """Return whether all of Table I could be one more run as published, from the rows of paper_tests.csv."""
    return bool(tests.loc[tests["measure"] == "together", "p"].iloc[0] >= MIN_P)
