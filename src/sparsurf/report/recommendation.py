"""Recommend a combination for a mean roughness and a requested n_S, or explain why the evidence is not sufficient.

The paper's last promise (Conclusions): with the best combination known for each kind of surface, the user finds it
from the mean roughness and the required number of points. A choice by mean roughness is made only if the surfaces of
the run support it in every way that `reasons` asks for; else the best combination regardless of roughness is named.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.report.numbers import interval, number, span
from sparsurf.report.page import render
from sparsurf.sampling.combination import PARAMETERS, Combination, split_combinations
from sparsurf.study.relation import EQUAL_ROUGHNESS, mean_interval, protein_means, relate_to_roughness
from sparsurf.study.summary import N_NEAREST
from sparsurf.study.tables import read_table

TEMPLATE = "recommend.txt.j2"
EVIDENCE = Path(__file__).with_name("evidence")  # of the study over many proteins, docs/proteins.md
FEWEST = 10  # proteins: with 5 a real dependence is found in 1 to 3 %, with 10 in 9 to 59 %, with 20 in 48 to 98 % of runs
SIGNIFICANT = 0.05
ABOUT = 1.05  # a requested n_S beyond the ends of the grid by less than this factor is that of the end
SHOWN = 5  # surfaces in the table of evidence
NAMES = ("protein", "conformation")
NEEDED = {
    "summary": [
        "protein", "conformation", "mean_roughness", "reading", "range", "n_S_low_percent", "n_S_high_percent",
        "n_combinations", *PARAMETERS, "n_S_percent", "d", "d_cv", "d_cv_low", "d_cv_high", "d_from_near",
        "d_from_far", "d_from_all", "local", "Z_tS", "n_best_set", "best_set",
    ],
    "relation": ["reading", "range", *PARAMETERS, "n_S_percent", "d", "d_sd", "n_surfaces"],
    "surfaces": ["protein", "spacing", "mean_roughness", "R_patch", "D_link"],
}  # fmt: skip


def read_run(folder: Path) -> dict[str, pd.DataFrame]:
    """Tables `summary`, `relation` and `surfaces` of a run, a dict of DataFrames.

    Raises
    ------
    InputError : a table is missing, unreadable, cut short or empty, or lacks a column or rows
    """
    out = {}
    for name, columns in NEEDED.items():
        path = folder / f"{name}.csv"
        if not path.is_file() and path.with_name(f"{name}.csv.gz").is_file():
            path = path.with_name(f"{name}.csv.gz")
        if not path.is_file():
            raise InputError(f"{path} cannot be read: run the study first, or give --results.")
        out[name] = read_table(path)
        names = pd.read_csv(path, dtype=str, keep_default_na=False, usecols=lambda each: each in NAMES)
        out[name][names.columns] = names  # 1E96 and NA are proteins
        missing = [column for column in columns if column not in out[name]]
        if missing or out[name].empty:
            lacking = f"the column {missing[0]}" if missing else "rows"
            raise InputError(f"{path} lacks {lacking}: run the study again.")
    ranges = out["summary"].groupby(["protein", "conformation", "reading"]).size()
    surfaces = len(ranges.groupby(["protein", "conformation"]))
    if ranges.nunique() > 1 or surfaces != len(out["surfaces"]):
        raise InputError(
            f"{folder}/summary.csv has {len(out['summary'])} ranges of {surfaces} surfaces, not all of the "
            f"{len(out['surfaces'])} in surfaces.csv: delete it and run the study again."
        )
    return out


def rows_for(summary: pd.DataFrame, reading: str, percent: float) -> pd.DataFrame:
    """Select rows of one reading, one per surface, whose range contains an n_S of about `percent` % of the dots."""
    rows = summary[(summary["reading"] == reading) & (summary["n_combinations"] > 0)]
    of_surface = summary[summary["reading"] == reading].groupby(["protein", "conformation"])
    low = of_surface["n_S_low_percent"].transform("min")
    high = of_surface["n_S_high_percent"].transform("max")
    near = np.clip(percent, low, high)[rows.index]  # no combination keeps quite all dots, nor quite as few
    inside = (rows["n_S_low_percent"] <= near) & (near <= rows["n_S_high_percent"])
    inside &= (near / ABOUT <= percent) & (percent <= near * ABOUT)
    return rows[inside].drop_duplicates(["protein", "conformation"])


def recommend(
    run: dict[str, pd.DataFrame], roughness: float, percent: float, rng: np.random.Generator
) -> str:
    """Render the answer for every reading.

    Parameters
    ----------
    run : dict
        See `read_run`.
    roughness : float
        Mean R_i of the surface.
    percent : float
        Requested n_S in % of the dots.
    rng : numpy.random.Generator

    Returns
    -------
    str
    """
    names = run["summary"]["reading"].unique()
    return render(
        TEMPLATE,
        percent=f"{percent:g}",
        roughness=number(roughness, 3),
        fewest=FEWEST,
        near=N_NEAREST,
        readings=[of_reading(run, name, roughness, percent, rng) for name in names],
    )


def of_reading(
    run: dict[str, pd.DataFrame], reading: str, roughness: float, percent: float, rng: np.random.Generator
) -> dict[str, Any]:
    """Collect the values of one reading; without surfaces if nothing was measured near `percent`."""
    own = run["summary"][run["summary"]["reading"] == reading]
    ends = own["n_S_low_percent"].min(), own["n_S_high_percent"].max()
    rows = rows_for(run["summary"], reading, percent)
    known = {"reading": reading, "ends": [number(x, 1) for x in ends], "surfaces": []}
    if rows.empty:
        return known
    rows = rows.iloc[np.argsort((rows["mean_roughness"] - roughness).abs(), kind="stable")]
    pooled = run["relation"][run["relation"]["reading"] == reading].set_index("range")
    chosen = choice(rows, relate_to_roughness(rows, rng), pooled.loc[rows["range"].mode()[0]], roughness)
    return known | {"beaten": beaten(rows)} | chosen | {"surfaces": evidence(rows)}


def beaten(rows: pd.DataFrame) -> dict[str, str] | None:
    """Say what beats the best combinations, `uniform` or `none` if the difference is not significant; None if they win."""
    d, low, high = against_uniform(rows)
    if low > 0:
        return None
    return {"by": "uniform" if high < 0 else "none", "d": interval(d, low, high)}


def against_uniform(rows: pd.DataFrame) -> tuple[float, float, float]:
    """Compute the mean cross-validated d of each surface's winner and its 95 % interval over proteins, at least 3."""
    counted = protein_means(rows)
    d, low, high = mean_interval(counted["d_cv"].to_numpy())
    if np.isnan(low):  # too few proteins: the scatter over test dots and draws of these surfaces
        half = np.sqrt((((rows["d_cv_high"] - rows["d_cv_low"]) / 2) ** 2).sum()) / len(rows)
        low, high = d - half, d + half
    return d, low, high


