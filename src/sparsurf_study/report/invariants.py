"""What must hold in the results of any run: checked when a run is closed, one sentence for each invariant that breaks."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf.recovery.readings import readings_of_columns
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.views.numbers import interval
from sparsurf_study.batches.assignment import BATCH_FOLDERS
from sparsurf_study.report.front import MAX_SHOWN

FIRST_PAGE = "index.html"
ROUNDING_OF_SUMS = 1e-6  # Sums of unrounded numbers differ by less than this, relative.
AREA_OF_DOTS = 0.05  # by which the area of all dots may differ from the exact one in components.csv
PERCENT_STEP = 1e-3  # %, beyond the rounding of limits of n_S
MOST_DEVIATIONS = 5.0  # standard deviations of n_S from its closed form
MIN_DEVIATION = 1.0  # A smaller standard deviation of n_S may be that of its rounding.


def broken_invariants(run: Path, files: Iterable[str]) -> list[tuple[str, str]]:
    """Check the files of a run (paths below it); return each file that breaks an invariant, with a sentence."""
    broken = []
    for file in files:
        path = run / file
        for check in RESULT_CHECKS.get(path.name, ()) if path.is_file() else ():
            broken += [(file, sentence) for sentence in check(path)]
    return broken


def broken_batches(run: Path) -> list[tuple[str, str]]:
    """Check the Parquet tables of a run in batches: the dots of all residues are those of their surface."""
    broken = []
    for path in sorted((run / BATCH_FOLDERS[0]).glob("*.parquet")):
        if not (run / "residues" / path.name).is_file():
            broken.append((f"residues/{path.name}", "it is missing, and the table of its surfaces is there."))
            continue
        surfaces = pd.read_parquet(path, columns=["protein", "N"]).set_index("protein")["N"]
        residues = pd.read_parquet(run / "residues" / path.name, columns=["protein", "dots", "weight"])
        sums = residues.groupby("protein")[["dots", "weight"]].sum()
        for name in ("dots", "weight"):
            wrong = surfaces.index[sums[name].reindex(surfaces.index) != surfaces]
            if len(wrong):
                sentence = f"{name} of the residues of {wrong[0]} do not sum to the dots of its surface."
                broken.append((f"residues/{path.name}", sentence))
    return broken


def numbers_missing_on_page(
    run: Path, files: Iterable[str], path_to_page: str | Path | None = None
) -> list[tuple[str, str]]:
    """Return the d of ranges.csv that the first page of a run, by default in its folder, shows otherwise, or not at all."""
    page = html.unescape(Path(path_to_page or run / FIRST_PAGE).read_text(encoding="utf-8"))
    missing = []
    tables = [file for file in files if Path(file).name == "ranges.csv"]
    for file in tables[:MAX_SHOWN]:  # the page shows no more surfaces one by one
        for k, row in pd.read_csv(run / file).dropna(subset=["d_cv"]).iterrows():
            if (shown := interval(row["d_cv"], row["d_cv_low"], row["d_cv_high"])) not in page:
                missing.append((FIRST_PAGE, f"it does not show d = {shown}, which is in row {k} of {file}."))
    return missing


def n_dots(folder: Path) -> int:
    """Return the number of dots of a surface."""
    with np.load(folder / "surface.npz") as arrays:
        return len(arrays["points"])


def weights_sum_to_all_dots(path: Path) -> Iterator[str]:
    """Check that the kept dots are different dots of the surface, and represent all of them."""
    table, n = pd.read_csv(path), n_dots(path.parent)
    if table["weight"].sum() != n:
        yield f"its weights sum to {table['weight'].sum()}, not to the {n} dots of the surface."
    if table["dot"].nunique() != len(table) or not table["dot"].between(0, n - 1).all():
        yield f"its dots are not different numbers from 0 to {n - 1}."


def areas_sum_to_the_surface(path: Path) -> Iterator[str]:
    """Check that the components have nearly the area of all dots."""
    table = pd.read_csv(path)
    with np.load(path.with_name("surface.npz")) as arrays:
        area = float(arrays["area"].sum())
    if abs(table["area"].sum() - area) > AREA_OF_DOTS * area:
        yield f"its areas sum to {table['area'].sum():.2f} Å^2, not to the {area:.2f} Å^2 of the surface."


def residues_hold_all_dots(path: Path) -> Iterator[str]:
    """Check that the residues of a conformation have all dots and all kept ones."""
    if not path.with_name("surface.npz").is_file():
        return  # of a pair, or over the frames of a trajectory
    table, n = pd.read_csv(path), n_dots(path.parent)
    kept = len(pd.read_csv(path.with_name("minimal.csv"), usecols=["weight"]))
    for name, expected in (("dots", n), ("kept", kept), ("weight", n)):
        if table[name].sum() != expected:
            yield f"its column {name} sums to {table[name].sum()}, not to {expected}."


def d_is_the_difference_of_z(path: Path) -> Iterator[str]:
    """Check d = Z_tR - Z_tS and Z >= 0 in every row of a grid."""
    table = pd.read_csv(path)
    for reading in readings_of_columns(table, "d_"):
        sampled, uniform, d = (table[f"{name}_{reading}"] for name in ("Z_tS", "Z_tR", "d"))
        wrong = (uniform - sampled - d).abs() > ROUNDING_OF_SUMS * (1 + uniform)
        if wrong.any():
            yield f"d_{reading} is not Z_tR - Z_tS in {wrong.sum()} rows, first in row {wrong.idxmax()}."
        if (negative := (sampled < 0) | (uniform < 0)).any():
            yield f"Z under the reading {reading} is negative in row {negative.idxmax()}."


def n_s_is_near_its_closed_form(path: Path) -> Iterator[str]:
    """Check the mean n_S of the draws: dots are kept independently, so its variance is at most that of equal chances."""
    table, n = pd.read_csv(path), n_dots(path.parent)
    expected = table["n_S_expected"]
    variance = (expected * (1 - expected / n)).to_numpy()  # of a draw, at most; a mean varies less
    deviation = np.maximum(np.sqrt(variance), MIN_DEVIATION)
    wrong = (table["n_S"] - expected).abs() > MOST_DEVIATIONS * deviation
    if wrong.any():
        k = int(wrong.to_numpy().argmax())
        n_s, closed = table["n_S"].iloc[k], expected.iloc[k]
        yield f"n_S is {n_s:.0f} in row {k}, but {closed:.0f} in closed form."


def winners_are_the_best_of_their_range(path: Path) -> Iterator[str]:
    """Check that each winner lies in its range of n_S, and that no other combination there has a larger d."""
    grid = pd.read_csv(path.with_name("grid.csv"))
    for k, row in pd.read_csv(path).dropna(subset=["alpha"]).iterrows():
        n_s, low, high = row["n_S_percent"], row["n_S_low_percent"], row["n_S_high_percent"]
        if not low - PERCENT_STEP <= n_s <= high + PERCENT_STEP:
            yield f"the winner of row {k} keeps {n_s:g} % of the dots, outside of its range {low:g} to {high:g} %."
        d = grid[f"d_{row['reading']}"]
        d_of_winner = d[(grid[PARAMETERS] == row[PARAMETERS].to_numpy(float)).all(axis=1)]
        inside = d[grid["n_S_percent"].between(low + PERCENT_STEP, high - PERCENT_STEP)]
        if len(d_of_winner) != 1 or (len(inside) and d_of_winner.iloc[0] < inside.max() - ROUNDING_OF_SUMS):
            yield f"the winner of row {k} is not the combination with the largest d of its range in grid.csv."


def values_lie_in_their_intervals(path: Path) -> Iterator[str]:
    """Check Z >= 0 and low <= Z <= high."""
    table = pd.read_csv(path)
    slack = 0.02 * (table["high"] - table["low"]) + ROUNDING_OF_SUMS
    inside = table["Z"].between(table["low"] - slack, table["high"] + slack) | table["low"].isna()
    if not ((table["Z"] >= 0) & inside).all():
        yield "Z is negative, or lies outside of its interval."


def errors_are_distances(path: Path) -> Iterator[str]:
    """Check 0 <= mean <= 99 % quantile <= largest distance of the reconstructed surface."""
    row = pd.read_csv(path).iloc[0]
    if not 0 <= row["mean"] <= row["high_99"] <= row["largest"]:
        yield "mean, 99 % quantile and largest distance are not in this order."


def every_surface_has_its_dots(path: Path) -> Iterator[str]:
    """Check the number of dots of each surface."""
    for row in pd.read_csv(path, dtype={"protein": str, "conformation": str}, keep_default_na=False).to_dict(
        "records"
    ):
        folder = path.parent / row["protein"] / row["conformation"]
        if (folder / "surface.npz").is_file() and n_dots(folder) != row["N"]:
            yield f"N of {row['protein']}/{row['conformation']} is {row['N']}, but its surface has {n_dots(folder)} dots."


RESULT_CHECKS: dict[str, tuple[Callable[[Path], Iterator[str]], ...]] = {  # by the name of a file
    "minimal.csv": (weights_sum_to_all_dots,),
    "components.csv": (areas_sum_to_the_surface,),
    "residues.csv": (residues_hold_all_dots,),
    "grid.csv": (d_is_the_difference_of_z, n_s_is_near_its_closed_form),
    "ranges.csv": (winners_are_the_best_of_their_range,),
    "floors.csv": (values_lie_in_their_intervals,),
    "recovered.csv": (errors_are_distances,),
    "surfaces.csv": (every_surface_has_its_dots,),
}
