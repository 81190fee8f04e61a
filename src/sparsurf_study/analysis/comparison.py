"""Samplers compared at equal n_S, on one surface and over proteins.

A subset has two uses: as the SURFACE itself (patches contain only its dots), and as CENTRES of patches (patches are cut from
the full surface, and every dot takes the descriptor of the nearest kept centre). The paper's sampling takes part with the
combinations that its criterion chose.
"""

import logging
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from sparsurf import registry
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import estimate, reference_values
from sparsurf.patches.readings import FRAGMENTED_BELOW
from sparsurf.progress import Report, unreported
from sparsurf.recovery.readings import RECOVERED
from sparsurf.sampling import samplers
from sparsurf.sampling.combination import choices_from_ranges

log = logging.getLogger("sparsurf")

Method = Callable[[int, np.random.Generator], np.ndarray]  # (n, rng) -> dots

REFERENCE = "uniform"  # sampler with which the others are compared
USE = {  # of each measure: the subset as the surface, as patch centres, or only its dots
    "Z full": "surface",  # all but the largest island removed on the full surface
    "Z full weighted": "surface",  # each kept dot has as weight the number of dots nearest to it
    "Z recovered": "surface",  # a dense surface is reconstructed from the kept dots
    "Z kept_scaled": "surface",  # all but the largest island removed among the kept dots, linked by their own spacing
    "Z kept": "surface",  # all but the largest island removed among the kept dots, linked within d_link
    "Z centres": "centres",  # patch of the nearest kept dot, cut from the full surface
    "position": "dots",  # Å to the nearest kept dot
    "normal": "dots",  # degrees between the normals of a dot and of the nearest kept one
    "median patch size kept_scaled": "surface",  # median evaluated patch, % of the kept dots under `full`
    "median patch size kept": "surface",
    "seconds": "dots",  # of one draw, without index and cover
}
FRAGMENTED = "kept", "kept_scaled"  # readings under which a subset may fall into islands
COMPARISON_KEYS = ["sampler", "percent", "use", "measure"]


def select_methods(
    prepared: PreparedSurface, names: Iterable[str] | None, ranges: pd.DataFrame | None = None
) -> dict[str, Method]:
    """Select samplers, all by default: functions (n, rng) -> dots by name, the paper's with winners of `ranges` or of Table I."""
    # compared with the interpolant, for which dots that touch every atom were not chosen
    of_dots = [
        name for name, choice in registry.TABLE["sampler"].items() if choice.applies != registry.ORIGIN
    ]
    chosen = samplers.get_samplers(names or of_dots, "compare.samplers", choices_from_ranges(ranges))
    return {name: partial(sampler.__call__, prepared) for name, sampler in chosen.items()}


