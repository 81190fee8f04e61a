"""Values of the pages of pairs: of one pair, and of all pairs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pandas as pd

from sparsurf.report.numbers import against_zero

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
N_SHOWN = 10  # best-matching pairs of patches


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
    partners : two str that describe them
    bare : sequence of str, '1' and '2' for the partners without atoms
    """
    shown = best.head(N_SHOWN).drop(columns=["dot_1", "dot_2"], errors="ignore").iloc[:, :7]
    return {
        "name": name,
        "within": settings["complementarity"]["interface"],
        "partners": partners,
        "bare": list(bare),
        "sides": [side_of(side, rows) for side, rows in agreement.groupby("partner")],
        "scores": {
            called(str(score)): rows.set_index("partner").to_dict("index")
            for score, rows in agreement.groupby("score", sort=False)
        },
        "contacts": contacts.to_dict("records"),
        "best_columns": shown.columns.tolist(),
        "best": shown.to_numpy(object).tolist(),
        "n_best": len(best),
    }


def side_of(side: Any, agreement: pd.DataFrame) -> dict[str, Any]:
    """Collect the AUC of the map and the strongest baseline of one partner."""
    by_score = agreement.set_index("score")
    blocks: Any = by_score.loc[MAIN_SCORE, "blocks"]
    return {"side": side, "blocks": int(blocks)} | main_and_baseline(by_score, "auc")


def main_and_baseline(by_score: pd.DataFrame, column: str) -> dict[str, Any]:
    """Return the main score with its limits and position relative to 0.5, and the baseline farthest from 0.5."""
    baselines: pd.Series[float] = by_score[~by_score.index.str.startswith(PATCH_SCORES)][column]
    strongest = str((baselines - 0.5).abs().idxmax())
    main: Any = by_score.loc[MAIN_SCORE]
    return {
        "auc": main[column],
        "low": main["low"],
        "high": main["high"],
        "place": against_zero(main["low"] - 0.5, main["high"] - 0.5),
        "baseline": called(strongest),
        "baseline_auc": baselines[strongest],
    }


def means_by_score(means: pd.DataFrame) -> pd.DataFrame:
    """Return means.csv by score, with limits from 0 to 1, which Student's t of few pairs exceeds."""
    by_score = means.set_index("score")
    by_score[["low", "high"]] = by_score[["low", "high"]].clip(0, 1)
    return by_score


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
    by_score = means_by_score(means)
    known = main_and_baseline(by_score, "mean") if len(by_score) else {"auc": None}
    of_pair = table[table["score"] == MAIN_SCORE].groupby("complex", sort=False)["auc"].mean()
    return known | {
        "run": run,
        "n_pairs": n_pairs,
        "n_touching": n_touching,
        "scores": by_score.rename(index=called).to_dict("index"),
        "pairs": of_pair.to_dict(),
    }
