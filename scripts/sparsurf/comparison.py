"""Samplers compared at equal n_S, and the subset that is handed out.

Two uses are kept apart: the subset as the SURFACE itself (patches hold its dots only) and as patch
CENTRES (patches are cut from the full surface; the error is that of the nearest kept centre).
"""

import logging
import time

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from sparsurf import InputError
from sparsurf.evaluation import mean_and_error
from sparsurf.samplers import SAMPLERS, nearest_kept, weights

log = logging.getLogger("sparsurf")

PERCENTS = (2.5, 5.0, 10.0, 20.0, 40.0, 60.0)  # n_S at which samplers are compared, % of the dots
FRAGMENT = 0.3  # below this share of the patch's kept dots, Z measures how the subset breaks up


def compare(evaluator, area, percents=PERCENTS, names=None, n_tests=400, draws=3):
    """Every sampler at every n_S, under every island rule, in both uses.

    Parameters
    ----------
    evaluator : evaluation.Evaluator
    area : float
        Å^2, of the surface.
    percents : sequence of float
        Wished n_S in % of the dots.
    names : sequence of str, optional
        Samplers; all of `samplers.SAMPLERS` without.
    n_tests, draws : int

    Returns
    -------
    DataFrame, one row per sampler, n_S and measure: `measure`, `value`, `se`. Measures: 'Z surface', 'Z kept',
    'Z scaled' (island rules), 'Z surface weighted' (each kept dot counts for the dots nearest to it), 'Z centres',
    'position' (Å from a dot to the nearest kept one), 'normal' (degrees between their normals), 'fragment'
    (median evaluated patch under `kept`, % of the kept dots under `surface`), 'seconds' (of one draw).
    """
    tests = evaluator.draw_tests(n_tests)
    rows = []
    with threadpool_limits(1, "blas"):
        z_tot, _ = evaluator.describe(tests)
        for name in names or SAMPLERS:
            for percent in percents:
                n = max(1, round(percent / 100 * len(evaluator.points)))
                measures, n_s = _measure(evaluator, area, name, n, tests, z_tot, draws)
                for measure, x in measures.items():
                    value, se = mean_and_error(np.atleast_2d(x))
                    row = {"sampler": name, "percent": percent, "n_S": n_s, "measure": measure}
                    rows.append(row | {"value": float(value), "se": float(se)})
    return pd.DataFrame(rows)


def _measure(evaluator, area, name, n, tests, z_tot, draws):
    """Dict of (draws, T) arrays, or of (draws, 1) where a measure is no mean over test dots; mean n_S."""
    out = {}
    sizes = []

    def add(measure, values):
        out.setdefault(measure, []).append(values)

    for draw in range(draws):
        rng = evaluator.stream("compare", name, n, draw)
        begin = time.perf_counter()
        subset = np.sort(SAMPLERS[name](evaluator, n, rng))
        add("seconds", [time.perf_counter() - begin])
        sizes.append(len(subset))
        place, gap = nearest_kept(evaluator.points, subset)
        on_surface, dots = evaluator.distances([subset], tests, z_tot, "surface")
        kept, fragment = evaluator.distances([subset], tests, z_tot, "kept")
        add("Z surface", on_surface[0])
        add("Z kept", kept[0])
        add("Z scaled", evaluator.distances_scaled(subset, tests, z_tot, area)[0])
        share = evaluator.by_position(subset, np.bincount(place, minlength=len(subset)))
        add("Z surface weighted", evaluator.distances([subset], tests, z_tot, "surface", share)[0][0])
        centres, where = np.unique(subset[place[tests]], return_inverse=True)
        add("Z centres", np.linalg.norm(z_tot - evaluator.describe(centres)[0][where], axis=1))
        add("position", gap[tests])
        add("normal", _angle(evaluator.normals[tests], evaluator.normals[subset[place[tests]]]))
        add("fragment", [100 * np.median(fragment) / max(np.median(dots), 1)])
    if np.median(out["fragment"]) < 100 * FRAGMENT:
        log.warning(
            "%s at %d dots: the median evaluated fragment under 'kept' holds %.0f %% of the patch's kept dots; "
            "Z kept measures how the subset breaks up",
            name, n, np.median(out["fragment"]),
        )  # fmt: skip
    return {measure: np.array(values) for measure, values in out.items()}, float(np.mean(sizes))


def _angle(a, b):
    """Angle in degrees between normals, (T,)."""
    cosine = np.sum(a * b, axis=1) / (np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1))
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def needed(table, measure="Z surface", against="uniform"):
    """How many times fewer dots than `against` each sampler needs for the same Z.

    Parameters
    ----------
    table : DataFrame
        See `compare`.

    Returns
    -------
    DataFrame: one row per n_S of `against`, its Z, and per sampler the n_S (% of the dots) that reaches it, by
    interpolation of ln Z over ln n_S; NaN outside the range that was measured.
    """
    part = table[table["measure"] == measure].sort_values("n_S")
    largest = part["n_S"].max() / part["percent"].max()  # dots per percent
    reference = part[part["sampler"] == against]
    out = pd.DataFrame({"percent": reference["percent"].to_numpy(), "Z": reference["value"].to_numpy()})
    for name, own in part.groupby("sampler", sort=False):
        z, n = own["value"].to_numpy(), own["n_S"].to_numpy() / largest
        order = np.argsort(z)
        out[name] = np.exp(np.interp(np.log(out["Z"]), np.log(z[order]), np.log(n[order]), np.nan, np.nan))
    return out


def minimal_subset(evaluator, sampler="farthest", n_s=None, z=None, combination=None, n_tests=400):
    """The subset that is handed out.

    Parameters
    ----------
    evaluator : evaluation.Evaluator
    sampler : str
        A name of `samplers.SAMPLERS`.
    n_s : int, optional
        Wished number of dots.
    z : float, optional
        Wished Z under `surface`: the smallest n_S that reaches it is sought by bisection, with the test dots of
        the study.
    combination : sequence of 4 floats, optional
        Instead of a sampler: one draw of the paper's sampling with this combination.

    Returns
    -------
    (n,) int64 dots, in the order of choice, and (n,) int64 weights, the number of dots each stands for.
    """
    if combination is not None:
        kept = evaluator.pair(combination, 0)[0]
    elif z is None:
        kept = _draw(evaluator, sampler, n_s)
    else:
        kept = _smallest(evaluator, sampler, z, n_tests)
    return kept, weights(evaluator.points, kept)


def _draw(evaluator, sampler, n_s):
    return SAMPLERS[sampler](evaluator, n_s, evaluator.stream("minimal", sampler))


def _smallest(evaluator, sampler, z, n_tests):
    """Bisection on n_S; the whole surface where nothing smaller reaches z."""
    tests = evaluator.draw_tests(n_tests)
    low, high = 0, len(evaluator.points)
    with threadpool_limits(1, "blas"):
        z_tot, _ = evaluator.describe(tests)
        while high - low > 1:
            middle = (low + high) // 2
            reached = evaluator.distances([_draw(evaluator, sampler, middle)], tests, z_tot, "surface")[
                0
            ].mean()
            low, high = (low, middle) if reached <= z else (middle, high)
    if z < 0:
        raise InputError(f"minimal.Z is {z:g}, but a distance cannot be negative.")
    return _draw(evaluator, sampler, high)
