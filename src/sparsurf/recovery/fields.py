"""Fields of a dense surface from their values at a few dots."""

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

NEIGHBOURS = 24  # dots that each interpolant goes through
RIDGE = 1e-9  # of the diagonal, in cubed distances; keeps two dots at one place from making a system singular
SLICE = 2048  # places at a time
PERCENTS = (2.5, 5, 10, 20)  # of the dots, at which a study looks


def recovered_fields(points, fields, places):
    """Values at places of fields that are known at dots.

    Around each dot a cubic radial function with a linear part goes through the values of its nearest dots (Fasshauer,
    Meshfree Approximation Methods, 2007, ch. 8); a place takes that of its nearest dot.

    Parameters
    ----------
    points : (n, 3) float64, Å, the dots
    fields : dict, name -> (n,) float64; a dot with NaN is left out
    places : (M, 3) float64, Å

    Returns
    -------
    dict, name -> (M,) float64; within the range of the known values; NaN where no dot has any
    """
    return {name: _recovered(points, np.asarray(values, float), places) for name, values in fields.items()}


def _recovered(points, values, places):
    known = np.isfinite(values)
    if known.sum() <= 4:  # a plane through four dots leaves nothing to bend
        return np.full(len(places), values[known].mean() if known.any() else np.nan)
    points, values = points[known], values[known]
    tree, k = cKDTree(points), min(NEIGHBOURS, len(points))
    near = tree.query(points, k)[1]
    out, nearest = np.empty(len(places)), tree.query(places)[1]
    used, place_of = np.unique(nearest, return_inverse=True)
    centre, scale, coefficient = _fitted(points, values, near[used])
    for a in range(0, len(places), SLICE):
        i = place_of[a : a + SLICE]
        x = (places[a : a + SLICE] - points[used[i]]) / scale[i, None]
        cubed = np.linalg.norm(x[:, None] - centre[i], axis=2) ** 3
        c = coefficient[i]
        out[a : a + SLICE] = (c[:, :k] * cubed).sum(axis=1) + c[:, k] + (c[:, k + 1 :] * x).sum(axis=1)
    return np.clip(out, values.min(), values.max())


def _fitted(points, values, near):
    """Neighbours (n, k, 3) relative to their dot, in scales; scales (n,), Å; coefficients (n, k + 4)."""
    n, k = near.shape
    centre = points[near] - points[near[:, :1]]
    scale = np.maximum(np.linalg.norm(centre, axis=2).max(axis=1), 1e-9)
    centre = centre / scale[:, None, None]
    system, right = np.zeros((n, k + 4, k + 4)), np.zeros((n, k + 4, 1))
    system[:, :k, :k] = np.linalg.norm(centre[:, :, None] - centre[:, None], axis=3) ** 3
    system[:, :k, k], system[:, :k, k + 1 :] = 1.0, centre
    system[:, k:, :k] = np.swapaxes(system[:, :k, k:], 1, 2)
    diagonal = np.arange(k + 4)
    system[:, diagonal, diagonal] += np.where(diagonal < k, RIDGE, -RIDGE)  # dots in one plane are no trouble
    right[:, :k, 0] = values[near]
    return centre, scale, np.linalg.solve(system, right)[:, :, 0]


def recovery_table(surface, order, minimal=(), places=()):
    """How well few dots give the fields of a surface back at all other dots.

    Parameters
    ----------
    surface : Surface with fields
    order : (m,) int, farthest-point dots, of which the first PERCENTS of all dots are taken
    minimal, places : (n,) int, dots of the minimal subset, and (n, 3), Å, where they lie; without, there is no row of it

    Returns
    -------
    DataFrame: field, subset ('minimal' or 'farthest'), n_S, n_S_percent, r (correlation), rms in the field's unit, and
    rms_sd, in standard deviations of the field
    """
    n = len(surface)
    farthest = [order[: max(1, round(percent / 100 * n))] for percent in PERCENTS]
    subsets = [("minimal", minimal, places)] if len(minimal) else []
    subsets += [("farthest", dots, surface.points[dots]) for dots in farthest]
    rows = []
    for name, values in surface.fields.items():
        for subset, dots, at in subsets:
            others = np.setdiff1d(np.arange(n), dots)
            found = recovered_fields(at, {name: values[dots]}, surface.points[others])[name]
            rows.append((name, subset, len(dots), 100 * len(dots) / n, *_errors(found, values[others])))
    return pd.DataFrame(rows, columns=["field", "subset", "n_S", "n_S_percent", "r", "rms", "rms_sd"])


def _errors(found, true):
    """Correlation, rms error and that in standard deviations, where both are known; NaN where the field does not vary."""
    both = np.isfinite(found) & np.isfinite(true)
    found, true = found[both], true[both]
    if len(true) == 0:
        return np.nan, np.nan, np.nan
    rms = np.sqrt(np.mean((found - true) ** 2))
    varies = np.ptp(found) > 0 and np.ptp(true) > 0
    return (np.corrcoef(found, true)[0, 1], rms, rms / true.std()) if varies else (np.nan, rms, np.nan)