def reasons(rows: pd.DataFrame, found: Mapping[str, Any], roughness: float) -> Iterator[str]:
    """Yield the reasons against a choice by mean roughness, as the template names them."""
    n, low, high = found["n_proteins"], rows["mean_roughness"].min(), rows["mean_roughness"].max()
    if n < FEWEST:
        yield "few"
    if not low - EQUAL_ROUGHNESS <= roughness <= high + EQUAL_ROUGHNESS:
        yield "outside"
    if found["n_shared"] == len(rows) > 1:
        yield "shared"
    if n >= FEWEST and not found["p"] < SIGNIFICANT:
        yield "unrelated"
    if n >= FEWEST and not found["gain_low"] > 0:
        yield "far"
    if n >= FEWEST and not found["over_all_low"] > 0:
        yield "all"


def choice(
    rows: pd.DataFrame, found: Mapping[str, Any], pooled: pd.Series, roughness: float
) -> dict[str, Any]:
    """Choose the combination, with the reasons against a choice by mean roughness (see `reasons`)."""
    text = rows["local"].iloc[0]
    known = {
        "against": list(reasons(rows, found, roughness)),
        "n": len(rows),
        "proteins": found["n_proteins"],
        "seen": span(rows["mean_roughness"], lambda x: number(x, 3)),
        "shared": found.get("shared", ""),
        "p": "unknown" if np.isnan(found["p"]) else f"{found['p']:.2g}",
        "gain": interval(found["gain"], found["gain_low"], found["gain_high"]),
        "over_all": interval(found["over_all"], found["over_all_low"], found["over_all_high"]),
        "d_from_near": spread(rows["d_from_near"]),
        "d_from_all": spread(rows["d_from_all"]),
        "share": number(pooled["n_S_percent"], 0),
        "d": number(pooled["d"]) + (f" ± {number(pooled['d_sd'])}" if np.isfinite(pooled["d_sd"]) else ""),
    }
    if known["against"] and known["d"]:  # else none lies in the range on average: that of the nearest surface
        text = str(Combination.from_row(pooled))
    return known | {
        "text": text,
        "held": sum(text in split_combinations(field) for field in rows["best_set"]),
    }


def evidence(rows: pd.DataFrame) -> list[tuple[str, str, str, str]]:
    """List the surfaces nearest in mean roughness: name, roughness, best combination and its d."""
    return [
        (
            f"{row['protein']}/{row['conformation']}",
            number(row["mean_roughness"], 3),
            str(Combination.from_row(row)),
            interval(row["d_cv"], row["d_cv_low"], row["d_cv_high"]),
        )
        for _, row in rows.head(SHOWN).iterrows()
    ]


def spread(values: pd.Series) -> str:
    """Format the mean of the known values, with their standard deviation if there are several; empty without values."""
    values = values.dropna()
    return number(values.mean()) + (f" ± {number(values.std(ddof=1))}" if len(values) > 1 else "")
