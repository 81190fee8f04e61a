"""Cost and error of three analyses of a subset of the dots: roughness, descriptors, and a map of complementarity.

The subset takes the place of the surface. Its linking distance grows with the distance between its dots, so that it stays
connected. The time for choosing the subset is not included.
"""

import ctypes
import gc
import resource
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from measures.timing import peak_memory
from sparsurf.pairs.partners import Partner
from sparsurf.pairs.thinning import Clock, thinned_maps
from sparsurf.patches.descriptors import describe
from sparsurf.patches.index import R_PATCH, R_ZERNIKE, PatchIndex, build_index
from sparsurf.patches.roughness import roughness
from sparsurf.sampling.samplers import Sampler, get_samplers
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.surface import Surface

ALL_DOTS = "all dots"  # in place of a sampler
REPEATS = 3  # of each analysis of a single surface; the least CPU time counts
CLEAR_REFS = Path("/proc/self/clear_refs")  # writing 5 resets the peak of memory
STATM = Path("/proc/self/statm")  # its second number: pages in memory
LEFT_OF_RESET = (
    4 * 2**20
)  # bytes: a peak that was reset may exceed the memory in use, which is counted in batches
ANALYSES = ("roughness", "descriptors", "map")
PAIRS_OF_PATCHES = 2000  # random ones, for the mean distance of two patches


@dataclass(frozen=True)
class Cost:
    """CPU seconds, and the memory in MB that an analysis adds at its peak (NaN where the system does not report it)."""

    seconds: float
    megabytes: float


@dataclass(frozen=True)
class Analyses:
    """Results of the analyses of one subset and their costs.

    Attributes
    ----------
    roughness : (n,) float64, R of the kept dots
    descriptors : (n, M) float64, of the patches around the kept dots
    maps : two (N,) float64, smoothed propensity of all dots of both partners
    costs : analysis -> Cost
    """

    roughness: np.ndarray
    descriptors: np.ndarray
    maps: list[np.ndarray]
    costs: dict[str, Cost]


def cost(run: Callable[[], Any], repeats: int = REPEATS) -> tuple[Any, Cost]:
    """Return the result of `run()` and its cost: the least CPU time and the largest memory of several calls."""
    seconds, added = [], []
    for _ in range(repeats):
        gc.collect()
        before = _reset_peak()
        begin = time.process_time()
        result = run()
        seconds.append(time.process_time() - begin)
        added.append((peak_memory() - before) / 2**20)
    return result, Cost(min(seconds), max(added))


def _reset_peak() -> float:
    """Reset the peak of memory to what this process uses now, and return it in bytes; NaN if the system does not do so."""
    try:
        ctypes.CDLL("libc.so.6").malloc_trim(0)  # returns free memory, which would hide what is taken next
        CLEAR_REFS.write_text("5", encoding="ascii")
        pages = int(STATM.read_text(encoding="ascii").split()[1])
    except OSError:
        return float("nan")
    peak = peak_memory()
    was_reset = peak - pages * resource.getpagesize() < LEFT_OF_RESET  # some systems ignore the request
    return peak if was_reset else float("nan")


def subset_index(prepared: PreparedSurface, kept: np.ndarray) -> PatchIndex:
    """Index some dots as a surface of their own; D_link grows as the mean distance between dots."""
    longer = np.sqrt(len(prepared.points) / len(kept))
    return build_index(prepared.points[kept], prepared.normals[kept], prepared.d_link * longer)


def analyse(
    prepared: PreparedSurface,
    kept: np.ndarray,
    partners: Sequence[Partner],
    sides: Sequence[PreparedSurface],
    kept_of_sides: Sequence[np.ndarray],
    repeats: int = REPEATS,
) -> Analyses:
    """Run the analyses of a subset of one surface, and of subsets of both partners of a pair (`sides`, prepared)."""

    def describe_subset() -> np.ndarray:
        return describe(subset_index(prepared, kept), prepared.points[kept], R_ZERNIKE)[0]

    def make_map() -> list[np.ndarray]:
        thin = [
            Partner(
                one.name,
                Surface(one.surface.points[dots], one.surface.normals[dots]),
                index,
                np.zeros(len(dots)),
            )
            for one, dots, index in (
                (one, dots, subset_index(side, dots))
                for one, side, dots in zip(partners, sides, kept_of_sides, strict=True)
            )
        ]
        return thinned_maps(partners, kept_of_sides, Clock(), described=thin)

    costs = {}
    rough, costs["roughness"] = cost(lambda: roughness(subset_index(prepared, kept), R_PATCH), repeats)
    vectors, costs["descriptors"] = cost(describe_subset, repeats)
    maps, costs["map"] = cost(make_map, 1)
    return Analyses(rough, vectors, maps, costs)


