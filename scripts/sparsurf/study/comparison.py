"""Samplers compared at equal n_S.

Two uses are kept apart: the subset as the SURFACE itself (patches hold its dots only) and as patch
CENTRES (patches are cut from the full surface; the error is that of the nearest kept centre).
"""

import logging
import time
from functools import partial

import numpy as np
import pandas as pd

from sparsurf.patches.readings import PUBLISHED, TEXT
from sparsurf.recovery.readings import RECOVERED
from sparsurf.sampling import law, samplers
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.sampling.published import OF_PAPER, Choices
from sparsurf.sampling.samplers import HINDSIGHT, nearest_kept
from sparsurf.study.statistics import estimate, yardsticks

log = logging.getLogger("sparsurf")

PERCENTS = (2.5, 5.0, 10.0, 20.0, 40.0, 60.0)  # n_S at which samplers are compared, % of the dots
FRAGMENT = 30.0  # %: where less of a patch's kept dots is left, Z measures how the subset breaks up
NEAR = 1.1  # 'near' a wished n_S is up to this factor
USE = {  # of each measure: the subset is the surface, gives the patch centres, or just its dots
    "Z surface": "surface",  # islands removed on the full surface
    "Z surface weighted": "surface",  # and each kept dot counts for the dots nearest to it
    "Z recovered": "surface",  # the kept dots are made a dense surface again, which is described as it is
    "Z scaled": "surface",  # islands removed among the kept dots, linked by their own spacing
    "Z kept": "surface",  # islands removed among the kept dots, linked within D_link
    "Z centres": "centres",  # patch of the nearest kept dot, cut from the full surface
    "position": "dots",  # Å to the nearest kept dot
    "normal": "dots",  # degrees between the normals of a dot and of the nearest kept one
    "fragment scaled": "surface",  # median evaluated patch, % of the kept dots under `surface`
    "fragment kept": "surface",
    "seconds": "dots",  # of one draw, index and cover being there
}


def contestants(evaluator, names=None, ranges=None, grid=None, percents=PERCENTS):
    """Who takes part, and with which parameters the paper's sampler does.

    Parameters
    ----------
    evaluator : Evaluator
    names : sequence of str, optional
        Of samplers; all without.
    ranges, grid : DataFrame, optional
        ranges.csv: the paper's sampler takes its winners under `kept`; Table I of the paper without.
        grid.csv: lets the paper's sampler also take part with the combination whose Z is lowest near each n_S.
    percents : sequence of float

    Returns
    -------
    dict of functions (n, rng) -> dots, by name

    Raises
    ------
    InputError : a name that no sampler has
    """
    chosen = samplers.named(names or samplers.SAMPLERS, "compare.samplers", choices_of(ranges))
    if "paper" in chosen and grid is not None and f"Z_tS_{TEXT}" in grid:
        best = best_in_hindsight(evaluator, grid, percents)
        chosen[HINDSIGHT] = partial(samplers.paper, choices=best)
    return {name: partial(function, evaluator) for name, function in chosen.items()}


def choices_of(ranges):
    """The winners of ranges.csv under the published reading; Table I of the paper without any."""
    if ranges is None or not (ranges["islands"] == PUBLISHED).any():
        return OF_PAPER
    rows = ranges[(ranges["islands"] == PUBLISHED) & (ranges["n_combinations"] > 0)]
    return Choices(rows["n_S_low_percent"].to_numpy(), rows[PARAMETERS].to_numpy())


def best_in_hindsight(evaluator, grid, percents):
    """The combination of the grid with the lowest Z under `surface` near each n_S, as `published.Choices`.

    Near is within `NEAR` at a combination's own alpha, or the nearest. Only combinations that can keep as many dots
    take part, as their alpha is then set for n_S: Z may rise by that, above that of other choices. They were chosen on
    the very test dots of the comparison: a fair opponent, rather favoured.
    """
    rows = grid[PARAMETERS].to_numpy()
    reach = law.expected_n_s(evaluator.cover, rows * (0, 1, 1, 1) + (1, 0, 0, 0))
    best = []
    for percent in percents:
        gap = np.abs(np.log(grid["n_S_percent"].to_numpy() / percent))
        gap[100 * reach < percent * len(evaluator.points)] += 10.0  # last resort
        near = np.flatnonzero(gap <= max(np.log(NEAR), gap.min()))
        best.append(rows[near[np.argmin(grid[f"Z_tS_{TEXT}"].to_numpy()[near])]])
    return Choices(0.99 * np.array(percents), np.array(best))


