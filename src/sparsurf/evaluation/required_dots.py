"""How many dots are required: the smallest n_S whose Z falls to a reference value."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pandas as pd

from sparsurf import progress
from sparsurf.evaluation.crossing import Crossing, fitted_crossing, near
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.patches.readings import FULL_READING
from sparsurf.recovery.errors import DENSITY_FOR_ERRORS, distance_to_recovered, kept_out
from sparsurf.recovery.readings import RECOVERED
from sparsurf.sampling.combination import PUBLISHED_CHOICES, Choices
from sparsurf.sampling.samplers import get_samplers

UNIFORM = "uniform"
# A Z within a fifth of a floor is enough: nearer to it the curve is flat, and n_S uncertain
FLOOR_FACTOR = 1.2
COLUMN_PREFIX = "required_percent_"  # of the columns of surfaces.csv
# n_S of the measured curves, % of the dots
CURVE_PERCENTS = (1, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 10, 12, 15, 20, 25, 30, 40, 50, 60, 70, 80, 90)
TAIL_PERCENTS = (10, 25, 60)  # those of the curve of a recovered surface once its Z has fallen to all floors
MIN_DOTS = 12  # no surface can be recovered from fewer
SIZES_AROUND = 3  # measured n_S on each side of the crossing, to which the error is fitted
DRAWS = 3  # subsets of each n_S, with separate random streams, if surfaces are recovered
AT_MOST, MORE = "at most", "more"  # bounds: the smallest measured n_S is enough, or the largest is not


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


class Trials:
    """Subsets of one sampler and their Z at the test dots of the study, at which the floors are measured too."""

    def __init__(
        self, prepared: PreparedSurface, sampler: str, n_tests: int, choices: Choices = PUBLISHED_CHOICES
    ) -> None:
        self.prepared, self.sampler, self.choices = prepared, sampler, choices
        self.tests, self.n_dots = prepared.draw_tests(n_tests), len(prepared.points)
        self._sampler = get_samplers([sampler], "minimal.sampler", choices)[sampler]
        # Curves of recovered surfaces end at the first Z that does not exceed `down_to`, but for some larger n_S with a tail
        self.down_to, self.with_tail = -np.inf, False
        # reading -> requested n_S -> n_S that was kept, distances (K, T)
        self._measured: dict[str, dict[int, tuple[float, np.ndarray]]] = {}
        self._errors: dict[int, tuple[float, np.ndarray]] = {}  # requested n_S -> n_S, mean distances (K,)

    @cached_property
    def _z_tot(self) -> np.ndarray:
        """Descriptors of the full surface at the test dots."""
        return self.prepared.describe(self.tests)[0]

    @cached_property
    def _all_dots(self) -> np.ndarray:
        """All dots in the order of choice, for a nested sampler."""
        return self._draw(self.n_dots)

    def _draw(self, n: int) -> np.ndarray:
        """Call the sampler with its random stream."""
        return self._sampler(self.prepared, n, self.prepared.stream("minimal", self.sampler))

    def draw(self, n: int) -> np.ndarray:
        """Return (n,) int64 dots in the order of choice; the paper's samplers keep about n."""
        return self._all_dots[:n] if self._sampler.nested else self._draw(n)

    def distances(self, subsets: Sequence[np.ndarray], reading: str) -> np.ndarray:
        """Compute |z_tot - z| at the test dots, (B, T)."""
        return self.prepared.distances(subsets, self.tests, self._z_tot, reading)[0]

    @cached_property
    def sizes(self) -> np.ndarray:
        """The n_S of `CURVE_PERCENTS`, ascending ints."""
        return self._sizes_of(CURVE_PERCENTS)

    def _sizes_of(self, percents: Sequence[float]) -> np.ndarray:
        """Return the n_S of some % of the dots, ascending ints."""
        sizes = np.round(np.array(percents) / 100 * self.n_dots).astype(int)
        return np.unique(np.clip(sizes, MIN_DOTS, None).clip(max=self.n_dots))

    def draws(self, n: int, reading: str) -> list[np.ndarray]:
        """Return the subsets over which Z of `n` dots is averaged: several draws if the surface is recovered, else one."""
        if reading != RECOVERED:
            return [self.draw(n)]
        streams = (self.prepared.stream("required dots", self.sampler, n, k) for k in range(DRAWS))
        return [self._sampler(self.prepared, n, rng) for rng in streams]

    def distances_of(self, sizes: Sequence[int] | np.ndarray, reading: str) -> tuple[np.ndarray, np.ndarray]:
        """Return the n_S that were kept for the requested `sizes`, (P,) float64, and the distances there, (P, K, T)."""
        known = self._measured.setdefault(reading, {})
        new = [n for n in map(int, sizes) if n not in known]
        subsets = [self.draws(n, reading) for n in new]
        if new:
            distances = self.distances([dots for draws in subsets for dots in draws], reading)
            for n, draws, z in zip(new, subsets, np.split(distances, len(new)), strict=True):
                known[n] = float(np.mean([len(dots) for dots in draws])), z
        n_s, z_of_n = zip(*(known[int(n)] for n in sizes), strict=True)
        return np.array(n_s), np.array(z_of_n)

    def measured(self, sizes: Sequence[int] | np.ndarray, reading: str) -> tuple[np.ndarray, np.ndarray]:
        """Return the n_S that were kept for the requested `sizes`, and the mean Z there, (P,) float64 each."""
        n_s, distances = self.distances_of(sizes, reading)
        return n_s, distances.mean(axis=(1, 2))

    def first_size(self, reading: str, limit: float) -> int:
        """Return the index of the first of `sizes` whose Z is at most `limit`, or their number; sizes are measured in blocks."""
        threads = self.prepared.threads
        for a in progress.progress_bar(range(0, len(self.sizes), threads), "trying numbers of dots"):
            reached = self.measured(self.sizes[a : a + threads], reading)[1] <= limit
            if reached.any():
                return a + int(np.argmax(reached))
        return len(self.sizes)

    def tried(self, reading: str) -> np.ndarray:
        """Return the n_S of `sizes` at which a curve is measured, see `down_to`."""
        if reading != RECOVERED:
            return self.sizes
        reached = (self.measured([n], reading)[1][0] <= self.down_to for n in self.sizes)
        end = next((k for k, is_reached in enumerate(reached, 1) if is_reached), len(self.sizes))
        return np.union1d(self.sizes[:end], self._sizes_of(TAIL_PERCENTS if self.with_tail else ()))

    def curve(self, reading: str) -> tuple[np.ndarray, np.ndarray]:
        """Return n_S, ascending, and Z of all sizes measured so far, including those of `tried`."""
        self.measured(self.tried(reading), reading)
        n, z = self.measured(sorted(self._measured[reading]), reading)
        order = np.argsort(n, kind="stable")
        return n[order], z[order]

    def errors_of(self, sizes: Sequence[int] | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the n_S kept for `sizes`, (P,), and the mean distance (Å) of the surface at the other dots, (P, K)."""
        surface, threads = self.prepared.surface, self.prepared.threads
        for n in map(int, sizes):
            if n in self._errors:
                continue
            draws, errors = self.draws(n, RECOVERED), []
            for dots in draws:
                kept = surface.take(dots)
                distance = distance_to_recovered(
                    surface.points, kept.points, kept.normals, threads, DENSITY_FOR_ERRORS
                )
                errors.append(kept_out(distance, dots).mean() if len(dots) < self.n_dots else 0.0)
            self._errors[n] = float(np.mean([len(dots) for dots in draws])), np.array(errors)
        n_s, errors_of_n = zip(*(self._errors[int(n)] for n in sizes), strict=True)
        return np.array(n_s), np.array(errors_of_n)


class Required(NamedTuple):
    """The smallest n_S that is enough, the ends of its 95 % interval (NaN if unknown), and a bound."""

    n_s: int
    low: float
    high: float
    bound: str = ""


def required_to_recover(trials: Trials, floor: np.ndarray, factor: float = FLOOR_FACTOR) -> Required:
    """Find the smallest n_S from which the surface is recovered with a Z of at most `factor` times a noise floor, (D, T).

    `crossing.fitted_crossing` fits the sizes around the first whose Z is at most the limit. n_S is rounded up; `bound` is 'at
    most' if the smallest measured n_S is enough, 'more' if the largest is not: n_S is then N.
    """
    sizes, limit, n_dots = trials.sizes, factor * floor.mean(), trials.n_dots
    first = trials.first_size(RECOVERED, limit)
    around = near(sizes, sizes[min(first, len(sizes) - 1)], 1.2)  # wider, as the fit may move the crossing
    around[: first + 1] = True  # measured already
    n, distances = trials.distances_of(sizes[around], RECOVERED)
    order = np.argsort(n, kind="stable")
    rng = trials.prepared.stream("interval of required dots", trials.sampler)
    crossing = fitted_crossing(n[order], distances[order], floor, factor, n_dots, rng)
    return _rounded(crossing, n, n_dots)


def required_for_error(trials: Trials, error: float) -> Required:
    """Find the smallest n_S from which the surface is recovered `error` Å off on average; the interval is over the draws."""
    n, errors = trials.errors_of(sizes_around(trials, error))
    order = np.argsort(n, kind="stable")
    rng = trials.prepared.stream("interval of the error", trials.sampler)
    target = np.full((1, 1), error)
    crossing = fitted_crossing(n[order], errors[order][..., None], target, 1.0, trials.n_dots, rng)
    return _rounded(crossing, n, trials.n_dots)


def sizes_around(trials: Trials, error: float) -> np.ndarray:
    """Return the measured n_S around that at which the error falls to `error` Å, found by bisection over `Trials.sizes`."""
    sizes = trials.sizes
    low, high = -1, len(sizes)
    while high - low > 1:
        middle = (low + high) // 2
        reached = trials.errors_of(sizes[[middle]])[1].mean() <= error
        low, high = (low, middle) if reached else (middle, high)
    return sizes[max(high - SIZES_AROUND, 0) : high + SIZES_AROUND]


def _rounded(crossing: Crossing, n: np.ndarray, n_dots: int) -> Required:
    """Round the n_S of a crossing up, with its bound; `n` are the n_S that were measured."""
    if crossing.n == np.inf:
        return Required(n_dots, np.nan, np.nan, MORE)
    if crossing.n == 0:
        return Required(int(np.ceil(n.min())), np.nan, np.nan, AT_MOST)
    low, high = np.clip([crossing.low, crossing.high], MIN_DOTS, n_dots)
    return Required(min(int(np.ceil(crossing.n - 1e-6)), n_dots), float(low), float(high))


def curves_table(trials: Trials, readings: Sequence[str] = (FULL_READING, RECOVERED)) -> pd.DataFrame:
    """Tabulate Z at all measured n_S of one sampler: sampler, reading, n_S, n_S_percent and Z."""
    tables = []
    for reading in readings:
        n, z = trials.curve(reading)
        columns = {"sampler": trials.sampler, "reading": reading, "n_S": np.round(n).astype(int)}
        tables.append(pd.DataFrame(columns | {"n_S_percent": 100 * n / trials.n_dots, "Z": z}))
    return pd.concat(tables, ignore_index=True)


def required_dots_table(
    trials: Trials, floors: Mapping[str, np.ndarray], readings: Sequence[str] = (FULL_READING, RECOVERED)
) -> pd.DataFrame:
    """Find the smallest n_S whose Z is at most `FLOOR_FACTOR` times each floor: the rows of required_dots.csv."""
    rows = []
    for reading in readings:
        for floor, distances in floors.items():
            limit = FLOOR_FACTOR * distances.mean()
            recovered = reading == RECOVERED
            required = required_to_recover(trials, distances) if recovered else _required_full(trials, limit)
            z = {"": limit, AT_MOST: trials.measured(trials.sizes[:1], reading)[1][0], MORE: 0.0}
            row = {"sampler": trials.sampler, "floor": floor, "Z_floor": distances.mean(), "reading": reading}
            percents = 100 * np.array(required[:3]) / trials.n_dots
            row |= {"n_S": required.n_s, "n_S_percent": percents[0], "n_S_percent_low": percents[1]}
            rows.append(
                row | {"n_S_percent_high": percents[2], "Z": z[required.bound], "bound": required.bound}
            )
    return pd.DataFrame(rows)


def _required_full(trials: Trials, limit: float) -> Required:
    """Find the smallest n_S whose kept dots, as they are, have a Z of at most `limit`, by interpolation."""
    n, z = trials.curve(FULL_READING)
    required = smallest_n_s(limit, n, z)
    if required == 0:
        return Required(int(n[0]), np.nan, np.nan, AT_MOST)
    if required == np.inf:
        return Required(trials.n_dots, np.nan, np.nan, MORE)
    return Required(int(np.ceil(required - 1e-6)), np.nan, np.nan)


def percent_columns(required: pd.DataFrame) -> dict[str, float]:
    """Return n_S_percent of `required_dots_table` and its intervals as columns of one surface, by floor and reading."""
    columns = {}
    for row in required.to_dict("records"):
        name = f"{COLUMN_PREFIX}{row['floor'].replace(' ', '_')}_{row['reading']}"
        columns[name] = row["n_S_percent"]
        if row["reading"] == RECOVERED:
            columns |= {f"{name}_{end}": row.get(f"n_S_percent_{end}", np.nan) for end in ("low", "high")}
    return columns
