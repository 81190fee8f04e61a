"""Whether Table I is reproduced: one decision for the first page, the terminal and the page on the paper."""

from __future__ import annotations

import pandas as pd

from sparsurf.sampling.combination import PARAMETERS
from sparsurf.settings import SamplingSettings

MIN_RUNS = 40  # With fewer runs, no rank lies outside of the central 95 %, and nothing is decided.
# The 1,296 combinations among which the paper chose
GRID = pd.MultiIndex.from_product([getattr(SamplingSettings(), name) for name in PARAMETERS])
MEASURES = ("d", "Z_tS")
MIN_P = 0.05  # below it, published values do not look like those of another run


def said_of_grid(grid: pd.DataFrame) -> str:
    """Say how many of the paper's combinations a grid lacks, among which no best one is that of the paper; '' if none."""
    n = int(GRID.isin(pd.MultiIndex.from_frame(grid[PARAMETERS])).sum())
    return "" if n == len(GRID) else f"The grid has {n:,} of the paper's {len(GRID):,} combinations"


def why_undecided(places: pd.DataFrame, reduced: str) -> str:
    """Say why it is undecided whether Table I is reproduced, from what `said_of_grid` says; '' where it is decided."""
    n_runs = int(places["n_runs"].max())
    few = f"{n_runs} runs were made as published, and the comparison needs at least {MIN_RUNS}"
    return reduced or (few if n_runs < MIN_RUNS else "")


def count_inside(places: pd.DataFrame) -> dict[str, int]:
    """Count the published d and Z_tS in the central 95 % of the runs, of `n` rows; the others have too few runs."""
    decided = places[places["n_runs"] >= MIN_RUNS]
    inside = {name: int(decided[f"{name}_inside"].sum()) for name in MEASURES}
    return inside | {"n": len(decided), "too_few": len(places) - len(decided)}


def is_one_more_run(tests: pd.DataFrame) -> bool:
    """Return whether all of Table I could be one more run as published, from the rows of paper_tests.csv."""
    return bool(tests.loc[tests["measure"] == "together", "p"].iloc[0] >= MIN_P)