def compare(
    evaluator,
    drawers,
    percents=PERCENTS,
    n_tests=400,
    draws=3,
    progress=lambda done, of: None,
    floors=None,
    raw=None,
):
    """Every sampler at every n_S, under every island rule, in both uses.

    Parameters
    ----------
    evaluator : Evaluator
    drawers : dict
        See `contestants`.
    percents : sequence of float
        Wished n_S in % of the dots.
    n_tests, draws : int
    progress : callable
        Told how many of how many samplers are done.
    floors : dict, optional
        floor -> Z, see `tables.as_yardsticks`.
    raw : dict, optional
        Takes (sampler, measure) -> the (P, D, T) values behind the means, for `comparison_intervals`.

    Returns
    -------
    DataFrame, one row per sampler, wished n_S (`percent`) and measure (see `USE`): n_S and n_S_percent (means of
    the draws), use, measure, value, se, low and high (95 % over draws and test dots; NaN where the measure is no
    mean over test dots), and, for each Z, the yardsticks null_model and
    empty_patch, and the floors fresh_dots and turned where given.
    """
    tests = evaluator.draw_tests(n_tests)
    parts = []
    z_tot, _ = evaluator.describe(tests)
    sticks = yardsticks(z_tot)
    for name, draw in drawers.items():
        subsets, seconds = _draw(evaluator, name, draw, percents, draws)
        measured = {"seconds": np.median(seconds, axis=1)}
        measured |= _measure(evaluator, subsets, tests, z_tot, (len(percents), draws, -1))
        if raw is not None:
            raw |= {(name, measure): x for measure, x in measured.items() if x.ndim == 3}
        n_s = np.reshape([len(s) for s in subsets], (len(percents), draws)).mean(axis=1)
        parts += [_rows(name, percents, n_s, measure, measured[measure]) for measure in USE]
        progress(len(parts) // len(USE), len(drawers))
    table = pd.concat(parts, ignore_index=True)
    table.insert(3, "n_S_percent", 100 * table["n_S"] / len(evaluator.points))
    of_z = table["measure"].str.startswith("Z ")
    shown = {key: sticks[key] for key in ("null_model", "empty_patch")}
    shown |= {"fresh_dots": floors["fresh dots"], "turned": floors["turned"]} if floors else {}
    for key, z in shown.items():
        table[key] = np.where(of_z, z, np.nan)
    _warn_of_fragments(table, evaluator.name)
    return table


def _draw(evaluator, name, draw, percents, draws):
    """Subsets of one sampler, ascending, n_S by n_S and draw by draw; seconds of each, (P, D)."""
    subsets, seconds = [], []
    draw(1, evaluator.stream("compare", name))  # what is done once for all draws is not their time
    for percent in percents:
        n = max(1, round(percent / 100 * len(evaluator.points)))
        for k in range(draws):
            rng = evaluator.stream("compare", name, n, k)
            begin = time.perf_counter()
            dots = draw(n, rng)
            seconds.append(time.perf_counter() - begin)
            subsets.append(np.sort(dots))
    return subsets, np.reshape(seconds, (len(percents), draws))


def _measure(evaluator, subsets, tests, z_tot, shape):
    """Dict of (P, D, T) arrays, and of (P,) arrays where a measure is no mean over test dots."""
    nearest, gap, weighted = (
        np.array(x) for x in zip(*[_nearest(evaluator, s, tests, z_tot) for s in subsets], strict=True)
    )
    surface, dots = evaluator.distances(subsets, tests, z_tot, "surface")
    kept, left = evaluator.distances(subsets, tests, z_tot, "kept")
    scaled, linked = evaluator.distances(subsets, tests, z_tot, "scaled")
    recovered, _ = evaluator.distances(subsets, tests, z_tot, RECOVERED)
    centres, place = np.unique(nearest, return_inverse=True)
    of_centres = evaluator.describe(centres)[0][place.reshape(nearest.shape)]
    whole = np.median(dots.reshape(shape), axis=(1, 2)).clip(1)

    def fragment(sizes):
        return 100 * np.median(np.reshape(sizes, shape), axis=(1, 2)) / whole

    out = {
        "Z surface": surface,
        "Z surface weighted": weighted,
        "Z recovered": recovered,
        "Z scaled": scaled,
        "Z kept": kept,
        "Z centres": np.linalg.norm(of_centres - z_tot, axis=-1),
        "position": gap,
        "normal": _angle(evaluator.normals[tests], evaluator.normals[nearest]),
    }
    fragments = {"fragment scaled": fragment(linked), "fragment kept": fragment(left)}
    return {measure: values.reshape(shape) for measure, values in out.items()} | fragments


def _nearest(evaluator, subset, tests, z_tot):
    """Nearest kept dot of each test dot, its distance in Å, and |z_tot - z| with weights, each (T,)."""
    place, gap = nearest_kept(evaluator.points, subset, evaluator.threads)
    share = np.zeros((1, len(evaluator.points)))
    share[0, evaluator.index.position[subset]] = np.bincount(place, minlength=len(subset))
    weighted = evaluator.distances([subset], tests, z_tot, "surface", share)[0][0]
    return subset[place[tests]], gap[tests], weighted


def _angle(a, b):
    """Angle in degrees between normals (..., 3)."""
    cosine = np.sum(a * b, axis=-1) / (np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1))
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def _rows(name, percents, n_s, measure, values):
    """The rows of one sampler and measure."""
    columns = {"sampler": name, "percent": percents, "n_S": n_s, "use": USE[measure], "measure": measure}
    if values.ndim == 3:
        found = estimate(values)
        columns |= {"value": found.mean, "se": found.error, "low": found.low, "high": found.high}
    else:
        columns |= {"value": values, **dict.fromkeys(("se", "low", "high"), np.nan)}
    return pd.DataFrame(columns)


def _warn_of_fragments(table, name):
    """One warning that lists where the evaluated patches are but fragments of what was kept."""
    cases = []
    for rule in ("kept", "scaled"):
        part = table[table["measure"] == f"fragment {rule}"]
        for sampler, rows in part.groupby("sampler", sort=False):
            low = rows.loc[rows["value"] < FRAGMENT, "percent"]
            if len(low):
                where = "every n_S" if len(low) == len(rows) else ", ".join(f"{p:g}" for p in low) + " %"
                cases.append((rule, where, sampler))
    if cases:
        listed = pd.DataFrame(cases, columns=["rule", "where", "sampler"]).groupby(
            ["rule", "where"], sort=False
        )
        listed = [f"'{rule}' at {where}: {', '.join(part['sampler'])}" for (rule, where), part in listed]
        log.warning(
            "%s: the median evaluated fragment holds less than %g %% of the patch's kept dots, so that Z measures "
            "how the subset breaks up, under islands %s",
            name, FRAGMENT, "; ".join(listed),
        )  # fmt: skip
