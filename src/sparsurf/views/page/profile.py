"""The mean roughness of the residues along each chain, laid out for a drawing of any kind."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd

from sparsurf.evaluation.ranking import is_ranked
from sparsurf.views.numbers import number

N_ROUGHEST = 10
PROFILE_CSS = "profile.css"  # The style of a panel, which profile.html.j2 draws.
PROFILE_WIDTH, PROFILE_HEIGHT = 760, 190  # The size of the drawing of a row of residues.
RESIDUES_PER_ROW = 100  # A row shows at most so many residues of a chain.
LEFT, RIGHT, TOP, BOTTOM = 52, 12, 12, 26  # margins around its curve
LABEL_ROOM = 44  # Two numbers below the axis are at least so far apart.
STEPS_OF_LABELS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
STEP_OF_LEVELS = 0.1  # The axis of the roughness has a level at each such step.
STEPS_OF_WIDER_AXES = (0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500)
MAX_LEVELS = 10
ROUGHNESS_COLUMN = "mean_roughness"


class Mark(NamedTuple):
    """A residue in the drawing of its chain."""

    x: float
    y: float
    label: str
    value: float
    rough: bool  # one of the residues that are marked
    residue: int  # its row in the table


class PanelRow(NamedTuple):
    """The drawing of consecutive residues of a chain; lengths are in pixels from the upper left corner."""

    lowest: Mark
    highest: Mark
    width: int
    height: int
    curves: list[str]  # points of the lines between consecutive residues
    marks: list[Mark]
    ticks: list[tuple[float, str]]  # below the axis
    levels: list[tuple[float, str]]  # beside the axis


class Panel(NamedTuple):
    """The drawing of one chain, in rows."""

    chain: str
    rows: list[PanelRow]


def roughest(
    residues: pd.DataFrame, column: str = ROUGHNESS_COLUMN, n: int | None = N_ROUGHEST
) -> pd.DataFrame:
    """Return the rows of the n ranked residues with the lowest mean roughness, the lowest first; of all with None."""
    exposed = residues[residues[column].notna() & is_ranked(residues["area"])]
    return exposed.sort_values(column, kind="stable").iloc[:n]


def columns_of_means(residues: pd.DataFrame) -> list[str]:
    """Return the columns with the mean of a field."""
    return [str(name) for name in residues if str(name).startswith("mean_") and name != ROUGHNESS_COLUMN]


def labels_of(residues: pd.DataFrame) -> list[str]:
    """Return the labels of residues, as 'GLU 209 A'."""
    names = zip(residues["residue_name"], residues["residue"], residues["chain"], strict=True)
    return [" ".join(filter(None, map(str, name))) for name in names]


def stretches(residues: pd.DataFrame, column: str = ROUGHNESS_COLUMN) -> list[np.ndarray]:
    """Return the positions in a chain's table of residues that follow one another: numbered so, and with a value."""
    numbers = residue_numbers(residues)
    has_value = residues[column].notna().to_numpy()
    jumps = np.diff(numbers) > 1
    ends = 1 + np.flatnonzero(jumps | ~has_value[1:] | ~has_value[:-1])
    return [part for part in np.split(np.arange(len(residues)), ends) if has_value[part].all() and len(part)]


def residue_numbers(residues: pd.DataFrame) -> np.ndarray:
    """Return the numbers of residues without their insertion codes, (n,) int."""
    return residues["residue"].astype(str).str.extract(r"(-?\d+)", expand=False).fillna("0").to_numpy(int)


def chains(residues: pd.DataFrame, column: str = ROUGHNESS_COLUMN) -> Iterator[tuple[str, pd.DataFrame]]:
    """Iterate over the chains that have a residue with a value, in the order of the structure."""
    for name, rows in residues.groupby("chain", sort=False):
        if rows[column].notna().any():
            yield str(name), rows


