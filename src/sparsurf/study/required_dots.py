"""How many dots are enough: the smallest n_S whose Z comes down to a reference value."""

from functools import cached_property

import numpy as np
import pandas as pd

from sparsurf.patches.readings import TEXT
from sparsurf.recovery.readings import RECOVERED, recovered_index
from sparsurf.recovery.relaxation import relax
from sparsurf.sampling.combination import PUBLISHED_CHOICES
from sparsurf.sampling.samplers import get_samplers

COLUMNS = {"uniform": "Z_tR", "paper": "Z_tS"}  # of the grid: the uniform subsets, and the sampling itself
SHARE = 50  # of the rows, one part of this many makes a running median
FLOOR_FACTOR = (
    1.1  # a Z within a tenth of a floor counts as the floor: surfaces that are recovered level off there
)
NULL_MODEL = "null_model"
COLUMN_PREFIX = "enough_"  # of the columns of surfaces.csv
CURVE_PERCENTS = (
    1,
    1.5,
    2,
    2.5,
    3,
    4,
    5,
    6,
    7,
    8,
    10,
    12,
    15,
    20,
    25,
    30,
    40,
    50,
    60,
    70,
    80,
    90,
)  # of the dots
MIN_DOTS = 12  # dots; fewer hold no surface that could be recovered
UNIFORM = "uniform"
AT_MOST, MORE = "at most", "more"  # the smallest n_S measured is enough already, or the largest is not


def smallest_n_s(z, n, values):
    """Smallest n_S that reaches Z = z on a measured curve: the one place where this is decided.

    The curve is taken as never rising, and as a straight line of ln Z over ln n_S between two points.

    Parameters
    ----------
    z : float
    n, values : (P,) n_S, ascending, and the Z measured there

    Returns
    -------
    float in the unit of `n`; 0 stands for fewer than the smallest n_S that was measured, inf for more than the largest
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


def required_on_grid(grid, null_model, floors, reading=TEXT):
    """The smallest n_S of the grid whose Z lies below the null model by its 95 % interval, or within a tenth of each floor.

    Floors are measured at the same test dots, whose error they share; the null model is measured at none of them.

    Parameters
    ----------
    grid : DataFrame
        See `tables.grid_table`.
    null_model : float, Z
    floors : dict of name to Z
    reading : str

    Returns
    -------
    DataFrame: reading; sampler (`uniform`, or `paper` with whichever combination does it), reference, Z,
    n_S_percent, NaN where no n_S of the grid is enough, and `smallest`, whether that is the smallest of the grid.
    """
    rows, grid = [], grid.sort_values("n_S_percent", kind="stable")
    percent = grid["n_S_percent"].to_numpy(float)
    for sampler, column in COLUMNS.items():
        highest = grid[f"{column}_high_{reading}"].fillna(grid[f"{column}_{reading}"]).to_numpy()
        mean = grid[f"{column}_{reading}"].to_numpy()
        if sampler == UNIFORM:  # its rows differ by n_S and luck alone, which no row is to win by
            mean = _smooth(mean)
        for name, value in {NULL_MODEL: null_model, **floors}.items():
            limit, curve = (value, highest) if name == NULL_MODEL else (FLOOR_FACTOR * value, mean)
            found = smallest_n_s(limit, percent, curve)
            least = found <= percent[0]
            shown = percent[0] if least else found if np.isfinite(found) else np.nan
            rows.append((reading, sampler, name, value, shown, least))
    return pd.DataFrame(rows, columns=["reading", "sampler", "reference", "Z", "n_S_percent", "smallest"])


def _smooth(z):
    """Running median of Z, by rising n_S: of every fiftieth part of the rows."""
    window = 1 + 2 * (len(z) // SHARE // 2)
    return pd.Series(z).rolling(window, center=True, min_periods=1).median().to_numpy()


class Trials:
    """Subsets of one sampler and their Z, on the test dots of the study, which are those of the floors.

    Parameters
    ----------
    evaluator : Evaluator
    sampler : str
    n_tests : int
    choices : combination.Choices
    settled : bool
        The surface is recovered from the dots at better places, see `settling.settle`.

    Attributes
    ----------
    down_to : float, where curves of recovered surfaces end: at the first Z that is not above it

    Raises
    ------
    InputError : an unknown sampler
    """

    def __init__(self, evaluator, sampler, n_tests, choices=PUBLISHED_CHOICES, relaxed=False):
        self.evaluator, self.sampler, self.choices, self.relaxed = evaluator, sampler, choices, relaxed
        self.tests, self.n_dots = evaluator.draw_tests(n_tests), len(evaluator.points)
        self._draw = get_samplers([sampler], "minimal.sampler", choices)[sampler]
        self.down_to = -np.inf
        self._known = {}  # reading -> requested n_S -> n_S that was kept, Z

    @cached_property
    def _z_tot(self):
        return self.evaluator.describe(self.tests)[0]

    @cached_property
    def _longest(self):
        """All dots in the order of choice, of a sampler whose shorter subsets are the beginnings of its longer ones."""
        return self._drawn(self.n_dots) if self._draw.nested else None

    def _drawn(self, n):
        return self._draw(self.evaluator, n, self.evaluator.stream("minimal", self.sampler))

    def draw(self, n):
        """(n,) int64 dots, in the order of choice; of the paper's samplers about as many."""
        return self._drawn(n) if self._longest is None else self._longest[:n]

    def distances(self, subsets, reading):
        """|z_tot - z| at the test dots, (B, T)."""
        if not (self.relaxed and reading == RECOVERED):
            return self.evaluator.distances(subsets, self.tests, self._z_tot, reading)[0]
        return np.array([self._settled(dots) for dots in subsets])

    def _settled(self, dots):
        own = self.evaluator
        kept = relax(own.points[dots], own.normals[dots], own.points, own.normals, threads=own.threads)
        index = recovered_index(*kept, own.d_link, own.area, own.density)
        return own.distances_to_index(index, self.tests, self._z_tot)[0]

    @cached_property
    def sizes(self):
        """The n_S of `PERCENTS`, ascending ints."""
        wanted = np.round(np.array(CURVE_PERCENTS) / 100 * self.n_dots).astype(int)
        return np.unique(np.clip(wanted, MIN_DOTS, None).clip(max=self.n_dots))

    def measured(self, sizes, reading):
        """n_S that were kept where `sizes` are requested, (P,) int, and the Z there, (P,) float64."""
        known = self._known.setdefault(reading, {})
        new = [n for n in map(int, sizes) if n not in known]
        if new:
            subsets = [self.draw(n) for n in new]
            z = self.distances(subsets, reading).mean(axis=1)
            known |= {n: (len(dots), value) for n, dots, value in zip(new, subsets, z, strict=True)}
        kept, z = zip(*(known[int(n)] for n in sizes), strict=True)
        return np.array(kept), np.array(z)

    def tried(self, reading):
        """The n_S of `sizes` that a curve takes, see `down_to`."""
        if reading != RECOVERED or self.down_to < 0:
            return self.sizes
        reached = (self.measured([n], reading)[1][0] <= self.down_to for n in self.sizes)
        return self.sizes[: next((k for k, enough in enumerate(reached, 1) if enough), None)]

    def curve(self, reading):
        """All that is measured so far, `tried` at least: n_S, ascending, and Z."""
        self.measured(self.tried(reading), reading)
        n, z = self.measured(sorted(self._known[reading]), reading)
        order = np.argsort(n, kind="stable")
        return n[order], z[order]


