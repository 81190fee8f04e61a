"""Page on the best combinations of one surface: of all, and per range of n_S."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from sparsurf.patches.readings import SCALED_READING
from sparsurf.recovery.readings import READINGS
from sparsurf.report.numbers import against_zero, combination, interval, number, share

TEMPLATE = "ranges.html.j2"
REFERENCES = {
    "Z_empty": "an empty patch",
    "Z_two_patches": "two different patches",
    "Z_mean_descriptor": "the mean patch in place of every patch",
}


def ranges_page(
    name: str, ranges: pd.DataFrame, best: dict[str, Any], references: dict[str, Any]
) -> dict[str, Any]:
    """Collect the values of the page from ranges.csv and the two parts of `tables.best_combinations`."""
    readings = [key for key in READINGS if key in best]
    errors = {key: references[key] for key in REFERENCES} | references.get("floors", {})
    return {
        "name": name,
        "best": {reading: best_of(best[reading]["unrestricted"]) for reading in readings},
        "under_max": {reading: best_of(best[reading]["under_max_n_S"]) for reading in readings},
        "max_n_S": f"{best['max_n_S_percent']:g}",
        "tables": {reading: rows_of(ranges[ranges["reading"] == reading]) for reading in readings},
        "counts": {
            reading: counts(ranges[ranges["reading"] == reading], references["Z_mean_descriptor"])
            for reading in readings
        },
        "draws": best["draws"],
        "references": [(REFERENCES.get(key, key), number(z)) for key, z in errors.items()],
    }


def best_of(row: Mapping[str, Any]) -> dict[str, Any]:
    """Format a best combination; if there is none, return the reason as `answer`."""
    if "answer" in row:
        return {"answer": row["answer"]}
    ends = row["d_cv_low"], row["d_cv_high"]
    return {
        "combination": combination(row),
        "n_S": share(row["n_S_percent"]),
        "d": interval(row["d_cv"], *ends),
        "place": against_zero(*ends),
        "set": int(row["n_best_set"]),
        "every_dot": row["n_S_percent"] > 99.995,
    }


def counts(rows: pd.DataFrame, z_mean_descriptor: float) -> dict[str, int]:
    """Count the ranges in which the best combination significantly beats a uniform subset, or loses to it, or has a Z above
    that of the mean patch."""
    rows = rows.dropna(subset="d_cv_low")
    return {
        "n": len(rows),
        "above": int((rows["d_cv_low"] > 0).sum()),
        "below": int((rows["d_cv_high"] < 0).sum()),
        "above_null": int((rows["Z_tS"] > z_mean_descriptor).sum()),
    }


def rows_of(rows: pd.DataFrame) -> list[list[str]]:
    """Format a row per range: n_S, combination, its n_S, d with interval (also scaled link), Z_tS, dots of the median patch."""
    return [
        [
            f"{number(row['n_S_low_percent'], 1)} – {number(row['n_S_high_percent'], 1)}",
            combination(row),
            number(row["n_S_percent"], 1),
            interval(row["d_cv"], row["d_cv_low"], row["d_cv_high"]),
            interval(*(row[f"{key}_{SCALED_READING}"] for key in ("d", "d_low", "d_high"))),
            number(row["Z_tS"]),
            number(row["median_patch_size"], 0),
        ]
        for _, row in rows.iterrows()
    ]
