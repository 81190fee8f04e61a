"""Tables of a study: the grid, the best combination per range of n_S, the best of all."""

import io

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.sampling.combination import PARAMETERS, combination_labels, join_combinations
from sparsurf.study.best_set import best_set
from sparsurf.study.statistics import cross_validated, estimate, reference_values
from sparsurf.texts import read_bytes


def read_table(path, rows=None, of="rows"):
    """A table of a run's results, a DataFrame.

    Parameters
    ----------
    path : CSV, also packed (.gz)
    rows : int, optional
        How many it must have.
    of : str
        What the rows are, for the message.

    Raises
    ------
    InputError : it is no table, cut short, or has another number of rows
    """
    try:
        text = read_bytes(path).decode("utf-8")
        table = pd.read_csv(io.StringIO(text))
    except InputError:
        raise
    except ValueError as error:
        reason = str(error).splitlines()[0]
        raise InputError(f"{path} cannot be read ({reason}): delete it and run the study again.") from None
    if not text.endswith("\n"):
        raise InputError(f"{path} is cut short: delete it and run the study again.")
    if rows is not None and len(table) != rows:
        raise InputError(f"{path} has {len(table)} rows for {rows} {of}: delete it and run the study again.")
    return table


def read_roughness(path, surface):
    """R_i of the dots of a surface, (N,), as roughness.csv has it; raises InputError where it has another number, or no R_i."""
    table = read_table(path, len(surface), "dots")
    values = pd.to_numeric(table.get("roughness", pd.Series(["none"])), errors="coerce").to_numpy(float)
    if not ((values >= 0) & (values <= 1)).all():
        raise InputError(f"{path} has an R_i that is not 0 to 1: delete it and run the study again.")
    return values


def read_minimal(path, surface):
    """The rows of minimal.csv; raises InputError where its weights are not all dots of the surface."""
    table = read_table(path)
    if "weight" not in table or table["weight"].sum() != len(surface):
        raise InputError(
            f"{path} does not stand for all {len(surface)} dots: delete it and run the study again."
        )
    return table


def number_of_combinations(ranges):
    """How many combinations a table of ranges was chosen from."""
    return int(ranges.groupby("reading")["n_combinations"].sum().max())


def grid_table(grid):
    """One row per combination.

    Parameters
    ----------
    grid : grid.Grid

    Returns
    -------
    DataFrame: alpha, beta, gamma, delta; n_S (mean of the draws), n_S_percent, n_S_expected (closed form);
    then for each reading Z_tS, Z_tR and d with standard errors and 95 % intervals, and the median number of dots in
    the evaluated patches of the sampling and of the uniform subset.
    """
    table = pd.DataFrame(grid.combinations, columns=PARAMETERS)
    table["n_S"] = grid.n_s.mean(axis=1)
    table["n_S_percent"] = 100 * table["n_S"] / grid.n_dots
    table["n_S_expected"] = grid.n_s_expected
    for r, reading in enumerate(grid.readings):
        values = {"Z_tS": grid.z_ts[r], "Z_tR": grid.z_tr[r], "d": d_values(grid, r)}
        for name, x in values.items():
            found = estimate(x)
            table[f"{name}_{reading}"], table[f"{name}_se_{reading}"] = found.mean, found.error
            table[f"{name}_low_{reading}"], table[f"{name}_high_{reading}"] = found.low, found.high
        table[f"fragment_{reading}"], table[f"fragment_uniform_{reading}"] = grid.fragment[r]
    return table


def d_values(grid, r):
    """d of every combination, draw and test dot, under reading number r: (K, D, T) float64."""
    return grid.z_tr[r].astype(np.float64) - grid.z_ts[r]


def ranges_table(table, grid, n_ranges=10, floors=None):
    """The combination with the highest d in each range of n_S, under each reading (paper, Table I).

    Parameters
    ----------
    table : DataFrame
        See `grid_table`.
    grid : grid.Grid
        The raw distances of the same combinations.
    n_ranges : int

    Returns
    -------
    DataFrame, one row per reading and range: limits, number of combinations, the winner with its n_S, `d_held_out` with
    its 95 % interval (`statistics.held_out`: what the selection is worth on test dots and draws that took no part in
    it), d and its interval (too high, as the winner was chosen by it), Z_tS, Z_tR, fragment, and `best_set`, the
    combinations among which the truly best one lies with 95 % confidence. The rows share their test dots.
    A range that no combination falls into has NaN. Every row ends with the references.
    """
    percent = table["n_S_percent"].to_numpy()
    limits = range_limits(percent, n_ranges)
    member = range_index(percent, limits)
    rows = []
    for r, reading in enumerate(grid.readings):
        d = d_values(grid, r)
        for k in range(n_ranges):
            inside = np.flatnonzero(member == k)
            row = {"reading": reading, "n_S_low_percent": limits[k], "n_S_high_percent": limits[k + 1]}
            rows.append(row | (_winner(table, d, reading, inside) if len(inside) else {"n_combinations": 0}))
    return add_reference_columns(pd.DataFrame(rows), all_references(grid, floors))


