"""Interpolate fields on a dense surface from their values at a few dots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.surfaces.surface import Surface

if TYPE_CHECKING:
    import pandas as pd

DOTS_OF_FIELD_INTERPOLANT = 24  # dots that each interpolant passes through
# Added to the diagonal, in cubed distances, since coincident dots would make the system singular
FIELD_RIDGE = 1e-9
# Targets whose distances to the dots of their function are held at once, in about a megabyte
POINTS_PER_BLOCK = 2048
SUBSET_PERCENTS = (2.5, 5, 10, 20)  # n_S of the farthest-point subsets in a study, % of the dots


def interpolate_fields(
    points: np.ndarray, fields: Mapping[str, np.ndarray], targets: np.ndarray
) -> dict[str, np.ndarray]:
    """Interpolate fields that are known at dots (n, 3) at targets (M, 3), Å: (M,) by name, within the range of known values.

    Around each dot, a cubic radial function with a linear part passes through the values of its nearest dots (Fasshauer,
    Meshfree Approximation Methods, 2007, ch. 8). A target takes the value of the function of its nearest dot.
    """
    return {name: _interpolate(points, np.asarray(values, float), targets) for name, values in fields.items()}


def _interpolate(points: np.ndarray, values: np.ndarray, targets: np.ndarray) -> np.ndarray:
    """Interpolate one field at the targets."""
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

    has_value = np.isfinite(values)
    if has_value.sum() <= 4:  # four dots determine the linear part alone
        return np.full(len(targets), values[has_value].mean() if has_value.any() else np.nan)
    points, values = points[has_value], values[has_value]
    tree, k = cKDTree(points), min(DOTS_OF_FIELD_INTERPOLANT, len(points))
    neighbours = np.asarray(tree.query(points, k)[1])
    out, nearest = np.empty(len(targets)), tree.query(targets)[1]
    used, function_of = np.unique(nearest, return_inverse=True)
    centre, scale, coefficient = _fit(points, values, neighbours[used])
    for begin in range(0, len(targets), POINTS_PER_BLOCK):
        block = slice(begin, begin + POINTS_PER_BLOCK)
        i = function_of[block]
        x = (targets[block] - points[used[i]]) / scale[i, None]
        cubed = np.linalg.norm(x[:, None] - centre[i], axis=2) ** 3
        c = coefficient[i]
        out[block] = (c[:, :k] * cubed).sum(axis=1) + c[:, k] + (c[:, k + 1 :] * x).sum(axis=1)
    # A cubic function may overshoot far where the dots around a target are uneven
    return np.clip(out, values.min(), values.max())


def _fit(
    points: np.ndarray, values: np.ndarray, neighbours: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fit a function to each row of neighbours: these (n, k, 3), in scales, the scales (n,), Å, and coefficients (n, k + 4)."""
    n, k = neighbours.shape
    centre = points[neighbours] - points[neighbours[:, :1]]
    scale = np.maximum(np.linalg.norm(centre, axis=2).max(axis=1), 1e-9)
    centre = centre / scale[:, None, None]
    system, right = np.zeros((n, k + 4, k + 4)), np.zeros((n, k + 4, 1))
    system[:, :k, :k] = np.linalg.norm(centre[:, :, None] - centre[:, None], axis=3) ** 3
    system[:, :k, k], system[:, :k, k + 1 :] = 1.0, centre
    system[:, k:, :k] = np.swapaxes(system[:, :k, k:], 1, 2)
    diagonal = np.arange(k + 4)
    # also solves for dots in one plane
    system[:, diagonal, diagonal] += np.where(diagonal < k, FIELD_RIDGE, -FIELD_RIDGE)
    right[:, :k, 0] = values[neighbours]
    return centre, scale, np.linalg.solve(system, right)[:, :, 0]


def recovery_table(
    surface: Surface,
    order: np.ndarray,
    minimal: np.ndarray | Sequence[int] = (),
    minimal_points: np.ndarray | Sequence[Sequence[float]] = (),
) -> pd.DataFrame:
    """Measure how well a few dots predict the fields of a surface at all other dots: the rows of fields.csv.

    The first `SUBSET_PERCENTS` % of `order`, farthest-point dots, are subsets; an empty `minimal` has no rows.
    """
    import pandas as pd  # here: it takes long to load, and a mesh needs no table

    n = len(surface)
    subsets = [("minimal", np.asarray(minimal), np.asarray(minimal_points))] if len(minimal) else []
    for percent in SUBSET_PERCENTS:
        dots = order[: max(1, round(percent / 100 * n))]
        subsets.append(("farthest", dots, surface.points[dots]))
    rows = []
    for field, values in surface.fields.items():
        for subset, dots, points in subsets:
            left_out = np.setdiff1d(np.arange(n), dots)
            recovered = interpolate_fields(points, {field: values[dots]}, surface.points[left_out])[field]
            rows.append(
                (field, subset, len(dots), 100 * len(dots) / n, *_errors(recovered, values[left_out]))
            )
    return pd.DataFrame(rows, columns=["field", "subset", "n_S", "n_S_percent", "r", "rms", "rms_sd"])


def _errors(recovered: np.ndarray, true: np.ndarray) -> tuple[float, float, float]:
    """Return correlation, rms error and rms error in standard deviations, over the dots where both are known."""
    has_both = np.isfinite(recovered) & np.isfinite(true)
    recovered, true = recovered[has_both], true[has_both]
    if len(true) == 0:
        return np.nan, np.nan, np.nan
    rms = np.sqrt(np.mean((recovered - true) ** 2))
    varies = np.ptp(recovered) > 0 and np.ptp(true) > 0
    return (np.corrcoef(recovered, true)[0, 1], rms, rms / true.std()) if varies else (np.nan, rms, np.nan)
