"""Format numbers for pages, figures and the command line."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

from sparsurf.sampling.combination import Combination

if TYPE_CHECKING:
    import pandas as pd

    Row: TypeAlias = Mapping[Any, Any] | pd.Series  # of a table

SINGLE = "c1"  # conformation of a structure that has no others


def number(x: float | None, digits: int = 2) -> str:
    """Format a number with a true minus sign; empty if it is unknown, never -0."""
    if x is None or math.isnan(x):
        return ""
    return f"{x:z.{digits}f}".replace("-", "−").replace("inf", "∞")


def signed(x: float, digits: int = 2) -> str:
    """Format a number with its sign; a rounded 0 has none."""
    text = number(x, digits)
    return text if math.isnan(x) or x <= 0 or not text.strip("0.") else f"+{text}"


def p_value(p: float) -> str:
    """Format p with two significant digits."""
    return "below 0.0001" if p < 1e-4 else f"{p:.2g}"


def share(percent: float) -> str:
    """Format a share in %: without decimals between 10 and 99.5, else with one decimal if it is not 0."""
    return f"{percent:.0f}" if 9.95 <= percent < 99.5 else f"{percent:.1f}".removesuffix(".0")


def enough_dots(percent: float, low: float, high: float, bound: str = "") -> str:
    """Say from how many dots on Z is near a floor, with the 95 % interval if it is known; `bound` as in required_dots.csv."""
    if bound == "more":
        return "only all dots come near the floor"
    limits = f" ({share(low)} to {share(high)} %)" if math.isfinite(low) else ""
    return f"{'≤ ' if bound == 'at most' else ''}{share(percent)} %{limits} come near the floor"


def span(values: Iterable[float], form: Callable[[float], str] = number) -> str:
    """Format several values as one: the value, or the smallest to the largest."""
    low, high = form(min(values)), form(max(values))
    return low if low == high else f"{low} to {high}"


def interval(value: float, low: float, high: float, digits: int = 2) -> str:
    """Format a value with its limits in brackets if it has any."""
    limits = f" ({number(low, digits)} to {number(high, digits)})" if not math.isnan(low) else ""
    return number(value, digits) + limits


def interval_of(row: Row, name: str, reading: str = "", digits: int = 2) -> str:
    """Format a value of a row with its limits, such as d, d_low and d_high, or d_kept, d_low_kept, d_high_kept."""
    end = f"_{reading}" if reading else ""
    value, low, high = (row[f"{name}{key}{end}"] for key in ("", "_low", "_high"))
    return interval(value, low, high, digits)


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


def most_of(n: int, total: int) -> bool:
    """Return whether n of a total are most: if so many residues change, go by their order instead of their number."""
    return 2 * n > total


def short_names(places: Iterable[Iterable[str]]) -> dict[str, str]:
    """Name places (protein, conformation) for pages: protein/conformation, or the protein alone if it is a single structure."""
    names = ["/".join(place) for place in places]
    proteins = Counter(name.split("/")[0] for name in dict.fromkeys(names))
    return {
        name: protein if conformation == SINGLE and proteins[protein] == 1 else name
        for name in names
        for protein, conformation in [name.split("/")]
    }


def beyond_ranges(values: pd.Series) -> float:
    """Return the largest n_S, which belongs to no range (`study.tables.range_index`); NaN where all are equal, in one range."""
    return float(values.max()) if values.min() < values.max() else math.nan
