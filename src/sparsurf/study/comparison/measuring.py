"""Measure samplers at equal n_S.

A subset has two uses: as the SURFACE itself (patches contain only its dots), and as CENTRES of patches (patches are cut from
the full surface, and every dot takes the descriptor of the nearest kept centre).
"""

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from sparsurf.patches.readings import linked_by_spacing
from sparsurf.recovery.readings import RECOVERED
from sparsurf.sampling.samplers import nearest_kept
from sparsurf.study.comparison.methods import PERCENTS, Method
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.study.statistics import estimate, reference_values

log = logging.getLogger("sparsurf")

MIN_FRAGMENT = 30.0  # %, of a patch's kept dots: if fewer are linked, Z measures how the subset breaks up
SCALES = (1.2, 1.4, 1.6, 1.8, 2.0, 2.5)  # linking distances in mean spacings of the kept dots
DOTTED = "dotted"
USE = {  # of each measure: the subset as the surface, as patch centres, or only its dots
    "Z as_written": "surface",  # islands removed on the full surface
    "Z as_written weighted": "surface",  # each kept dot has as weight the number of dots nearest to it
    "Z recovered": "surface",  # a dense surface is recovered from the kept dots
    "Z scaled": "surface",  # islands removed among the kept dots, linked by their own spacing
    "Z as_coded": "surface",  # islands removed among the kept dots, linked within D_link
    "Z centres": "centres",  # patch of the nearest kept dot, cut from the full surface
    "position": "dots",  # Å to the nearest kept dot
    "normal": "dots",  # degrees between the normals of a dot and of the nearest kept one
    "median patch size scaled": "surface",  # median evaluated patch, % of the kept dots under `as_written`
    "median patch size as_coded": "surface",
    "seconds": "dots",  # of one draw, without index and cover
}


