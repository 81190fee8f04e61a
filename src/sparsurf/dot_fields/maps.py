"""Maps: numbers on a grid in space, such as a potential (OpenDX) or a density (CCP4, MRC), between whose points dots lie."""

from __future__ import annotations

import logging
import os
import re
import warnings
from typing import Any, NamedTuple, TypeGuard

import numpy as np

from sparsurf.errors import FILE, InputError, naming_file
from sparsurf.files import StrPath, as_path, ends_in, existing_file, read_text, shorten

log = logging.getLogger("sparsurf")

DX = ".dx"
MAPS = (DX, ".mrc", ".map", ".ccp4")
# Words of the header of CCP4 and MRC, counted from 1, each the first of three
WORD_OF_START, WORD_OF_INTERVALS, WORD_OF_AXES, WORD_OF_ORIGIN = 5, 8, 17, 50
FIRST_LENGTH = 11  # The first of the six words that describe the cell.
ON_BORDER = 1e-6  # steps of the grid by which a dot on its border may seem to lie outside
END_OF_NUMBERS = re.compile(r"^\s*(attribute|object|component)", re.MULTILINE)


class MapGrid(NamedTuple):
    """Values (I, J, K) on a grid: the position of the first one, and the three steps (3, 3) between neighbours, Å."""

    values: np.ndarray
    origin: np.ndarray
    steps: np.ndarray


def is_map(field: Any) -> TypeGuard[str]:
    """Return whether a user gave the path of a map in place of the name of a field."""
    return isinstance(field, str) and ends_in(field, MAPS)


def name_of_map(path: str) -> str:
    """Return the name of the field of a map, which is that of its file: apbs_dx."""
    name = re.sub(r"\W", "_", as_path(path).name, flags=re.ASCII)
    return name if name[0].isalpha() else f"map_{name}"


def values_of_map(path: str, points: np.ndarray) -> np.ndarray:
    """Return the values (N,) of a map between its grid points, in proportion to the distances along its axes; NaN outside."""
    from scipy.ndimage import map_coordinates  # here: few fields are maps

    with naming_file(path):
        values, origin, steps = grid = (_read_dx if DX in path.lower()[-6:] else _read_ccp4)(path)
        if not all(np.isfinite(part).all() for part in grid[1:]) or abs(np.linalg.det(steps)) < ON_BORDER**2:
            raise InputError(f"{FILE} states no origin and no three axes of its grid: write the map again.")
        place = np.linalg.solve(steps.T, (points - origin).T)
        last = np.array(values.shape)[:, None] - 1.0
        outside = ((place < -ON_BORDER) | (place > last + ON_BORDER)).any(axis=0)
        if outside.all():
            raise InputError(
                f"no dot lies in the map {FILE}: map and structure must have the same origin; move one onto the other."
            )
        if outside.any():
            message = "%s: %.3g %% of the dots lie outside of the map and have no value; give a map of the whole molecule"
            log.warning(message, FILE, 100 * outside.mean())
    out = map_coordinates(values, place.clip(0.0, last), output=float, order=1, mode="nearest")
    return np.where(outside, np.nan, out)


def _read_dx(path: StrPath) -> MapGrid:
    """Read a map in the text format of OpenDX, as APBS and VMD write it, whose last axis varies fastest."""
    head, _, body = read_text(path).partition("data follows")
    counts = re.search(r"gridpositions\s+counts((?:\s+\d+){3})", head)
    vectors = [
        np.array(
            [line.split()[:3] for line in re.findall(rf"^\s*{word}\s+(\S+\s+\S+\s+\S+)", head, re.MULTILINE)]
        )
        for word in ("origin", "delta")
    ]
    if not (counts and body and [len(rows) for rows in vectors] == [1, 3]):
        raise InputError(
            f"{FILE} is no map in text of OpenDX, with counts, origin, three deltas and data: write it by APBS or VMD."
        )
    shape = [int(number) for number in counts[1].split()]
    end = END_OF_NUMBERS.search(body)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            values = np.fromstring(body[: end and end.start()], sep=" ")
            origin, steps = (rows.astype(float) for rows in vectors)
    except (ValueError, DeprecationWarning):
        raise InputError(f"{FILE} has a word among its numbers that is none: write the map again.") from None
    if len(values) != np.prod(shape):
        raise InputError(f"{FILE} holds {len(values):,} values of {np.prod(shape):,}: copy it again.")
    return MapGrid(values.reshape(shape), origin[0], steps)


def _read_ccp4(path: StrPath) -> MapGrid:
    """Read a map in the format of CCP4 and MRC; an ORIGIN, which gemmi ignores, counts in place of the first grid point."""
    import gemmi

    existing_file(path)
    try:
        stored = gemmi.read_ccp4_map(os.fspath(path))
    except (RuntimeError, ValueError, OSError) as error:
        raise InputError(f"{FILE} is no map of CCP4 or MRC ({shorten(error)}): write it again.") from None
    start, intervals, axes = (
        np.array([stored.header_i32(word + k) for k in range(3)])
        for word in (WORD_OF_START, WORD_OF_INTERVALS, WORD_OF_AXES)
    )
    lengths = [stored.header_float(FIRST_LENGTH + k) for k in range(6)]
    origin = np.array([stored.header_float(WORD_OF_ORIGIN + k) for k in range(3)])
    if sorted(axes) != [1, 2, 3] or min(intervals) < 1 or not min(lengths) > 0:
        raise InputError(f"{FILE} states no cell, or no axes of its grid: write the map again.")
    order = np.argsort(axes)  # of columns, rows and sections along x, y and z
    cell = np.array(gemmi.UnitCell(*lengths).orth.mat.tolist())
    steps = (cell / intervals).T
    if not origin.any():
        origin = start[order] @ steps
    return MapGrid(np.asarray(stored.grid.array).transpose(order), origin, steps)
