"""Page on all surfaces of a run, and on whether the best parameters correlate with mean roughness."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import bdtr

from sparsurf.patches.readings import FULL_READING
from sparsurf.recovery.readings import RECOVERED, readings_of_columns
from sparsurf.report.numbers import combination, interval, number, share, short_names, span
from sparsurf.study.required_dots import COLUMN_PREFIX, CURVE_PERCENTS
from sparsurf.study.required_dots import MIN_DOTS as FEWEST_DOTS

TEMPLATE = "summary.html.j2"
SIGNIFICANT = 0.05


def summary_page(
    run: str, surfaces: pd.DataFrame, relation: pd.DataFrame, draws: int | None = None
) -> dict[str, Any]:
    """Collect the values of the page from surfaces.csv and relation.csv; `draws` is the number of draws of each combination."""
    readings = readings_of_columns(surfaces, "best_")
    known = relation[relation["p"].notna()]
    names = short_names(surfaces[["protein", "conformation"]].itertuples(index=False))
    columns = 7 if len(known) else 5  # the last two are empty where nothing was tested
    return {
        "run": run,
        "readings": readings,
        "related": int((known["p"] < SIGNIFICANT).sum()),
        "rows_tested": len(known),
        "by_chance": by_chance(len(known)),
        "surfaces": [surface_row(row, readings, names) for _, row in surfaces.iterrows()],
        "floors": floor_rows(surfaces),
        "relations": {
            reading: [row[:columns] for row in relation_rows(relation[relation["reading"] == reading])]
            for reading in readings
        },
        "draws": draws,
    }


def by_chance(n: int) -> int:
    """Return how many of n tests at most fall below p = 0.05 by chance, in 95 of 100 such runs."""
    return next(k for k in range(n + 1) if bdtr(k, n, SIGNIFICANT) >= 1 - SIGNIFICANT)


def surface_row(row: pd.Series, readings: list[str], names: dict[str, str]) -> list[str]:
    """Format one surface: its name, dots, mean roughness, then best combination and d with interval by reading."""
    name = names[f"{row['protein']}/{row['conformation']}"]
    cells = [name, f"{row['N']:,}", number(row["mean_roughness"], 3)]
    for reading in readings:
        ends = (row[f"d_cv_{end}{reading}"] for end in ("", "low_", "high_"))
        cells += [row[f"best_{reading}"], interval(*ends)]
    return cells


def floor_rows(surfaces: pd.DataFrame) -> list[list[str]]:
    """Format a row per noise floor: the share of dots that reaches it, as they are and recovered, median (lowest to highest)."""
    columns = [str(column) for column in surfaces]
    names = [
        name.removesuffix(f"_{FULL_READING}")
        for name in columns
        if name.startswith(COLUMN_PREFIX) and name.endswith(FULL_READING)
    ]
    # the fewest dots that are tried
    fewest = 100 * np.maximum(FEWEST_DOTS, np.round(CURVE_PERCENTS[0] / 100 * surfaces["N"])) / surfaces["N"]
    return [
        [
            name.removeprefix(COLUMN_PREFIX).replace("_", " "),
            *(required_dots_text(surfaces.get(f"{name}_{r}"), fewest) for r in (FULL_READING, RECOVERED)),
        ]
        for name in names
    ]


def required_dots_text(percents: pd.Series | None, fewest: pd.Series) -> str:
    """Format the shares of dots that are enough: median and range; "all" if no fewer are, ≤ if the fewest tried are."""
    if percents is None or percents.dropna().empty:
        return ""
    known = percents.dropna()
    sign = "≤ " if (known <= 1.0001 * fewest[known.index]).all() else ""
    ends = span(known, _share)
    return sign + _share(known.median()) + (f" ({ends})" if " to " in ends else "")


def _share(percent: float) -> str:
    """Format a share of the dots."""
    return "all" if percent >= 100 else share(percent)


def relation_rows(rows: pd.DataFrame) -> list[list[str]]:
    """Format a row per range of n_S, see the heading in the template."""
    return [
        [
            f"{number(row['n_S_low_percent'], 0)} – {number(row['n_S_high_percent'], 0)}",
            combination(row),
            number(row["d"]) + (f" ± {number(row['d_sd'])}" if not math.isnan(row["d_sd"]) else ""),
            f"{row['n_winners']} of {row['n_surfaces']}",
            f"{row['n_shared']} of {row['n_surfaces']}",
            "" if math.isnan(row["p"]) else f"{row['p']:.2g}",
            interval(row["gain"], row["gain_low"], row["gain_high"]),
        ]
        for _, row in rows.iterrows()
    ]
