"""The molecular surface as dots with normals, and the checks that the dots of any file pass."""

import logging
from dataclasses import dataclass

import numpy as np

from sparsurf import InputError

log = logging.getLogger("sparsurf")

CONTACT, SADDLE, CONCAVE = 0, 1, 2  # kinds of dots
ROUNDED = 2e-3  # normals of three decimals are this near to unit length: sqrt(3) * 0.0005 and a reserve
ODD = 0.05  # normals so far from unit length may be something else


@dataclass(frozen=True, eq=False)
class Surface:
    """Dots of a molecular surface; their order is part of it, since the method sweeps them in it. The arrays are copied.

    Attributes
    ----------
    points : (N, 3) float64, Å
    normals : (N, 3) float64, outward, unit length but for the rounding of a file (three decimals)
    area : (N,) float64, Å^2; NaN where unknown
    kind : (N,) int8, 0 contact, 1 saddle, 2 concave; -1 where unknown
    atom : (N,) int32, index into the structure; -1 where unknown

    Raises
    ------
    InputError : no dots, shapes that disagree, NaN or infinite values, normals that are not unit vectors
    """

    points: np.ndarray
    normals: np.ndarray
    area: np.ndarray = None
    kind: np.ndarray = None
    atom: np.ndarray = None

    def __post_init__(self):
        n = len(self.points)
        types = {"points": float, "normals": float, "area": float, "kind": np.int8, "atom": np.int32}
        for name, dtype in types.items():
            value = getattr(self, name)
            if value is None:
                value = np.full(n, np.nan if name == "area" else -1)
            object.__setattr__(self, name, np.array(value, dtype, order="C"))
            shape, found = ((n, 3) if name in ("points", "normals") else (n,)), getattr(self, name).shape
            if found != shape:
                wished = "(N, 3), a row for each dot" if name == "points" else shape
                raise InputError(f"surface: {name} has the shape {found}, not {wished}.")
        if n == 0:
            raise InputError("surface: there are no dots.")
        if not (np.isfinite(self.points).all() and np.isfinite(self.normals).all()):
            raise InputError("surface: coordinates or normals are NaN or infinite.")
        if np.abs(np.linalg.norm(self.normals, axis=1) - 1).max() > ROUNDED:
            raise InputError("surface: normals are not of unit length; divide each by its length.")

    def __len__(self):
        return len(self.points)


def surface_of_columns(columns, path):
    """The surface of the columns that a file holds.

    Parameters
    ----------
    columns : dict of arrays: points and normals, and any other attribute of `Surface`
    path : named in messages

    Returns
    -------
    Surface, in the order of the file; normals as they are where only rounding keeps them from unit length (the
    authors' descriptors follow from the rounded ones: a dot in 40 changes its pixel otherwise), else of unit
    length; of dots that occur twice the first

    Raises
    ------
    InputError : NaN or infinite numbers, normals of length 0, no dots
    """
    columns = {name: np.asarray(value) for name, value in columns.items()}
    points, normals = (columns[name].reshape(-1, 3) for name in ("points", "normals"))
    if len(points) == 0:
        raise InputError(f"{path} holds no dots.")
    if not (np.isfinite(points).all() and np.isfinite(normals).all()):
        raise InputError(f"{path} has NaN or infinite coordinates or normals: remove those dots.")
    length = np.linalg.norm(normals, axis=1)
    short = np.flatnonzero(length < 0.5)
    if len(short):
        raise InputError(f"{path}: dot {short[0] + 1} has a normal of length {length[short[0]]:.3f}, not 1.")
    if np.abs(length - 1).max() > ODD:
        log.warning("%s: normals of length %.3g to %.3g are scaled to 1", path, length.min(), length.max())
    far = np.abs(length - 1) > ROUNDED
    columns["normals"] = np.where(far[:, None], normals / length[:, None], normals)
    _, first = np.unique(np.hstack([points, normals]), axis=0, return_index=True)
    if len(first) < len(points):
        message = "%s: %d dots that occur twice are removed; numbers of dots count those that remain, from 0"
        log.warning(message, path, len(points) - len(first))
        columns = {name: value[np.sort(first)] for name, value in columns.items()}
    return Surface(**columns)
