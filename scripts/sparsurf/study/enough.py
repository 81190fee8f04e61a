"""How many dots are enough: the smallest n_S whose Z comes down to a yardstick."""

import numpy as np
import pandas as pd

from sparsurf.patches.readings import TEXT

COLUMNS = {"uniform": "Z_tR", "paper": "Z_tS"}  # of the grid: the uniform subsets, and the sampling itself
SHARE = 50  # of the rows, one part of so many makes a running median
CLOSE = 1.1  # a Z within a tenth of a floor counts as the floor: surfaces that are recovered level off there
NULL_MODEL = "null_model"
PREFIX = "enough_"  # of the columns of surfaces.csv


def enough(grid, null_model, floors, reading=TEXT):
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
    DataFrame: islands, the reading; sampler (`uniform`, or `paper` with whichever combination does it), yardstick, Z,
    n_S_percent, NaN where no n_S of the grid is enough, and `smallest`, whether that is the smallest of the grid.
    """
    rows = []
    percent = grid["n_S_percent"].to_numpy(float)
    for sampler, column in COLUMNS.items():
        highest = grid[f"{column}_high_{reading}"].fillna(grid[f"{column}_{reading}"]).to_numpy()
        mean = grid[f"{column}_{reading}"].to_numpy()
        if sampler == "uniform":  # its rows differ by n_S and luck alone, which no row is to win by
            mean = _smooth(percent, mean)
        for name, value in {NULL_MODEL: null_model, **floors}.items():
            reached = highest < value if name == NULL_MODEL else mean <= CLOSE * value
            least = np.min(percent[reached], initial=np.inf)
            found = least if np.isfinite(least) else np.nan
            rows.append((reading, sampler, name, value, found, bool(least == percent.min())))
    return pd.DataFrame(rows, columns=["islands", "sampler", "yardstick", "Z", "n_S_percent", "smallest"])


def _smooth(percent, z):
    """Running median of Z over the n_S around each: of every fiftieth part of the rows."""
    order, window = np.argsort(percent, kind="stable"), 1 + 2 * (len(z) // SHARE // 2)
    out = np.empty(len(z))
    out[order] = pd.Series(z[order]).rolling(window, center=True, min_periods=1).median()
    return out


def percents(enough):
    """The n_S_percent of `minimal_by_floor.enough_dots` as columns of one surface: a dict by floor and reading."""
    return {
        f"{PREFIX}{row.floor.replace(' ', '_')}_{row.islands}": row.n_S_percent for row in enough.itertuples()
    }
