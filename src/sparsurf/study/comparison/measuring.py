"""Samplers compared at equal n_S.

Two uses are kept apart: the subset as the SURFACE itself (patches hold its dots only) and as patch
CENTRES (patches are cut from the full surface; the error is that of the nearest kept centre).
"""

import logging
import time

import numpy as np
import pandas as pd

from sparsurf.patches.readings import linked_by_spacing
from sparsurf.recovery.readings import RECOVERED
from sparsurf.sampling.samplers import nearest_kept
from sparsurf.study.comparison.methods import PERCENTS
from sparsurf.study.statistics import estimate, reference_values

log = logging.getLogger("sparsurf")

FRAGMENT = 30.0  # %: where less of a patch's kept dots is left, Z measures how the subset breaks up
SCALES = (1.2, 1.4, 1.6, 1.8, 2.0, 2.5)  # linking distances in mean spacings of the kept dots
DOTTED = "dotted"
USE = {  # of each measure: the subset is the surface, gives the patch centres, or just its dots
    "Z as_written": "surface",  # islands removed on the full surface
    "Z as_written weighted": "surface",  # and each kept dot counts for the dots nearest to it
    "Z recovered": "surface",  # the kept dots are made a dense surface again, which is described as it is
    "Z scaled": "surface",  # islands removed among the kept dots, linked by their own spacing
    "Z as_coded": "surface",  # islands removed among the kept dots, linked within D_link
    "Z centres": "centres",  # patch of the nearest kept dot, cut from the full surface
    "position": "dots",  # Å to the nearest kept dot
    "normal": "dots",  # degrees between the normals of a dot and of the nearest kept one
    "fragment scaled": "surface",  # median evaluated patch, % of the kept dots under `as_written`
    "fragment as_coded": "surface",
    "seconds": "dots",  # of one draw, index and cover being there
}


def compare_samplers(
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
        floor -> Z, see `tables.as_references`.
    raw : dict, optional
        Takes (sampler, measure) -> the (P, D, T) values behind the means, for `fewer`.

    Returns
    -------
    DataFrame, one row per sampler, requested n_S (`percent`) and measure (see `USE`): n_S and n_S_percent (means of
    the draws), use, measure, value, se, low and high (95 % over draws and test dots; NaN where the measure is no
    mean over test dots), and, for each Z, the references null_model and
    empty_patch, and the floors fresh_dots and turned where given.
    """
    tests = evaluator.draw_tests(n_tests)
    parts = []
    z_tot, _ = evaluator.describe(tests)
    sticks = reference_values(z_tot)
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
    surface, dots = evaluator.distances(subsets, tests, z_tot, "as_written")
    kept, left = evaluator.distances(subsets, tests, z_tot, "as_coded")
    scaled, linked = evaluator.distances(subsets, tests, z_tot, "scaled")
    recovered, _ = evaluator.distances(subsets, tests, z_tot, RECOVERED)
    centres, place = np.unique(nearest, return_inverse=True)
    of_centres = evaluator.describe(centres)[0][place.reshape(nearest.shape)]
    whole = np.median(dots.reshape(shape), axis=(1, 2)).clip(1)

    def fragment(sizes):
        return 100 * np.median(np.reshape(sizes, shape), axis=(1, 2)) / whole

    out = {
        "Z as_written": surface,
        "Z as_written weighted": weighted,
        "Z recovered": recovered,
        "Z scaled": scaled,
        "Z as_coded": kept,
        "Z centres": np.linalg.norm(of_centres - z_tot, axis=-1),
        "position": gap,
        "normal": _angle(evaluator.normals[tests], evaluator.normals[nearest]),
    }
    fragments = {"fragment scaled": fragment(linked), "fragment as_coded": fragment(left)}
    return {measure: values.reshape(shape) for measure, values in out.items()} | fragments


def _nearest(evaluator, subset, tests, z_tot):
    """Nearest kept dot of each test dot, its distance in Å, and |z_tot - z| with weights, each (T,)."""
    place, gap = nearest_kept(evaluator.points, subset, evaluator.threads)
    share = np.zeros((1, len(evaluator.points)))
    share[0, evaluator.index.position[subset]] = np.bincount(place, minlength=len(subset))
    weighted = evaluator.distances([subset], tests, z_tot, "as_written", share)[0][0]
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
    for rule in ("as_coded", "scaled"):
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
        listed = [f"{rule} at {where} ({', '.join(part['sampler'])})" for (rule, where), part in listed]
        log.warning("%s: some subsets break up, and their Z measures that: %s", name, "; ".join(listed))


def stand_alone(evaluator, drawers, lay=None, percents=PERCENTS, n_tests=200, draws=3, scales=SCALES):
    """Z of subsets as surfaces of their own, by linking distance.

    Parameters
    ----------
    evaluator : Evaluator
    drawers : dict
        Name -> function (n, rng) -> dots, see `contestants.contestants`.
    lay : callable, optional
        (n, rng) -> points and normals, see `dotted`: lets the surface laid at low density take part.
    percents : sequence of float
    n_tests, draws : int
    scales : sequence of float

    Returns
    -------
    DataFrame: sampler, percent (requested), n_S_percent (mean of the draws), scale, Z, low, high
    """
    tests, rows = evaluator.draw_tests(n_tests), []
    z_tot, _ = evaluator.describe(tests)
    for name in [*drawers, *([DOTTED] if lay else [])]:
        for percent in percents:
            n = max(2, round(percent / 100 * len(evaluator.points)))
            subsets = [_dots(evaluator, name, drawers, lay, n, k) for k in range(draws)]
            share = 100 * np.mean([len(points) for points, _ in subsets]) / len(evaluator.points)
            for scale in scales:
                z = []
                for points, normals in subsets:
                    index = linked_by_spacing(points, normals, evaluator.d_link, evaluator.area, scale=scale)
                    z.append(evaluator.distances_to_index(index, tests, z_tot)[0])
                found = estimate(np.array(z))
                row = {"sampler": name, "percent": percent, "n_S_percent": share, "scale": scale}
                rows.append(row | {"Z": found.mean, "low": found.low, "high": found.high})
    return pd.DataFrame(rows)


def _dots(evaluator, name, drawers, lay, n, draw):
    """Points and normals of one draw."""
    rng = evaluator.stream("stand alone", name, n, draw)
    if name == DOTTED:
        return lay(n, rng)
    kept = np.sort(drawers[name](n, rng))
    return evaluator.points[kept], evaluator.normals[kept]
