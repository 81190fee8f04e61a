"""The grid: compare sampled and random subsets of every combination with the full surface.

By default, all combinations share their test dots and, in each draw, the random numbers of their pairs (centre, dot), so that
they differ by the dots that they keep and less by chance. They also share the random subsets of each draw: the first n_S dots
of one random order. In readings where a subset forms its own surface, Z_tR
is measured at `N_CURVE_SIZES` n_S, with as many draws, and interpolated, since it depends on n_S alone.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from sparsurf.errors import InputError
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import estimate
from sparsurf.patches import descriptors
from sparsurf.patches.readings import GRID_READINGS, SCALED_READING
from sparsurf.progress import Report, unreported
from sparsurf.sampling import published
from sparsurf.sampling.combination import PARAMETERS, Combination
from sparsurf.threads import parallel_map

# n_S of a curve: linear interpolation over ln n_S is off by 0.0005, while draws scatter by 0.01
N_CURVE_SIZES = 32
TESTS_AT_ONCE = 20  # progress is reported every 20 test dots


@dataclass(frozen=True)
class Grid:
    """Raw distances of a grid with K combinations, D draws and T test dots."""

    combinations: np.ndarray  # (K, 4) float64
    n_dots: int  # N
    n_s: np.ndarray  # (K, D) int64
    n_s_expected: np.ndarray  # (K,) float64
    tests: np.ndarray  # (T,) int64 dots, or (K, T) if every combination has its own
    z_tot: np.ndarray  # (T, 121) float64, descriptors of the full surface at the (shared) test dots
    z_ts: np.ndarray  # (readings, K, D, T) float32, |z_tot - z_S|
    z_tr: np.ndarray  # the same of z_R
    median_patch_size: np.ndarray  # (readings, 2, K) float64, of sampled and of random subsets
    readings: tuple[str, ...]


def evaluate_grid(
    prepared: PreparedSurface,
    combinations: ArrayLike,
    n_tests: int,
    draws: int = 1,
    readings: Sequence[str] = GRID_READINGS,
    shared: bool = True,
    progress: Report = unreported,
) -> Grid:
    """Evaluate every combination, (K, 4), with `draws` sampled and random subsets each.

    `GRID_READINGS` are computed in one pass. The others need a surface per sampled subset, and per random subset (per n_S of a
    curve if more than `N_CURVE_SIZES` combinations share their test dots). Unless `shared`, test dots, random numbers and random
    subsets are drawn anew for each combination, as published.
    """
    combinations = np.asarray(combinations, float)
    tests = prepared.draw_tests(n_tests)
    if not shared:
        tests = np.array([prepared.draw_tests(n_tests, *Combination(*c).keys()) for c in combinations])
    out = _empty_grid(prepared, combinations, tests, draws, readings)
    if shared:
        _evaluate_with_shared_tests(prepared, out, tests, progress)
    else:
        # The reference values of Z follow from one set of test dots, which no combination has to itself
        out.z_tot[:] = prepared.describe(prepared.draw_tests(n_tests))[0]
        _evaluate_with_own_tests(prepared, out, tests, progress)
    return out


def _empty_grid(
    prepared: PreparedSurface,
    combinations: np.ndarray,
    tests: np.ndarray,
    draws: int,
    readings: Sequence[str],
) -> Grid:
    """Allocate a Grid."""
    n, n_tests = len(combinations), tests.shape[-1]
    shape = (len(readings), n, draws, n_tests)
    return Grid(
        combinations=combinations,
        n_dots=len(prepared.points),
        n_s=np.empty((n, draws), np.int64),
        n_s_expected=published.expected_n_s(prepared.cover, combinations),
        tests=tests,
        z_tot=np.empty((n_tests, descriptors.descriptor_of(prepared.patches.descriptor).width)),
        z_ts=np.empty(shape, np.float32),
        z_tr=np.empty(shape, np.float32),
        median_patch_size=np.empty((len(readings), 2, n)),
        readings=tuple(readings),
    )


def _evaluate_with_shared_tests(
    prepared: PreparedSurface, out: Grid, tests: np.ndarray, progress: Report
) -> None:
    """Fill a Grid whose combinations share their test dots, and in each draw their random numbers and random subsets."""
    n, draws = out.n_s.shape
    out.z_tot[:] = prepared.describe(tests)[0]
    _fill_sampled(prepared, out, tests, progress)
    _fill_uniform(prepared, out, tests, lambda draw: progress((draws + draw + 1) * n, 2 * draws * n))


def _fill_sampled(prepared: PreparedSurface, out: Grid, tests: np.ndarray, progress: Report) -> None:
    """Write the distances of sampled subsets into a Grid, draw by draw, some tests at a time."""
    together = tuple(reading for reading in out.readings if reading in GRID_READINGS)
    n, draws = out.n_s.shape
    dots = np.empty((len(out.readings), n, draws, len(tests)), np.int32)
    # Draw by draw: the bits of the subsets of all combinations are in memory for one draw at a time
    for draw in range(draws):
        drawn = prepared.sampled_together(out.combinations, draw)
        out.n_s[:, draw] = drawn.sizes()
        bit_words = drawn.words(prepared.index.dot, range(n)) if together else np.empty((0, 0), np.uint64)
        for a in range(0, len(tests) if together else 0, TESTS_AT_ONCE):
            part = slice(a, a + TESTS_AT_ONCE)
            found = prepared.compare_words(bit_words, n, tests[part], together, out.z_tot[part])
            for r, z, sizes in zip(map(out.readings.index, together), *found, strict=True):
                out.z_ts[r, :, draw, part], dots[r, :, draw, part] = z, sizes
            progress(draw * n + n * min(a + TESTS_AT_ONCE, len(tests)) // len(tests), 2 * draws * n)
        for r, reading in enumerate(out.readings):
            if reading not in together:
                subsets = [drawn.subset(k) for k in range(n)]
                found = prepared.distances(subsets, tests, out.z_tot, reading, approximate=True)
                out.z_ts[r, :, draw], dots[r, :, draw] = found
    out.median_patch_size[:, 0] = np.median(dots.reshape(*dots.shape[:2], -1), axis=2)


def _evaluate_with_own_tests(
    prepared: PreparedSurface, out: Grid, tests: np.ndarray, progress: Report
) -> None:
    """Fill a Grid whose combinations each have their own test dots and random subsets, as published, a thread each."""
    n, draws = out.n_s.shape
    single, finished = prepared.with_threads(1), []

    def fill_one(k: int, _: int) -> None:
        _fill(single, out, k, tests[k])
        finished.append(k)
        progress(2 * draws * len(finished), 2 * draws * n)

    parallel_map(fill_one, n, prepared.threads, 1)


def _fill(prepared: PreparedSurface, out: Grid, k: int, tests: np.ndarray) -> None:
    """Write the distances of the sampled and random subsets of combination k, each drawn by itself, into a Grid."""
    draws = out.n_s.shape[1]
    sizes = np.zeros((len(out.readings), 2, draws, len(tests)), np.int32)
    z_tot = None
    for a in range(0, draws, descriptors.MAX_SUBSETS // 2):  # each draw has a sampled and a random subset
        part = range(a, min(a + descriptors.MAX_SUBSETS // 2, draws))
        subsets = _draw_alone(prepared, out, k, part)
        z_tot, *measured = prepared.compare(subsets, tests, out.readings, z_tot, approximate=True)
        z, size = (values.reshape(len(out.readings), 2, len(part), len(tests)) for values in measured)
        out.z_ts[:, k, part], out.z_tr[:, k, part] = z[:, 0], z[:, 1]
        sizes[:, :, part] = size
    out.median_patch_size[:, :, k] = np.median(sizes.reshape(*sizes.shape[:2], -1), axis=2)


def _fill_uniform(
    prepared: PreparedSurface, out: Grid, tests: np.ndarray, finished: Callable[[int], None]
) -> None:
    """Write the distances of random subsets, which are nested in a draw, into a Grid, draw by draw.

    Subsets that form their own surfaces are measured at the n_S of `_curve_sizes` if there are many combinations, and
    interpolated over ln n_S; each draw has its own curve, so that the scatter of the draws includes the error of the curves.
    """
    together = tuple(reading for reading in out.readings if reading in GRID_READINGS)
    alone = [reading for reading in out.readings if reading not in together]
    shape = (len(out.readings), *out.n_s.shape, len(tests))
    # patch sizes; interpolated ones are no integers
    dots = np.empty(shape, np.float32 if alone else np.int32)
    for draw in range(out.n_s.shape[1]):
        n_s, inverse = np.unique(out.n_s[:, draw], return_inverse=True)
        if together:
            measured = prepared.compare_uniform(draw, n_s, tests, together, out.z_tot)
            for i, reading in enumerate(together):
                r = out.readings.index(reading)
                out.z_tr[r, :, draw], dots[r, :, draw] = (values[i][inverse] for values in measured)
        if alone:
            sizes = _curve_sizes(out) if len(out.n_s) > N_CURVE_SIZES else n_s
            order = prepared.uniform_order(draw)
            subsets = [np.sort(order[:n]) for n in sizes]
            for reading in alone:
                r = out.readings.index(reading)
                curves = prepared.distances(subsets, tests, out.z_tot, reading, approximate=True)
                for values, curve in zip((out.z_tr, dots), curves, strict=True):
                    values[r, :, draw] = _interpolated(out.n_s[:, draw], sizes, curve)
        finished(draw)
    out.median_patch_size[:, 1] = np.median(dots.reshape(*shape[:2], -1), axis=2)


def _curve_sizes(out: Grid) -> np.ndarray:
    """Return the n_S of a curve, evenly spaced in ln n_S."""
    low, high = np.log(out.n_s.min()), np.log(out.n_s.max())
    return np.unique(np.round(np.exp(np.linspace(low, high, N_CURVE_SIZES))).astype(int))


def _interpolated(n_s: np.ndarray, sizes: np.ndarray, curve: np.ndarray) -> np.ndarray:
    """Interpolate a curve (sizes, T) over ln n_S."""
    position = np.interp(np.log(n_s), np.log(sizes), np.arange(len(sizes)))
    low, high = curve[position.astype(int)], curve[np.ceil(position).astype(int)]
    return low + (position % 1)[:, None] * (high - low)


def _draw_alone(prepared: PreparedSurface, out: Grid, k: int, draws: Sequence[int]) -> list[np.ndarray]:
    """Return sampled subsets of combination k, then random ones of their sizes; write n_S."""
    sampled = [prepared.sampled(out.combinations[k], draw) for draw in draws]
    out.n_s[k, draws] = [len(subset) for subset in sampled]
    keys = Combination(*out.combinations[k]).keys()
    streams = [prepared.stream("uniform", *keys, draw) for draw in draws]
    uniform = [
        published.uniform_subset(out.n_dots, len(subset), rng)
        for subset, rng in zip(sampled, streams, strict=True)
    ]
    return sampled + uniform


def add_scaled_link(
    ranges: pd.DataFrame, prepared: PreparedSurface, n_tests: int, draws: int
) -> pd.DataFrame:
    """Add d of every winner of ranges.csv under `kept_scaled`, at the test dots, draws and random subsets of the grid."""
    won = ranges["n_combinations"] > 0
    combinations, inverse = np.unique(
        ranges.loc[won, PARAMETERS].to_numpy(float), axis=0, return_inverse=True
    )
    result = evaluate_grid(prepared, combinations, n_tests, draws, (SCALED_READING,))
    d = estimate(result.z_tr[0].astype(np.float64) - result.z_ts[0])
    out = ranges.copy()
    for key, values in (("d", d.mean), ("d_low", d.low), ("d_high", d.high)):
        out.loc[won, f"{key}_{SCALED_READING}"] = values[inverse]
    return out


def write_grid(path: Path | str, grid: Grid) -> None:
    """Write a Grid as npz; equal grids give equal bytes."""
    with open(path, "wb") as stream:
        np.savez(stream, **{f.name: np.asarray(getattr(grid, f.name)) for f in fields(Grid)})  # type: ignore[arg-type]


def read_grid(path: Path | str) -> Grid:
    """Read a Grid that `write_grid` wrote."""
    try:
        with np.load(path, allow_pickle=False) as data:
            values = {f.name: data[f.name] for f in fields(Grid)}
    except (KeyError, ValueError, OSError, EOFError, BadZipFile) as error:
        raise InputError(f"{path} is damaged ({error}): delete it, it will be computed again.") from None
    return Grid(**values | {"n_dots": int(values["n_dots"]), "readings": tuple(map(str, values["readings"]))})