def all_references(grid, floors=None):
    """`statistics.references`, and the noise floors (floor -> Z) where they were measured."""
    return reference_values(grid.z_tot) | ({"floors": floors} if floors else {})


def floors_by_name(floors):
    """floor -> Z of a table of `floors.floors`."""
    return dict(zip(floors["floor"], floors["Z"].astype(float), strict=True))


def add_reference_columns(table, sticks):
    """A table of Z with its references in every row: empty_patch, null_model, and fresh_dots where measured."""
    table = table.assign(empty_patch=sticks["empty_patch"], null_model=sticks["null_model"])
    return table.assign(fresh_dots=sticks["floors"]["fresh dots"]) if "floors" in sticks else table


def _winner(table, d, reading, inside):
    """The row of the highest d among the combinations `inside`."""
    sub = table.iloc[inside]
    best = int(np.argmax(sub[f"d_{reading}"].to_numpy()))
    honest = cross_validated(d[inside])
    row = {
        "n_combinations": len(inside),
        **{p: sub.iloc[best][p] for p in PARAMETERS},
        "n_S": sub.iloc[best]["n_S"],
        "n_S_percent": sub.iloc[best]["n_S_percent"],
        "d_held_out": float(honest.mean),
        "d_held_out_low": float(honest.low),
        "d_held_out_high": float(honest.high),
    }
    row |= {
        key: sub.iloc[best][f"{key}_{reading}"]
        for key in ("d", "d_low", "d_high", "Z_tS", "Z_tR", "fragment")
    }
    among = sub[best_set(d[inside])]
    row["n_best_set"] = len(among)
    row["best_set"] = join_combinations(combination_labels(among))
    return row


def best_combinations(table, grid, max_n_s_percent, floors=None):
    """The best combinations of a surface and the references beside them.

    Returns
    -------
    dict: N, combinations (their number), draws (of each), max_n_S_percent, `references` (see `statistics.references`) and
    per reading `unrestricted` (highest d at the largest alpha; the paper fixes alpha = 1) and `under_max_n_S` (highest d with n_S
    at most `max_n_s_percent` % of the dots; `answer` says so where none is that small).
    """
    alpha = table["alpha"].max()
    few = table["n_S_percent"].to_numpy() <= max_n_s_percent
    out = {
        "N": grid.n_dots,
        "combinations": len(table),
        "draws": grid.n_s.shape[1],
        "max_n_S_percent": max_n_s_percent,
    }
    out["references"] = all_references(grid, floors)
    for r, reading in enumerate(grid.readings):
        d = d_values(grid, r)
        free = _winner(table, d, reading, np.flatnonzero(table["alpha"] == alpha))
        if few.any():
            bounded = _winner(table, d, reading, np.flatnonzero(few))
        else:
            least = table["n_S_percent"].min()
            bounded = {
                "answer": f"No combination of the grid keeps {max_n_s_percent:g} % of the dots or fewer; "
                f"the smallest n_S is {least:.2f} %. Add smaller values of alpha or raise tables.max_n_S_percent."
            }
        out[reading] = {"unrestricted": free, "under_max_n_S": bounded}
    return out


def range_limits(values, n_ranges):
    """Limits of equal ranges between the smallest and the largest value: (n_ranges + 1,) float64."""
    return np.linspace(np.min(values), np.max(values), n_ranges + 1)


def range_index(values, limits, closed=True):
    """Number of the range, from 0, that each value falls into.

    A range holds its lower limit and not its upper one. The largest value belongs to the last range where that is
    `closed`; else to none, and gets the number of ranges.
    """
    place = np.searchsorted(limits, values, side="right") - 1
    return np.clip(place, 0, len(limits) - 2 if closed else len(limits) - 1)