def limits(residues: pd.DataFrame, column: str = ROUGHNESS_COLUMN) -> tuple[float, float]:
    """Return the ends of the axis of the values: multiples of its step, tenths for the roughness, around all of them."""
    low, high = residues[column].min(), residues[column].max()
    step = step_of_levels(low, high)
    return math.floor(low / step) * step, math.ceil(high / step + 1e-9) * step


def step_of_levels(low: float, high: float) -> float:
    """Return the step of the numbers beside an axis."""
    steps = (STEP_OF_LEVELS, *STEPS_OF_WIDER_AXES)
    return next((step for step in steps if (high - low) / step <= MAX_LEVELS), steps[-1])


def places_of_labels(residues: pd.DataFrame, room: float) -> list[int]:
    """Return the positions of residues with round numbers, such that labels of consecutive ones have room; in residues."""
    numbers = residue_numbers(residues)
    step = next((step for step in STEPS_OF_LABELS if step >= room), STEPS_OF_LABELS[-1])
    places: list[int] = []
    for place, value in enumerate(numbers.tolist()):
        if value % step == 0 and (not places or place - places[-1] >= room):
            places.append(place)
    return places or [0]


def panels(
    residues: pd.DataFrame, column: str = ROUGHNESS_COLUMN, marked: pd.Index | None = None
) -> list[Panel]:
    """Lay out the drawing of every chain, with one axis for all; none where no residue has a value.

    The residues of the index `marked` are marked, or without one the roughest.
    """
    if not residues[column].notna().any():
        return []
    low, high = limits(residues, column)
    step = step_of_levels(residues[column].min(), residues[column].max())
    marked = roughest(residues, column).index if marked is None else marked
    drawn = residues.assign(rough=residues.index.isin(marked), drawn=residues[column])
    return [Panel(name, [*_rows(rows, low, high, step)]) for name, rows in chains(drawn, "drawn")]


def _rows(residues: pd.DataFrame, low: float, high: float, step: float) -> Iterator[PanelRow]:
    """Lay out the rows of one chain, as wide as the page; rows without a value are left out."""
    per_row = min(len(residues), RESIDUES_PER_ROW)
    for begin in range(0, len(residues), RESIDUES_PER_ROW):
        part = residues.iloc[begin : begin + RESIDUES_PER_ROW]
        if part["drawn"].notna().any():
            yield _row(part, per_row, low, high, step)


def _row(rows: pd.DataFrame, per_row: int, low: float, high: float, step_of_axis: float) -> PanelRow:
    """Lay out residues of one chain, of which a row has room for `per_row`; the roughest of the molecule are `rough`."""
    values = rows["drawn"].to_numpy(float)
    width = PROFILE_WIDTH
    step = (width - LEFT - RIGHT) / per_row
    across = LEFT + step * (np.arange(len(rows)) + 0.5)
    down = TOP + (PROFILE_HEIGHT - TOP - BOTTOM) * (high - values) / (high - low)
    curves = [" ".join(f"{across[k]:.1f},{down[k]:.1f}" for k in part) for part in stretches(rows, "drawn")]
    labels, rough = labels_of(rows), rows["rough"].tolist()
    marks = []
    for k in np.flatnonzero(np.isfinite(values)).tolist():
        x, y = round(float(across[k]), 1), round(float(down[k]), 1)
        marks.append(Mark(x, y, labels[k], float(values[k]), rough[k], int(rows.index[k])))
    places = places_of_labels(rows, LABEL_ROOM / step)
    ticks = [(round(float(across[k]), 1), str(rows["residue"].iloc[k])) for k in places]
    count = round((high - low) / step_of_axis)
    digits = 0 if step_of_axis >= 1 else 1
    levels = [
        (round(TOP + (PROFILE_HEIGHT - TOP - BOTTOM) * k / count, 1), number(high - k * step_of_axis, digits))
        for k in range(0, count + 1, max(1, math.ceil(count / 5)))
    ]
    lowest, highest = (choose(marks, key=lambda mark: mark.value) for choose in (min, max))
    return PanelRow(lowest, highest, width, PROFILE_HEIGHT, curves, marks, ticks, levels)
