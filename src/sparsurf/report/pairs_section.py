"""Values of the pairs on the first page: how well their maps find the interface, next to protrusion."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pandas as pd

from sparsurf.pairs.ranking import means_over_pairs
from sparsurf.report.numbers import against_zero, interval

MAIN_SCORE, BASELINE = "propensity_smoothed", "protrusion"
SCORES = {
    "propensity": "complementarity, nearest patch",
    "propensity_smoothed": "complementarity, smoothed",
    "propensity_k": "complementarity, mean of the nearest",
    "propensity_k_smoothed": "complementarity, mean smoothed",
    "similarity": "similarity, nearest patch",
    "similarity_smoothed": "similarity, smoothed",
    "protrusion": "protrusion: few heavy atoms within 10 Å",
}
FILES = ("propensity.csv", "best_pairs.csv", "residues.csv", "open.pml", "open.cxc")  # linked from its rows
MAX_SHOWN = 100  # pairs in the table


def pairs_in(files: Iterable[str]) -> list[str]:
    """List the pairs that have files."""
    of_pairs = (path for path in files if path.startswith("pairs/") and path.count("/") > 1)
    return list(dict.fromkeys(path.split("/")[1] for path in of_pairs))


def pairs_section(table: pd.DataFrame, files: Iterable[str]) -> dict[str, Any]:
    """Collect the mean AUC over the pairs that touch, or that of each partner of one, and a row per pair and partner.

    `files` are those that the page may link, from the folder of the run.
    """
    files = dict.fromkeys(files)
    pairs = pairs_in(files)
    touching = table["complex"].nunique()
    section: dict[str, Any] = {"n": len(pairs), "touching": touching, "auc": None, "partners": []}
    if touching > 1:
        means = means_over_pairs(table).set_index("score")
        section["auc"], section["baseline"] = (
            auc_of(means, score, "mean") for score in (MAIN_SCORE, BASELINE)
        )
        section["place"] = against_zero(*(means.loc[MAIN_SCORE, ["low", "high"]] - 0.5))
    elif touching:  # the mean of two partners has no interval
        section["partners"] = sides_of(table)
    section["rows"] = [
        (name, [f"pairs/{name}/{file}" for file in FILES if f"pairs/{name}/{file}" in files], sides_of(rows))
        for name in pairs[:MAX_SHOWN]
        for rows in [table[table["complex"] == name]]
    ]
    return section


def sides_of(rows: pd.DataFrame) -> list[tuple[int, str, str]]:
    """Format the AUC of the main score and of the baseline of each partner; none if the partners do not touch."""
    return [
        (side, auc_of(of_side, MAIN_SCORE, "auc"), auc_of(of_side, BASELINE, "auc"))
        for side in rows["partner"].unique()
        for of_side in [rows[rows["partner"] == side].set_index("score")]
    ]


def auc_of(table: pd.DataFrame, key: Any, column: str) -> str:
    """Format an AUC of one row with its 95 % interval; empty if there is no such row."""
    return interval(*table.loc[key, [column, "low", "high"]]) if key in table.index else ""
