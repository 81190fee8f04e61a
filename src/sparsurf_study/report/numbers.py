"""Format numbers and rows of tables for the pages and figures of a study."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

from sparsurf.patches.readings import FRAGMENTED_BELOW
from sparsurf.sampling.combination import Combination
from sparsurf.views.numbers import interval, share

if TYPE_CHECKING:
    import pandas as pd

    Row: TypeAlias = Mapping[Any, Any] | pd.Series  # of a table

SINGLE = "c1"  # conformation of a structure that has no others


def p_value(p: float) -> str:
    """Format p with two significant digits."""
    return "below 0.0001" if p < 1e-4 else f"{p:.2g}"


def interval_of(row: Row, name: str, reading: str = "") -> str:
    """Format a value of a row with its limits, such as d, d_low and d_high, or d_kept, d_low_kept, d_high_kept."""
    end = f"_{reading}" if reading else ""
    value, low, high = (row[f"{name}{key}{end}"] for key in ("", "_low", "_high"))
    return interval(value, low, high)


def auc_of(table: pd.DataFrame, key: Any, column: str) -> str:
    """Format an AUC of one row with its 95 % interval; empty if there is no such row."""
    return interval(*table.loc[key, [column, "low", "high"]]) if key in table.index else ""


def combination(row: Row) -> str:
    """Format α, β, γ, δ of a row; empty if it has none."""
    return "" if math.isnan(row["alpha"]) else str(Combination.from_row(row))


def against_zero(low: float, high: float) -> str:
    """Classify a 95 % interval as above, below or around 0, or as unknown."""
    if math.isnan(low):
        return "unknown"
    return "above" if low > 0 else "below" if high < 0 else "around"


def is_fragmented(row: Row) -> bool:
    """Say whether the median patch of a subset has less than half of its kept dots in its island."""
    return bool(row.get("share_in_island", math.nan) < FRAGMENTED_BELOW)


def left_in_island(row: Row) -> str:
    """Format the share of a patch's kept dots in its island, and say where the subset is fragmented; "–" if it is unknown."""
    if math.isnan(row["share_in_island"]):
        return "–"
    return f"{share(100 * row['share_in_island'])} %" + (", fragmented" if is_fragmented(row) else "")


def most_of(n: int, total: int) -> bool:
    """Return whether n of a total are most: if so many residues change, go by their order instead of their number."""
    return 2 * n > total


def short_names(places: Iterable[Iterable[str]]) -> dict[str, str]:
    """Name places (protein, conformation) for pages: protein/conformation, or the protein alone if it is a single structure."""
    names = ["/".join(place) for place in places]
    proteins = Counter(name.split("/")[0] for name in dict.fromkeys(names))
    shown = {}
    for name in names:
        protein, conformation = name.split("/")
        is_single = conformation == SINGLE and proteins[protein] == 1
        shown[name] = protein if is_single else name
    return shown


def beyond_ranges(values: pd.Series) -> float:
    """Return the largest n_S, which is in no range (see `analysis.tables.range_index`); NaN where all are equal, in one range."""
    return float(values.max()) if values.min() < values.max() else math.nan


def better_than_uniform(grid: pd.DataFrame, reading: str) -> tuple[int, int]:
    """Count the rows of a grid.csv whose d lies above 0 with its 95 % interval, where that is known, and all.

    The combination that keeps the most dots is in no range of n_S and does not count.
    """
    d = grid[f"d_{reading}"]
    low = grid.get(f"d_low_{reading}", d).fillna(d)
    in_ranges = d.notna() & (grid["n_S_percent"] != beyond_ranges(grid["n_S_percent"]))
    return int((in_ranges & (low > 0)).sum()), int(in_ranges.sum())