def compare_samplers(
    prepared: PreparedSurface,
    methods: Mapping[str, Method],
    percents: Sequence[float] = PERCENTS,
    n_tests: int = 400,
    draws: int = 3,
    progress: Callable[[int, int], None] = lambda done, of: None,
    floors: Mapping[str, float] | None = None,
    raw: dict[tuple[str, str], np.ndarray] | None = None,
) -> pd.DataFrame:
    """Measure every sampler at every n_S, under every reading, in both uses.

    Parameters
    ----------
    prepared : PreparedSurface
    methods : dict
        See `methods.select_methods`.
    percents : sequence of float
        Requested n_S in % of the dots.
    n_tests, draws : int
    progress : callable
        Callback with the numbers of finished and total samplers.
    floors : dict, optional
        floor -> Z, see `tables.floors_by_name`.
    raw : dict, optional
        Receives (sampler, measure) -> the (P, D, T) values behind the means, for `equal_error`.

    Returns
    -------
    DataFrame, one row per sampler, requested n_S (`percent`) and measure (see `USE`): n_S and n_S_percent (means of
    the draws), use, measure, value, se, low and high (95 % over draws and test dots; NaN if the measure is not a
    mean over test dots), and, for each Z, the reference values Z_mean_descriptor and Z_empty, and the floors Z_resampled and
    Z_turned if given.
    """
    tests = prepared.draw_tests(n_tests)
    parts = []
    z_tot, _ = prepared.describe(tests)
    references = reference_values(z_tot)
    for name, method in methods.items():
        subsets, seconds = _draw(prepared, name, method, percents, draws)
        measured = {"seconds": np.median(seconds, axis=1)}
        measured |= _measure(prepared, subsets, tests, z_tot, (len(percents), draws, -1))
        if raw is not None:
            raw |= {(name, measure): x for measure, x in measured.items() if x.ndim == 3}
        n_s = np.reshape([len(subset) for subset in subsets], (len(percents), draws)).mean(axis=1)
        parts += [_rows(name, percents, n_s, measure, measured[measure]) for measure in USE]
        progress(len(parts) // len(USE), len(methods))
    table = pd.concat(parts, ignore_index=True)
    table.insert(3, "n_S_percent", 100 * table["n_S"] / len(prepared.points))
    is_z = table["measure"].str.startswith("Z ")
    columns = {key: references[key] for key in ("Z_mean_descriptor", "Z_empty")}
    columns |= {"Z_resampled": floors["fresh dots"], "Z_turned": floors["turned"]} if floors else {}
    for key, z in columns.items():
        table[key] = np.where(is_z, z, np.nan)
    _warn_of_fragments(table, prepared.name)
    return table


def _draw(
    prepared: PreparedSurface, name: str, method: Method, percents: Sequence[float], draws: int
) -> tuple[list[np.ndarray], np.ndarray]:
    """Draw the subsets of one sampler by n_S and draw, with ascending dots; also return the seconds, (P, D)."""
    subsets, seconds = [], []
    method(1, prepared.stream("compare", name))  # prepares what all draws share, which is not timed
    for percent in percents:
        n = max(1, round(percent / 100 * len(prepared.points)))
        for k in range(draws):
            rng = prepared.stream("compare", name, n, k)
            begin = time.perf_counter()
            dots = method(n, rng)
            seconds.append(time.perf_counter() - begin)
            subsets.append(np.sort(dots))
    return subsets, np.reshape(seconds, (len(percents), draws))


def _measure(
    prepared: PreparedSurface,
    subsets: Sequence[np.ndarray],
    tests: np.ndarray,
    z_tot: np.ndarray,
    shape: tuple[int, ...],
) -> dict[str, np.ndarray]:
    """Return measure -> (P, D, T), or (P,) for measures that are not means over test dots."""
    of_subsets = [_compare_with_nearest(prepared, subset, tests, z_tot) for subset in subsets]
    nearest, distance, weighted = (np.array(x) for x in zip(*of_subsets, strict=True))
    surface, dots = prepared.distances(subsets, tests, z_tot, "as_written")
    kept, left = prepared.distances(subsets, tests, z_tot, "as_coded")
    scaled, linked = prepared.distances(subsets, tests, z_tot, "scaled")
    recovered, _ = prepared.distances(subsets, tests, z_tot, RECOVERED)
    centres, inverse = np.unique(nearest, return_inverse=True)
    of_centres = prepared.describe(centres)[0][inverse.reshape(nearest.shape)]
    whole = np.median(dots.reshape(shape), axis=(1, 2)).clip(1)

    def fragment(sizes: np.ndarray) -> np.ndarray:
        return 100 * np.median(np.reshape(sizes, shape), axis=(1, 2)) / whole

    out = {
        "Z as_written": surface,
        "Z as_written weighted": weighted,
        "Z recovered": recovered,
        "Z scaled": scaled,
        "Z as_coded": kept,
        "Z centres": np.linalg.norm(of_centres - z_tot, axis=-1),
        "position": distance,
        "normal": _angle(prepared.normals[tests], prepared.normals[nearest]),
    }
    fragments = {"median patch size scaled": fragment(linked), "median patch size as_coded": fragment(left)}
    return {measure: values.reshape(shape) for measure, values in out.items()} | fragments


def _compare_with_nearest(
    prepared: PreparedSurface, subset: np.ndarray, tests: np.ndarray, z_tot: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the nearest kept dot of each test dot, its distance in Å, and |z_tot - z| with weights, each (T,)."""
    nearest, distance = nearest_kept(prepared.points, subset, prepared.threads)
    weights = np.zeros((1, len(prepared.points)))
    weights[0, prepared.index.position[subset]] = np.bincount(nearest, minlength=len(subset))
    weighted = prepared.distances([subset], tests, z_tot, "as_written", weights)[0][0]
    return subset[nearest[tests]], distance[tests], weighted


def _angle(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the angle in degrees between normals (..., 3)."""
    cosine = np.sum(a * b, axis=-1) / (np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1))
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def _rows(
    name: str, percents: Sequence[float], n_s: np.ndarray, measure: str, values: np.ndarray
) -> pd.DataFrame:
    """Return the rows of one sampler and measure."""
    columns: dict[str, Any] = {
        "sampler": name,
        "percent": percents,
        "n_S": n_s,
        "use": USE[measure],
        "measure": measure,
    }
    if values.ndim == 3:
        mean = estimate(values)
        columns |= {"value": mean.mean, "se": mean.error, "low": mean.low, "high": mean.high}
    else:
        columns |= {"value": values, **dict.fromkeys(("se", "low", "high"), np.nan)}
    return pd.DataFrame(columns)


def _warn_of_fragments(table: pd.DataFrame, name: str) -> None:
    """Warn once if evaluated patches hold only fragments of the kept dots."""
    cases = []
    for rule in ("as_coded", "scaled"):
        part = table[table["measure"] == f"median patch size {rule}"]
        for sampler, rows in part.groupby("sampler", sort=False):
            low = rows.loc[rows["value"] < MIN_FRAGMENT, "percent"]
            if len(low):
                where = "every n_S" if len(low) == len(rows) else ", ".join(f"{p:g}" for p in low) + " %"
                cases.append((rule, where, sampler))
    if cases:
        groups = pd.DataFrame(cases, columns=["rule", "where", "sampler"]).groupby(
            ["rule", "where"], sort=False
        )
        listed = [f"{rule} at {where} ({', '.join(part['sampler'])})" for (rule, where), part in groups]
        log.warning("%s: some subsets break up, which dominates their Z: %s", name, "; ".join(listed))


def stand_alone(
    prepared: PreparedSurface,
    methods: Mapping[str, Method],
    lay: Callable[[int, np.random.Generator], tuple[np.ndarray, np.ndarray]] | None = None,
    percents: Sequence[float] = PERCENTS,
    n_tests: int = 200,
    draws: int = 3,
    scales: Sequence[float] = SCALES,
) -> pd.DataFrame:
    """Measure Z of subsets that form their own surfaces, by linking distance.

    Parameters
    ----------
    prepared : PreparedSurface
    methods : dict
        Name -> function (n, rng) -> dots, see `methods.select_methods`.
    lay : callable, optional
        (n, rng) -> points and normals, see `methods.dotted_surface`: includes the surface generated at low density.
    percents : sequence of float
    n_tests, draws : int
    scales : sequence of float

    Returns
    -------
    DataFrame: sampler, percent (requested), n_S_percent (mean of the draws), scale, Z, low, high
    """
    tests, rows = prepared.draw_tests(n_tests), []
    z_tot, _ = prepared.describe(tests)
    for name in [*methods, *([DOTTED] if lay else [])]:
        for percent in percents:
            n = max(2, round(percent / 100 * len(prepared.points)))
            subsets = []
            for draw in range(draws):
                rng = prepared.stream("stand alone", name, n, draw)
                if lay and name == DOTTED:
                    subsets.append(lay(n, rng))
                else:
                    kept = np.sort(methods[name](n, rng))
                    subsets.append((prepared.points[kept], prepared.normals[kept]))
            share = 100 * np.mean([len(points) for points, _ in subsets]) / len(prepared.points)
            for scale in scales:
                z = []
                for points, normals in subsets:
                    index = linked_by_spacing(points, normals, prepared.d_link, prepared.area, scale=scale)
                    z.append(prepared.distances_to_index(index, tests, z_tot)[0])
                mean = estimate(np.array(z))
                row = {"sampler": name, "percent": percent, "n_S_percent": share, "scale": scale}
                rows.append(row | {"Z": mean.mean, "low": mean.low, "high": mean.high})
    return pd.DataFrame(rows)
