"""The surfaces of a run side by side, and the best parameters against their mean roughness.

Is mean roughness a guide to the best parameters? Two answers, per reading and range of n_S: the rank correlation of
the winners' parameters with it, and the d that a surface gets from the combination chosen on the surfaces nearest
to it in mean roughness, compared with the farthest. Only if the near ones choose better is there anything to gain.
"""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.sampling.combination import PARAMETERS, Combination
from sparsurf.study.relation import relate_to_roughness
from sparsurf.study.required_dots import percent_columns
from sparsurf.study.tables import (
    number_of_combinations,
    range_index,
    range_limits,
    read_roughness,
    read_table,
)
from sparsurf.surfaces.components import FIELD, numbers_of, table_of_components
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.spacing import spacing

OF_BEST = ("n_S_percent", "d_held_out", "d_held_out_low", "d_held_out_high", "d", "Z_tS", "n_best_set")
N_NEAREST = 3  # surfaces that stand for 'near', and for 'far'
GUESSES = ["d_from_near", "d_from_far", "d_from_all"]


@dataclass(frozen=True)
class Result:
    """What the summary needs of one conformation: its own numbers and its tables."""

    protein: str
    conformation: str
    n_dots: int
    area: float
    spacing: float
    mean_roughness: float
    grid: pd.DataFrame | None = None
    ranges: pd.DataFrame | None = None
    best: dict | None = None
    enough: pd.DataFrame | None = None
    minimal: pd.DataFrame | None = None
    components: pd.DataFrame | None = None


def read_result(folder, sampled=True):
    """Read one conformation from its folder, <protein>/<conformation>; what follows from the grid where it was `sampled`."""
    folder = Path(folder)

    def table(name, needed=False):
        path = folder / f"{name}.csv"
        return read_table(path) if needed or path.is_file() else None

    try:
        surface = read_npz(folder / "surface.npz")
        found = Result(
            folder.parent.name,
            folder.name,
            len(surface),
            float(surface.area.sum()),
            spacing(surface.points),
            float(read_roughness(folder / "roughness.csv", surface).mean()),
            enough=table("enough"),
            minimal=table("minimal"),
            components=table_of_components(surface, surface.fields[FIELD].astype(int))
            if FIELD in surface.fields
            else None,
        )
        if not sampled:
            return found
        best = json.loads((folder / "best.json").read_text(encoding="utf-8"))
        ranges = table("ranges", True)
        grid = read_table(folder / "grid.csv", number_of_combinations(ranges), "combinations")
        return replace(found, grid=grid, ranges=ranges, best=best)
    except InputError:
        raise
    except (OSError, KeyError, ValueError) as error:
        raise InputError(
            f"{folder} lacks results of its conformation ({error}): run the study again."
        ) from None


def surfaces_table(results, patches):
    """One row per conformation: size, roughness, n_S of the grid, and per reading the best combination of all.

    Parameters
    ----------
    results : list of Result
    patches : dict
        The config's `patches`, which the mean roughness belongs to.

    Returns
    -------
    DataFrame; area in Å^2, NaN for a ready surface without areas; the numbers of `components.numbers_of`, not for ready
    surfaces; spacing, the median distance between neighbouring dots, in Å. minimal_n_S: dots of the minimal subset. Best:
    highest d at the largest alpha. enough_<floor>_<reading>: the n_S in % that reaches a noise floor. What was not measured has
    no column.
    """
    rows = []
    for one in results:
        row = {"protein": one.protein, "conformation": one.conformation, "N": one.n_dots, "area": one.area}
        row |= {} if one.components is None else numbers_of(one.components)
        row |= {"spacing": one.spacing, "mean_roughness": one.mean_roughness}
        if one.minimal is not None:
            n = len(one.minimal)
            row |= {"minimal_n_S": n, "minimal_n_S_percent": 100 * n / one.n_dots}
        row |= {} if one.grid is None else _of_grid(one)
        row |= {} if one.enough is None else percent_columns(one.enough)
        rows.append(row | {"R_patch": patches["R_patch"], "D_link": patches["D_link"]})
    return pd.DataFrame(rows)


def _of_grid(one):
    """n_S of the grid, the best combination by reading, and the reference values."""
    percent, sticks = one.grid["n_S_percent"], one.best["references"]
    row = {"n_S_min_percent": percent.min(), "n_S_max_percent": percent.max()}
    for reading in evaluated_readings(one):
        winner = one.best[reading]["unrestricted"]
        row[f"best_{reading}"] = str(Combination.from_row(winner))
        row |= {f"{key}_{reading}": winner[key] for key in OF_BEST}
    row |= {"empty_patch": sticks["empty_patch"], "null_model": sticks["null_model"]}
    return row | {words.replace(" ", "_"): z for words, z in sticks.get("floors", {}).items()}


def evaluated_readings(result):
    """The readings that a conformation was evaluated under."""
    return list(result.ranges["reading"].unique())