def curves_table(trials, readings=(TEXT, RECOVERED)):
    """Z over the n_S of `PERCENTS` of one sampler: a DataFrame with sampler, reading, n_S, n_S_percent and Z."""
    tables = []
    for reading in readings:
        n, z = trials.measured(trials.tried(reading), reading)
        columns = {"sampler": trials.sampler, "reading": reading, "n_S": n}
        tables.append(pd.DataFrame(columns | {"n_S_percent": 100 * n / trials.n_dots, "Z": z}))
    return pd.concat(tables, ignore_index=True)


def required_dots(trials, floors, readings=(TEXT, RECOVERED), handed_out=None):
    """The smallest n_S of a sampler whose Z is at most `CLOSE` times each floor.

    Parameters
    ----------
    trials : Trials
    floors : DataFrame
        See `floors.floors`.
    readings : sequence of str, `as_written`, `recovered` or both
    handed_out : (floor, n_S) of a subset that was sought for a floor: what its recovered surface needs

    Returns
    -------
    DataFrame: sampler, floor, Z_floor, reading (`as_written`: the kept dots as they are, patches cut on the full surface;
    `recovered`), n_S, n_S_percent and Z there, by `smallest_n_s`, rounded up; `bound`: 'at most' where the smallest n_S
    measured is enough, 'more' where the largest is not, so that all dots are named.
    """
    rows = []
    for reading in readings:
        n, z = trials.curve(reading)
        for floor in floors.itertuples():
            found = smallest_n_s(FLOOR_FACTOR * floor.Z, n, z)
            row = {"sampler": trials.sampler, "floor": floor.floor, "Z_floor": floor.Z, "reading": reading}
            if found == 0:
                row |= {"n_S": int(n[0]), "Z": z[0], "bound": AT_MOST}
            elif found == np.inf:
                row |= {"n_S": trials.n_dots, "Z": 0.0, "bound": MORE}
            else:
                row |= {"n_S": int(np.ceil(found - 1e-6)), "Z": FLOOR_FACTOR * floor.Z, "bound": ""}
            if reading == RECOVERED and handed_out and handed_out[0] == floor.floor and handed_out[1] in n:
                row |= {"n_S": handed_out[1], "Z": z[list(n).index(handed_out[1])], "bound": ""}
            rows.append(row)
    table = pd.DataFrame(rows)
    table.insert(5, "n_S_percent", 100 * table["n_S"] / trials.n_dots)
    return table


def percent_columns(enough):
    """The n_S_percent of `enough_dots` as columns of one surface: a dict by floor and reading."""
    return {
        f"{COLUMN_PREFIX}{row.floor.replace(' ', '_')}_{row.reading}": row.n_S_percent
        for row in enough.itertuples()
    }