def compare_samplers(
    prepared: PreparedSurface,
    methods: Mapping[str, Method],
    percents: Sequence[float],
    n_tests: int,
    draws: int,
    progress: Report = unreported,
    floors: Mapping[str, float] | None = None,
) -> pd.DataFrame:
    """Measure every sampler at every requested n_S, %, under every reading, in both uses: the rows of compare.csv.

    `floors` are of `tables.floors_by_name`. Intervals are over draws and test dots; NaN if the measure is not a mean over these.
    """
    tests = prepared.draw_tests(n_tests)
    parts = []
    z_tot, _ = prepared.describe(tests)
    references = reference_values(z_tot)
    for name, method in methods.items():
        subsets, seconds = _draw(prepared, name, method, percents, draws)
        measured = {"seconds": np.median(seconds, axis=1)}
        measured |= _measure(prepared, subsets, tests, z_tot, (len(percents), draws, -1))
        n_s = np.reshape([len(subset) for subset in subsets], (len(percents), draws)).mean(axis=1)
        parts += [_rows(name, percents, n_s, measure, measured[measure]) for measure in USE]
        progress(len(parts) // len(USE), len(methods))
    table = pd.concat(parts, ignore_index=True)
    table.insert(3, "n_S_percent", 100 * table["n_S"] / len(prepared.points))
    is_z = table["measure"].str.startswith("Z ")
    columns = {key: references[key] for key in ("Z_mean_descriptor", "Z_empty")}
    columns |= {"Z_resampled": floors["fresh dots"]} if floors else {}
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
    z, sizes = {}, {}
    for reading in ("full", *FRAGMENTED, RECOVERED):
        z[f"Z {reading}"], sizes[reading] = prepared.distances(subsets, tests, z_tot, reading)
    centres, inverse = np.unique(nearest, return_inverse=True)
    of_centres = prepared.describe(centres)[0][inverse.reshape(nearest.shape)]
    size = {reading: np.median(of_dots.reshape(shape), axis=(1, 2)) for reading, of_dots in sizes.items()}
    out = z | {
        "Z full weighted": weighted,
        "Z centres": np.linalg.norm(of_centres - z_tot, axis=-1),
        "position": distance,
        "normal": _angle(prepared.normals[tests], prepared.normals[nearest]),
    }
    fragments = {
        f"median patch size {reading}": 100 * size[reading] / size["full"].clip(1) for reading in FRAGMENTED
    }
    return {measure: values.reshape(shape) for measure, values in out.items()} | fragments


def _compare_with_nearest(
    prepared: PreparedSurface, subset: np.ndarray, tests: np.ndarray, z_tot: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the nearest kept dot of each test dot, its distance in Å, and |z_tot - z| with weights, each (T,)."""
    nearest, distance = samplers.nearest_kept(prepared.points, subset, prepared.threads)
    weights = np.zeros((1, len(prepared.points)))
    weights[0, prepared.index.position[subset]] = np.bincount(nearest, minlength=len(subset))
    weighted = prepared.distances([subset], tests, z_tot, "full", weights)[0][0]
    return subset[nearest[tests]], distance[tests], weighted


def _angle(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the angle in degrees between normals (..., 3)."""
    cosine = np.sum(a * b, axis=-1) / (np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1))
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def _rows(
    name: str, percents: Sequence[float], n_s: np.ndarray, measure: str, values: np.ndarray
) -> pd.DataFrame:
    """Return the rows of one sampler and measure."""
    columns: dict[str, Any] = {"sampler": name, "percent": percents, "n_S": n_s}
    columns |= {"use": USE[measure], "measure": measure}
    if values.ndim == 3:
        mean = estimate(values)
        columns |= {"value": mean.mean, "se": mean.error, "low": mean.low, "high": mean.high}
    else:
        columns |= {"value": values, **dict.fromkeys(("se", "low", "high"), np.nan)}
    return pd.DataFrame(columns)


def _warn_of_fragments(table: pd.DataFrame, name: str) -> None:
    """Warn once of the subsets that are fragmented, under each reading that keeps the largest island of the kept dots."""
    cases = []
    for rule in FRAGMENTED:
        part = table[table["measure"] == f"median patch size {rule}"]
        for sampler, rows in part.groupby("sampler", sort=False):
            low = rows.loc[rows["value"] < 100 * FRAGMENTED_BELOW, "percent"]
            if len(low):
                where = "every n_S" if len(low) == len(rows) else ", ".join(f"{p:g}" for p in low) + " %"
                cases.append((rule, where, sampler))
    if cases:
        groups = pd.DataFrame(cases, columns=["rule", "where", "sampler"]).groupby(
            ["rule", "where"], sort=False
        )
        listed = [
            f"under {rule}, those of {', '.join(part['sampler'])} at {where}"
            for (rule, where), part in groups
        ]
        log.warning("%s: some subsets are fragmented, which dominates their Z: %s", name, "; ".join(listed))


def means_by_protein(tables: Mapping[tuple[str, str], pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """Average tables of `compare_samplers` over the conformations of each protein; those of a single protein stay separate."""
    names = list(dict.fromkeys(protein for protein, _ in tables))
    if len(names) == 1:
        return {f"{protein}/{conformation}": table for (protein, conformation), table in tables.items()}
    out = {}
    for name in names:
        of_protein = pd.concat([table for (protein, _), table in tables.items() if protein == name])
        out[name] = of_protein.groupby(COMPARISON_KEYS, sort=False).mean(numeric_only=True).reset_index()
    return out


def means_over_proteins(units: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Compute means and spread over proteins, or over conformations of a single one: the rows of compare.csv of a run."""
    rows = pd.concat([table.assign(unit=name) for name, table in units.items()])
    reference = rows[rows["sampler"] == REFERENCE].set_index(["unit", "percent", "measure"])["value"]
    keys = pd.MultiIndex.from_frame(rows[["unit", "percent", "measure"]])
    with np.errstate(divide="ignore", invalid="ignore"):
        rows["ratio"] = rows["value"].to_numpy() / reference.reindex(keys).to_numpy()
    groups = rows.groupby(COMPARISON_KEYS, sort=False)
    out = groups[["n_S_percent"]].mean()
    for name in ("value", "ratio"):
        spread = groups[name].agg(["mean", "std", "min", "max"])
        prefix = "" if name == "value" else "ratio_"
        out[[name, f"{prefix}sd", f"{prefix}lowest", f"{prefix}highest"]] = spread
    out["n"] = groups["value"].size()
    references = [key for key in ("Z_mean_descriptor", "Z_empty", "Z_resampled") if key in rows]
    out[references] = groups[references].mean()
    return out.reset_index()


def smallest_n_s(z: float, n: np.ndarray, values: np.ndarray) -> float:
    """Find the smallest n_S that reaches Z = z on a curve, its rises removed; 0 below the smallest n, inf beyond the largest."""
    values = np.minimum.accumulate(values).clip(1e-9)
    if z > values[0]:
        return 0.0
    if not z >= values[-1]:
        return np.inf
    k = int(np.argmax(values <= z))
    if k == 0:
        return float(n[0])
    share = np.log(values[k - 1] / max(z, 1e-9)) / np.log(values[k - 1] / values[k])
    return float(n[k - 1] * (n[k] / n[k - 1]) ** share)