def choose(sampler: Sampler, name: str, prepared: PreparedSurface, percent: float) -> np.ndarray:
    """Choose dots of a surface, ascending."""
    n = round(percent / 100 * len(prepared.points))
    return np.sort(sampler(prepared, n, prepared.stream("cost", name, str(percent))))


def measure(
    surface: Surface,
    partners: Sequence[Partner],
    percents: Sequence[float],
    samplers: Sequence[str],
    seed: int,
) -> pd.DataFrame:
    """Measure the analyses of subsets of one surface and of one pair.

    Returns
    -------
    DataFrame, one row per sampler and percent, all dots last: sampler, percent, n_S_percent; of roughness, descriptors and map
    the CPU seconds, MB and times_less (seconds of all dots / seconds); roughness_error (mean |R - R of all dots|) and
    roughness_correlation at the kept dots, Z (mean distance of the descriptors of the kept dots from those of all dots),
    Z_of_two_patches (the same of two random patches of the whole surface), map_correlation (with the map of all dots, mean of
    the partners)
    """
    prepared = PreparedSurface(surface, seed=seed, name="cost")
    sides = [
        PreparedSurface(one.surface, roughness_values=one.roughness, seed=seed, name=one.name)
        for one in partners
    ]
    chosen = get_samplers(samplers, "samplers")
    few = [np.arange(200) for _ in sides]
    analyse(prepared, few[0], partners, sides, few, 1)  # compiles or loads the kernels
    everything = [np.arange(len(side.points)) for side in sides]
    every_dot = np.arange(len(prepared.points))
    whole = analyse(prepared, every_dot, partners, sides, everything)
    rng = prepared.stream("two patches")
    a, b = rng.integers(len(every_dot), size=(2, PAIRS_OF_PATCHES))
    apart = np.linalg.norm(whole.descriptors[a] - whole.descriptors[b], axis=1).mean()

    def row(name: str, percent: float, kept: np.ndarray, found: Analyses) -> dict[str, Any]:
        out: dict[str, Any] = {"sampler": name, "percent": percent}
        out["n_S_percent"] = 100 * len(kept) / len(every_dot)
        for analysis in ANALYSES:
            of_subset, of_all = found.costs[analysis], whole.costs[analysis]
            out |= {f"{analysis}_seconds": of_subset.seconds, f"{analysis}_MB": of_subset.megabytes}
            out[f"{analysis}_times_less"] = of_all.seconds / of_subset.seconds
        true, z = whole.roughness[kept], found.descriptors - whole.descriptors[kept]
        out["roughness_error"] = np.abs(found.roughness - true).mean()
        out["roughness_correlation"] = np.corrcoef(found.roughness, true)[0, 1]
        out |= {"Z": np.linalg.norm(z, axis=1).mean(), "Z_of_two_patches": apart}
        pairs = zip(found.maps, whole.maps, strict=True)
        out["map_correlation"] = np.mean([np.corrcoef(thin, full)[0, 1] for thin, full in pairs])
        return out

    rows = []
    for name, sampler in chosen.items():
        for percent in (percent for percent in percents if percent < 100):
            kept = choose(sampler, name, prepared, percent)
            kept_of_sides = [choose(sampler, name, side, percent) for side in sides]
            rows.append(row(name, percent, kept, analyse(prepared, kept, partners, sides, kept_of_sides)))
    return pd.DataFrame([*rows, row(ALL_DOTS, 100.0, every_dot, whole)])
