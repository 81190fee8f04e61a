"""Numbers behind the statements on the paper's Figures 1 to 5, and the best combination of each range."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
from PIL import Image

from sparsurf_study.workflow.jobs import Job
from measures.tables import write_tables
from sparsurf.patches.readings import GRID_READINGS, SCALED_READING
from sparsurf.sampling.combination import (
    PARAMETERS,
    PUBLISHED_ROWS,
    Combination,
    combination_labels,
    split_combinations,
)
from sparsurf_study.report.paper_page import LIMIT_CASES, limit_case

WIDTH = 1400  # pixels of a figure in the book
HALVES = {"rougher half": "rough_half", "flatter half": "flat_half"}
FULL_ALPHA = 1.0
PUBLISHED_BEST = (1, 0, 6, 0)


def numbers(
    grid: pd.DataFrame, best: dict, roughness: pd.Series, bins: pd.DataFrame, gathering: pd.DataFrame
) -> pd.DataFrame:
    """Return the numbers of the statements: DataFrame of figure, quantity, value, low, high (NaN without an interval)."""
    rows: list[dict] = []

    def add(figure: int, quantity: str, value: float, low: float = np.nan, high: float = np.nan) -> None:
        rows.append({"figure": figure, "quantity": quantity, "value": value, "low": low, "high": high})

    for quantity, value in (
        ("lowest", roughness.min()),
        ("highest", roughness.max()),
        ("mean", roughness.mean()),
    ):
        add(1, f"{quantity} roughness", value)
    add(1, "share of dots with roughness above 0.5", (roughness > 0.5).mean())
    for quantity, value in (("lowest", grid["n_S_percent"].min()), ("highest", grid["n_S_percent"].max())):
        add(2, f"{quantity} n_S", value)
    uniform = grid[(grid[["beta", "gamma", "delta"]] == 0).all(axis=1)].iloc[0]
    add(2, f"n_S at alpha {uniform['alpha']:g}, the others 0", uniform["n_S_percent"])
    highest = limit_case(grid, {"beta": 0, "gamma": 0, "delta": 0})["kept"]
    add(
        2,
        "highest d with beta, gamma and delta 0, kept",
        *(highest[f"d{end}_kept"] for end in ("", "_low", "_high")),
    )
    at_one = grid[np.isclose(grid["alpha"], FULL_ALPHA)]
    published = at_one[np.isclose(at_one[PARAMETERS], PUBLISHED_BEST).all(axis=1)].iloc[0]
    for reading in GRID_READINGS:
        d = [f"{key}_{reading}" for key in ("d", "d_low", "d_high")]
        winner = best[reading]["unrestricted"]
        add(3, f"d of the published best, {reading}", *published[d])
        add(3, f"rank of the published best, {reading}", 1 + (at_one[d[0]] > published[d[0]]).sum())
        add(3, f"largest d, {reading}", *(winner[f"d_cv{end}"] for end in ("", "_low", "_high")))
        add(3, f"combinations that may be the best, {reading}", winner["n_best_set"])
        add(3, f"share of combinations with d above 0, {reading}", (at_one[d[1]] > 0).mean())
        add(3, f"largest d of all, {reading}", *grid.loc[grid[d[0]].idxmax(), d])
        for beta, of_beta in at_one.groupby("beta"):
            add(
                3,
                f"highest d at alpha 1 and beta {beta:g}, {reading}",
                *of_beta.loc[of_beta[d[0]].idxmax(), d],
            )
        most = grid.loc[grid["n_S_percent"].idxmax()]
        add(3, f"d of {Combination.from_row(most)}, which keeps the most dots, {reading}", *most[d])
        for name, fixed in LIMIT_CASES.items():
            if highest := limit_case(grid, fixed)[reading]:  # a small grid may lack a case
                add(3, f"highest d of limit case {name[0]}, {reading}", *(highest[key] for key in d))
    for _, row in bins[bins["bin"].isin(HALVES)].iterrows():
        for reading in GRID_READINGS:
            d = [row[f"{key}_{reading}"] for key in ("d", "d_low", "d_high")]
            add(4, f"d of {HALVES[row['bin']]} around {row['around']}, {reading}", *d)
    for combination, of_combination in gathering.groupby("combination", sort=False):
        first, last = of_combination.iloc[0], of_combination.iloc[-1]
        add(5, f"kept of the roughest tenth, {combination}", first["kept_percent"])
        add(5, f"kept of the flattest tenth, {combination}", last["kept_percent"])
        add(5, f"kept of all dots, {combination}", first["uniform_percent"])
    add(4, "Z of the mean patch", best["references"]["Z_mean_descriptor"])
    return pd.DataFrame(rows)


def ranges_of(ranges: pd.DataFrame) -> pd.DataFrame:
    """Put the published combination of each range next to ours.

    Returns
    -------
    DataFrame, one row per reading and range: reading, row, n_S_low_percent, n_S_high_percent, published, best, d_cv with
    its 95 % interval, n_best_set, d with its interval under `kept_scaled`, published_may_be_best (yes or no: it is in the
    confidence set of the best)
    """
    row = ranges.groupby("reading").cumcount()
    published = [str(Combination(*PUBLISHED_ROWS[k])) for k in row]
    may_be = [
        "yes" if name in split_combinations(candidates) else "no"
        for name, candidates in zip(published, ranges["best_set"], strict=True)
    ]
    limits = ranges[["reading", "n_S_low_percent", "n_S_high_percent"]]
    scaled = [f"{key}_{SCALED_READING}" for key in ("d", "d_low", "d_high")]
    held_out = ranges[["d_cv", "d_cv_low", "d_cv_high", "n_best_set", *scaled]]
    table = limits.assign(row=row + 1, published=published, best=combination_labels(ranges))
    return table.join(held_out).assign(published_may_be_best=may_be)


def reduce_figure(path: str, copy: str) -> None:
    """Copy a PNG for the book, at most `WIDTH` pixels wide."""
    image = Image.open(path).convert("RGB")
    if image.width > WIDTH:
        image = image.resize((WIDTH, round(image.height * WIDTH / image.width)), Image.Resampling.LANCZOS)
    image.save(copy, optimize=True)


def tabulate_figures(job: Job) -> None:
    """Write the paper's Figures 1 to 4 from A1, the numbers behind their statements, and the best combination of each range."""
    paths, output = job.input, job.output
    bins = pd.read_csv(paths.bins)
    of_statements = numbers(
        pd.read_csv(paths.grid),
        json.loads(Path(paths.best).read_text(encoding="utf-8")),
        pd.read_csv(paths.roughness)["roughness"],
        bins,
        pd.read_csv(paths.gathering),
    )
    ranges = ranges_of(pd.read_csv(paths.ranges))
    write_tables({output.table: of_statements, output.bins: bins, output.ranges: ranges})
    for figure, copy in zip(paths.figures, output.figures, strict=True):
        reduce_figure(figure, copy)
