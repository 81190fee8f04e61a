"""Pages of pairs: of one pair, and of all pairs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pandas as pd

from sparsurf.report.numbers import against_zero, interval, number

TEMPLATE, OF_ALL = "pair.html.j2", "pairs.html.j2"
MAIN_SCORE = "propensity_smoothed"  # of the answer
PATCH_SCORES = (
    "propensity",
    "similarity",
)  # prefixes of scores that compare patches; the others are baselines
SCORES = {
    "propensity": "complementarity, nearest patch",
    "propensity_smoothed": "complementarity, smoothed",
    "propensity_k": "complementarity, mean of the nearest",
    "propensity_k_smoothed": "complementarity, mean smoothed",
    "similarity": "similarity, nearest patch",
    "similarity_smoothed": "similarity, smoothed",
    "flatness": "roughness of the patch",
    "planarity": "planarity over 10 Å",
    "centroid": "distance from the centroid",
    "protrusion": "protrusion: few heavy atoms within 10 Å",
    "hydropathy": "hydropathy over 10 Å (Kyte-Doolittle)",
}
N_SHOWN = 10  # best-matching pairs of patches, or pairs by name


def called(score: str) -> str:
    """Return the name of a score on pages and in figures."""
    return SCORES.get(score, score)


def pair_page(
    name: str,
    agreement: pd.DataFrame,
    contacts: pd.DataFrame,
    best: pd.DataFrame,
    settings: dict[str, Any],
    partners: Sequence[str],
    bare: Sequence[str] = (),
) -> dict[str, Any]:
    """Collect the values of the page of one pair.

    Parameters
    ----------
    name : str
    agreement, contacts, best : DataFrames of agreement.csv, contacts.csv and best_pairs.csv
    settings : dict, the config's `patches` and `complementarity`
    partners : two str, what they are
    bare : sequence of '1', '2', the partners without atoms
    """
    dot_columns = ["dot_1", "dot_2"]
    return {
        "name": name,
        "within": f"{settings['complementarity']['interface']:g}",
        "partners": partners,
        "bare": list(bare),
        "sides": [side_of(side, rows) for side, rows in agreement.groupby("partner")],
        "scores": score_rows(agreement),
        "contacts": [interval(*row) for row in contacts[["auc", "low", "high"]].to_numpy()],
        "best_columns": [column for column in best.columns if column not in dot_columns][:7],
        "best": [
            list(map(_cell, row))
            for row in best.head(N_SHOWN).drop(columns=dot_columns, errors="ignore").iloc[:, :7].to_numpy()
        ],
        "n_best": len(best),
    }


def _cell(value: Any) -> str:
    """Format a cell of the table of best pairs."""
    return number(value) if isinstance(value, float) else str(value)


def side_of(side: Any, agreement: pd.DataFrame) -> dict[str, Any]:
    """Collect the AUC of the map and the best baseline of one partner."""
    by_score = agreement.set_index("score")
    baselines: pd.Series[float] = by_score[~by_score.index.str.startswith(PATCH_SCORES)]["auc"]
    main: Any = by_score.loc[MAIN_SCORE]
    return {
        "side": side,
        "auc": number(main["auc"]),
        "place": against_zero(main["low"] - 0.5, main["high"] - 0.5),
        "baseline": called(str(baselines.idxmax())),
        "baseline_auc": number(baselines.max()),
    }


def score_rows(agreement: pd.DataFrame) -> list[tuple[str, list[str]]]:
    """Format a row per score: its name, AUC with interval of partner 1 and of partner 2."""
    by_score: dict[str, dict[int, str]] = {}
    for _, row in agreement.iterrows():
        text = interval(row["auc"], row["low"], row["high"])
        by_score.setdefault(row["score"], {})[int(row["partner"])] = text
    return [(called(score), [texts.get(side, "") for side in (1, 2)]) for score, texts in by_score.items()]


def pairs_page(
    run: str, means: pd.DataFrame, n_pairs: int, n_touching: int, table: pd.DataFrame
) -> dict[str, Any]:
    """Collect the values of the page of all pairs.

    Parameters
    ----------
    run : str
    means : DataFrame
        means.csv: the mean AUC of each score over the pairs.
    n_pairs, n_touching : int
        Number of pairs, and of pairs with an interface.
    table : DataFrame
        pairs.csv: the AUC of each pair, partner and score.
    """
    by_score = means.set_index("score")
    known: dict[str, Any] = {"auc": None}
    if len(by_score):
        by_score[["low", "high"]] = by_score[["low", "high"]].clip(
            0, 1
        )  # Student's t of few pairs exceeds them
        main: Any = by_score.loc[MAIN_SCORE]
        baselines: pd.Series[float] = by_score[~by_score.index.str.startswith(PATCH_SCORES)]["mean"]
        known = {
            "auc": interval(main["mean"], main["low"], main["high"], 3),
            "place": against_zero(main["low"] - 0.5, main["high"] - 0.5),
            "baseline": called(str(baselines.idxmax())),
            "baseline_auc": number(baselines.max(), 3),
        }
    of_pair = table[table["score"] == MAIN_SCORE].groupby("complex", sort=False)["auc"].mean()
    return known | {
        "run": run,
        "n_pairs": n_pairs,
        "n_touching": n_touching,
        "scores": [
            (called(str(score)), interval(row["mean"], row["low"], row["high"], 3))
            for score, row in by_score.iterrows()
        ],
        "pairs": [(name, number(auc)) for name, auc in of_pair.items()],
    }