def summary_table(results):
    """One row per conformation, reading and range of n_S: ranges.csv of all, and what the others would choose.

    Returns
    -------
    DataFrame: protein, conformation, mean_roughness, reading, range (from 1), the columns of
    `tables.ranges_table`; `local`, the combination (of this range) with the highest mean d on this surface and those
    nearest in mean roughness, `NEAREST` in all; and `GUESSES`: d that this surface gets from the combination with
    the highest mean d on the `NEAREST` other surfaces nearest in mean roughness, on as many farthest, and on all
    others. Others are those of other proteins, where there are any. They do not know this surface, so there is no
    selection bias. NaN where there are too few.
    """
    chosen = {reading: chosen_nearby(results, reading) for reading in evaluated_readings(results[0])}
    tables = []
    for s, one in enumerate(results):
        for reading, rows in one.ranges.groupby("reading", sort=False):
            own = {
                "protein": one.protein,
                "conformation": one.conformation,
                "mean_roughness": one.mean_roughness,
            }
            rows = rows.assign(**own, range=np.arange(1, len(rows) + 1))
            guesses, rows["local"] = chosen[reading][0][s], chosen[reading][1][s]
            rows[GUESSES] = guesses
            tables.append(rows)
    table = pd.concat(tables, ignore_index=True)
    first = ["protein", "conformation", "mean_roughness", "reading", "range"]
    last = ["local", *GUESSES, "n_best_set", "best_set"]  # which may be long
    return table[first + [name for name in table if name not in first + last] + last]


def chosen_nearby(results, reading):
    """d of every surface and range under the choices of `GUESSES`, (S, ranges, 3), and `local`, (S, ranges)."""
    d, percent = stack_column(results, f"d_{reading}"), stack_column(results, "n_S_percent")
    n_ranges = int((results[0].ranges["reading"] == reading).sum())
    guesses = np.full((len(results), n_ranges, 3), np.nan)
    local = np.full((len(results), n_ranges), np.nan, object)
    for s, one in enumerate(results):
        others = nearest_first(results, s)
        near = min(N_NEAREST, len(others) // 2)
        groups = others[:near], others[len(others) - near :], others, np.append(others[: N_NEAREST - 1], s)
        scores = [d[group].mean(axis=0) if len(group) else None for group in groups]
        member = range_index(percent[s], range_limits(percent[s], n_ranges))
        for k in np.unique(member):
            inside = np.flatnonzero(member == k)
            best = [None if score is None else inside[np.argmax(score[inside])] for score in scores]
            guesses[s, k] = [np.nan if b is None else d[s, b] for b in best[:3]]
            local[s, k] = str(Combination.from_row(one.grid.loc[best[3]]))
    return guesses, local


def nearest_first(results, s):
    """Surfaces other than number s, of other proteins where there are any, by distance in mean roughness."""
    gap = np.array([abs(one.mean_roughness - results[s].mean_roughness) for one in results])
    order = [k for k in np.argsort(gap, kind="stable") if k != s]
    foreign = [k for k in order if results[k].protein != results[s].protein]
    return np.array(foreign or order, int)


def stack_column(results, column):
    """One column of all grids, (S, K) float64; the grids must be of the same combinations."""
    first = results[0].grid[PARAMETERS].to_numpy()
    for one in results:
        if column not in one.grid or not np.array_equal(one.grid[PARAMETERS].to_numpy(), first):
            raise InputError(
                f"{one.protein}/{one.conformation} was not evaluated as {results[0].protein}/"
                f"{results[0].conformation} was (other combinations or readings): run the study again."
            )
    return np.stack([one.grid[column].to_numpy(float) for one in results])


def relation_table(results, summary, rng):
    """Per reading and range: the best combination on average, and whether the winners follow mean roughness.

    Parameters
    ----------
    results : list of Result
    summary : DataFrame
        See `summary_table`.
    rng : numpy.random.Generator

    Returns
    -------
    DataFrame: reading, range, limits and n_S (means over the surfaces), the combination with the highest mean d
    over all surfaces, that d and its standard deviation over the surfaces, the mean of `d_from_all`, and the
    columns of `relation.relation`.
    """
    percent = stack_column(results, "n_S_percent").mean(axis=0)
    rows = []
    for reading, part in summary.groupby("reading", sort=False):
        d = stack_column(results, f"d_{reading}")
        limits = range_limits(percent, int(part["range"].max()))
        member = range_index(percent, limits)
        for k, own in part.groupby("range"):
            row = {
                "reading": reading,
                "range": k,
                "n_S_low_percent": limits[k - 1],
                "n_S_high_percent": limits[k],
            }
            inside = np.flatnonzero(member == k - 1)
            if len(inside):
                best = inside[np.argmax(d[:, inside].mean(axis=0))]
                row |= results[0].grid.loc[best, PARAMETERS].to_dict()
                row |= {"n_S_percent": percent[best], "d": d[:, best].mean()}
                row["d_sd"] = d[:, best].std(ddof=1) if len(results) > 1 else np.nan
            row["d_from_all"] = own["d_from_all"].mean()
            rows.append(row | relate_to_roughness(own[own["n_combinations"] > 0], rng))
    return pd.DataFrame(rows)
