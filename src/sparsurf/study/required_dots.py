"""How many dots are required: the smallest n_S whose Z falls to a reference value."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from sparsurf.patches.readings import WRITTEN_READING
from sparsurf.recovery.readings import RECOVERED, recovered_index
from sparsurf.recovery.relaxation import relax
from sparsurf.sampling.combination import PUBLISHED_CHOICES, Choices
from sparsurf.sampling.samplers import get_samplers
from sparsurf.study.prepared_surface import PreparedSurface

UNIFORM = "uniform"
COLUMNS = {UNIFORM: "Z_tR", "paper": "Z_tS"}  # of the grid: the uniform subsets, and the sampling itself
MEDIAN_WINDOWS = 50  # a running median covers one of so many parts of the rows
FLOOR_FACTOR = (
    1.1  # a Z within a tenth of a floor counts as the floor: Z of recovered surfaces levels off there
)
MEAN_DESCRIPTOR = "Z_mean_descriptor"
COLUMN_PREFIX = "required_percent_"  # of the columns of surfaces.csv
# n_S of the measured curves, % of the dots
CURVE_PERCENTS = (1, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 10, 12, 15, 20, 25, 30, 40, 50, 60, 70, 80, 90)
MIN_DOTS = 12  # no surface can be recovered from fewer
AT_MOST, MORE = "at most", "more"  # the smallest measured n_S is enough already, or the largest is not


def smallest_n_s(z: float, n: np.ndarray, values: np.ndarray) -> float:
    """Find the smallest n_S that reaches Z = z on a measured curve.

    The curve is taken as never rising, and as a straight line of ln Z over ln n_S between two points.

    Parameters
    ----------
    z : float
    n, values : (P,) n_S, ascending, and the Z measured there

    Returns
    -------
    float in the unit of `n`; 0 stands for fewer than the smallest measured n_S, inf for more than the largest
    """
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


def required_on_grid(
    grid: pd.DataFrame, z_mean_descriptor: float, floors: Mapping[str, float], reading: str = WRITTEN_READING
) -> pd.DataFrame:
    """Find the smallest n_S of the grid that beats the null model or comes within a tenth of each noise floor.

    The 95 % interval of Z must lie below the null model. Floors are measured at the same test dots and share their error;
    the null model does not.

    Parameters
    ----------
    grid : DataFrame
        See `tables.grid_table`.
    z_mean_descriptor : float, Z
    floors : dict of name to Z
    reading : str

    Returns
    -------
    DataFrame: reading; sampler (`uniform`, or `paper` with whichever combination achieves it), reference, Z, n_S_percent
    (NaN if no n_S of the grid is enough), and `smallest`, whether that is the smallest of the grid.
    """
    rows, grid = [], grid.sort_values("n_S_percent", kind="stable")
    percent = grid["n_S_percent"].to_numpy(float)
    for sampler, column in COLUMNS.items():
        highest = grid[f"{column}_high_{reading}"].fillna(grid[f"{column}_{reading}"]).to_numpy()
        mean = grid[f"{column}_{reading}"].to_numpy()
        if sampler == UNIFORM:  # rows that differ only in n_S and chance must not be ranked
            mean = _running_median(mean)
        for name, value in {MEAN_DESCRIPTOR: z_mean_descriptor, **floors}.items():
            limit, curve = (value, highest) if name == MEAN_DESCRIPTOR else (FLOOR_FACTOR * value, mean)
            required = smallest_n_s(limit, percent, curve)
            smallest = required <= percent[0]
            if smallest:
                required = percent[0]
            elif not np.isfinite(required):
                required = np.nan
            rows.append((reading, sampler, name, value, required, smallest))
    return pd.DataFrame(rows, columns=["reading", "sampler", "reference", "Z", "n_S_percent", "smallest"])


def _running_median(z: np.ndarray) -> np.ndarray:
    """Return the running median of Z over rows of ascending n_S."""
    window = 1 + 2 * (len(z) // MEDIAN_WINDOWS // 2)
    return pd.Series(z).rolling(window, center=True, min_periods=1).median().to_numpy()


class Trials:
    """Subsets of one sampler and their Z at the test dots of the study, which are also those of the floors.

    Parameters
    ----------
    prepared : PreparedSurface
    sampler : str
    n_tests : int
    choices : combination.Choices
    relaxed : bool
        Recover the surface from relaxed dots, see `relaxation.relax`.

    Attributes
    ----------
    down_to : float
        Curves of recovered surfaces end at the first Z that is not above this value.

    Raises
    ------
    InputError
        If the sampler is unknown.
    """

    def __init__(
        self,
        prepared: PreparedSurface,
        sampler: str,
        n_tests: int,
        choices: Choices = PUBLISHED_CHOICES,
        relaxed: bool = False,
    ) -> None:
        self.prepared, self.sampler, self.choices, self.relaxed = prepared, sampler, choices, relaxed
        self.tests, self.n_dots = prepared.draw_tests(n_tests), len(prepared.points)
        self._sampler = get_samplers([sampler], "minimal.sampler", choices)[sampler]
        self.down_to = -np.inf
        self._measured: dict[str, dict[int, tuple[int, float]]] = {}  # reading -> requested n_S -> n_S, Z

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
        if not (self.relaxed and reading == RECOVERED):
            return self.prepared.distances(subsets, self.tests, self._z_tot, reading)[0]
        return np.array([self._distances_of_relaxed(dots) for dots in subsets])

    def _distances_of_relaxed(self, dots: np.ndarray) -> np.ndarray:
        """Compute |z_tot - z| of the surface recovered from relaxed dots, (T,)."""
        full = self.prepared
        points, normals = relax(
            full.points[dots], full.normals[dots], full.points, full.normals, threads=full.threads
        )
        index = recovered_index(points, normals, full.d_link, full.area, full.density)
        return full.distances_to_index(index, self.tests, self._z_tot)[0]

    @cached_property
    def sizes(self) -> np.ndarray:
        """The n_S of `CURVE_PERCENTS`, ascending ints."""
        sizes = np.round(np.array(CURVE_PERCENTS) / 100 * self.n_dots).astype(int)
        return np.unique(np.clip(sizes, MIN_DOTS, None).clip(max=self.n_dots))

    def measured(self, sizes: Sequence[int] | np.ndarray, reading: str) -> tuple[np.ndarray, np.ndarray]:
        """Return the n_S that were kept for requested `sizes`, (P,) int, and the Z there, (P,) float64."""
        known = self._measured.setdefault(reading, {})
        new = [n for n in map(int, sizes) if n not in known]
        if new:
            subsets = [self.draw(n) for n in new]
            z = self.distances(subsets, reading).mean(axis=1)
            known |= {n: (len(dots), value) for n, dots, value in zip(new, subsets, z, strict=True)}
        n_s, values = zip(*(known[int(n)] for n in sizes), strict=True)
        return np.array(n_s), np.array(values)

    def tried(self, reading: str) -> np.ndarray:
        """Return the n_S of `sizes` at which a curve is measured, see `down_to`."""
        if reading != RECOVERED or self.down_to < 0:
            return self.sizes
        reached = (self.measured([n], reading)[1][0] <= self.down_to for n in self.sizes)
        return self.sizes[: next((k for k, is_reached in enumerate(reached, 1) if is_reached), None)]

    def curve(self, reading: str) -> tuple[np.ndarray, np.ndarray]:
        """Return n_S, ascending, and Z of all that is measured so far, at least `tried`."""
        self.measured(self.tried(reading), reading)
        n, z = self.measured(sorted(self._measured[reading]), reading)
        order = np.argsort(n, kind="stable")
        return n[order], z[order]


def curves_table(trials: Trials, readings: Sequence[str] = (WRITTEN_READING, RECOVERED)) -> pd.DataFrame:
    """Measure Z over the n_S of `CURVE_PERCENTS` of one sampler: sampler, reading, n_S, n_S_percent and Z."""
    tables = []
    for reading in readings:
        n, z = trials.measured(trials.tried(reading), reading)
        columns = {"sampler": trials.sampler, "reading": reading, "n_S": n}
        tables.append(pd.DataFrame(columns | {"n_S_percent": 100 * n / trials.n_dots, "Z": z}))
    return pd.concat(tables, ignore_index=True)


def required_dots_table(
    trials: Trials,
    floors: pd.DataFrame,
    readings: Sequence[str] = (WRITTEN_READING, RECOVERED),
    minimal: tuple[str, int] | None = None,
) -> pd.DataFrame:
    """Find the smallest n_S of a sampler whose Z is at most `FLOOR_FACTOR` times each floor.

    Parameters
    ----------
    trials : Trials
    floors : DataFrame
        See `floors.noise_floors`.
    readings : sequence of str
        `as_written`, `recovered` or both.
    minimal : (floor, n_S), optional
        A minimal subset that was searched for a floor: its n_S is what the recovered surface needs.

    Returns
    -------
    DataFrame: sampler, floor, Z_floor, reading (`as_written`: the kept dots as they are, patches cut on the full surface;
    `recovered`), n_S, n_S_percent and Z there, by `smallest_n_s`, rounded up; `bound`: 'at most' if the smallest measured
    n_S is enough, 'more' if the largest is not and n_S is therefore N.
    """
    rows = []
    for reading in readings:
        n, z = trials.curve(reading)
        for floor, z_floor in zip(floors["floor"], floors["Z"].astype(float), strict=True):
            required = smallest_n_s(FLOOR_FACTOR * z_floor, n, z)
            row: dict[str, Any] = {"sampler": trials.sampler, "floor": floor}
            row |= {"Z_floor": z_floor, "reading": reading}
            if required == 0:
                row |= {"n_S": int(n[0]), "Z": z[0], "bound": AT_MOST}
            elif required == np.inf:
                row |= {"n_S": trials.n_dots, "Z": 0.0, "bound": MORE}
            else:
                row |= {"n_S": int(np.ceil(required - 1e-6)), "Z": FLOOR_FACTOR * z_floor, "bound": ""}
            if reading == RECOVERED and minimal and minimal[0] == floor and minimal[1] in n:
                row |= {"n_S": minimal[1], "Z": z[list(n).index(minimal[1])], "bound": ""}
            rows.append(row)
    table = pd.DataFrame(rows)
    table.insert(5, "n_S_percent", 100 * table["n_S"] / trials.n_dots)
    return table


def percent_columns(required: pd.DataFrame) -> dict[str, float]:
    """Return the n_S_percent of `required_dots_table` as columns of one surface, by floor and reading."""
    columns = required["floor"].str.replace(" ", "_") + "_" + required["reading"]
    return dict(zip(COLUMN_PREFIX + columns, required["n_S_percent"], strict=True))
