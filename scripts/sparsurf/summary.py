"""The surfaces of a run side by side, and the best parameters against their mean roughness.

Is mean roughness a guide to the best parameters? Two answers, per reading and range of n_S: the rank correlation of
the winners' parameters with it, and the d that a surface gets from the combination chosen on the surfaces nearest
to it in mean roughness, compared with the farthest. Only if the near ones choose better is there anything to gain.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.patches import build_index, spacing
from sparsurf.relation import relation
from sparsurf.surface import read_surface
from sparsurf.tables import PARAMETERS, combination_text, markdown, range_limits

FILES = ("surface.npz", "roughness.csv", "grid.csv", "ranges.csv", "best.json")
NEAREST = 3  # surfaces that stand for 'near', and for 'far'
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
    grid: pd.DataFrame
    ranges: pd.DataFrame
    best: dict


def read_result(folder):
    """Read `FILES` of one conformation from its folder, <protein>/<conformation>."""
    folder = Path(folder)
    try:
        surface = read_surface(folder / "surface.npz")
        return Result(
            folder.parent.name,
            folder.name,
            len(surface),
            float(surface.area.sum()),
            spacing(build_index(surface.points, surface.normals)),
            float(pd.read_csv(folder / "roughness.csv")["roughness"].mean()),
            pd.read_csv(folder / "grid.csv"),
            pd.read_csv(folder / "ranges.csv"),
            json.loads((folder / "best.json").read_text(encoding="utf-8")),
        )
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
    DataFrame; area in Å^2, NaN for a ready surface without areas; spacing, the median distance between neighbouring
    dots, in Å. Best: highest d at the largest alpha.
    """
    rows = []
    for one in results:
        percent, sticks = one.grid["n_S_percent"], one.best["yardsticks"]
        row = {"protein": one.protein, "conformation": one.conformation, "N": one.n_dots, "area": one.area}
        row |= {"spacing": one.spacing, "mean_roughness": one.mean_roughness}
        row |= {"n_S_min_percent": percent.min(), "n_S_max_percent": percent.max()}
        for reading in readings(one):
            winner = one.best[reading]["unrestricted"]
            row[f"best_{reading}"] = combination_text(winner)
            for key in ("n_S_percent", "d", "d_low", "d_high", "d_held_out", "Z_tS", "n_plateau"):
                row[f"{key}_{reading}"] = winner[key]
        row |= {"empty_patch": sticks["empty_patch"], "null_model": sticks["null_model"]}
        rows.append(row | {"R_patch": patches["R_patch"], "D_link": patches["D_link"]})
    return pd.DataFrame(rows)


def readings(result):
    """The readings that a conformation was evaluated under."""
    return list(result.ranges["islands"].unique())


def summary_table(results):
    """One row per conformation, reading and range of n_S: ranges.csv of all, and what the others would choose.

    Returns
    -------
    DataFrame: protein, conformation, mean_roughness, islands, range (from 1), the columns of
    `tables.ranges_table`; `local`, the combination (of this range) with the highest mean d on this surface and those
    nearest in mean roughness, `NEAREST` in all; and `GUESSES`: d that this surface gets from the combination with
    the highest mean d on the `NEAREST` other surfaces nearest in mean roughness, on as many farthest, and on all
    others. Others are those of other proteins, where there are any. They do not know this surface, so there is no
    selection bias. NaN where there are too few.
    """
    chosen = {reading: chosen_nearby(results, reading) for reading in readings(results[0])}
    tables = []
    for s, one in enumerate(results):
        for reading, rows in one.ranges.groupby("islands", sort=False):
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
    first = ["protein", "conformation", "mean_roughness", "islands", "range"]
    last = ["local", *GUESSES, "n_plateau", "plateau"]  # the plateau may be long
    return table[first + [name for name in table if name not in first + last] + last]


def chosen_nearby(results, reading):
    """d of every surface and range under the choices of `GUESSES`, (S, ranges, 3), and `local`, (S, ranges)."""
    d, percent = stacked(results, f"d_{reading}"), stacked(results, "n_S_percent")
    n_ranges = int((results[0].ranges["islands"] == reading).sum())
    guesses = np.full((len(results), n_ranges, 3), np.nan)
    local = np.full((len(results), n_ranges), np.nan, object)
    for s, one in enumerate(results):
        others = nearest_first(results, s)
        near = min(NEAREST, len(others) // 2)
        groups = others[:near], others[len(others) - near :], others, np.append(others[: NEAREST - 1], s)
        scores = [d[group].mean(axis=0) if len(group) else None for group in groups]
        member = range_of(percent[s], range_limits(percent[s], n_ranges))
        for k in np.unique(member):
            inside = np.flatnonzero(member == k)
            best = [None if score is None else inside[np.argmax(score[inside])] for score in scores]
            guesses[s, k] = [np.nan if b is None else d[s, b] for b in best[:3]]
            local[s, k] = combination_text(one.grid.loc[best[3]])
    return guesses, local


def nearest_first(results, s):
    """Surfaces other than number s, of other proteins where there are any, by distance in mean roughness."""
    gap = np.array([abs(one.mean_roughness - results[s].mean_roughness) for one in results])
    order = [k for k in np.argsort(gap, kind="stable") if k != s]
    foreign = [k for k in order if results[k].protein != results[s].protein]
    return np.array(foreign or order, int)


def stacked(results, column):
    """One column of all grids, (S, K) float64; the grids must be of the same combinations."""
    first = results[0].grid[PARAMETERS].to_numpy()
    for one in results:
        if column not in one.grid or not np.array_equal(one.grid[PARAMETERS].to_numpy(), first):
            raise InputError(
                f"{one.protein}/{one.conformation} was not evaluated as {results[0].protein}/"
                f"{results[0].conformation} was (other combinations or readings): run the study again."
            )
    return np.stack([one.grid[column].to_numpy(float) for one in results])


def range_of(percent, limits):
    """Number of the range, from 0, that each n_S falls into; the largest n_S belongs to the last."""
    return np.clip(np.searchsorted(limits, percent, side="right") - 1, 0, len(limits) - 2)


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
    DataFrame: islands, range, limits and n_S (means over the surfaces), the combination with the highest mean d
    over all surfaces, that d and its standard deviation over the surfaces, the mean of `d_from_all`, and the
    columns of `relation.relation`.
    """
    percent = stacked(results, "n_S_percent").mean(axis=0)
    rows = []
    for reading, part in summary.groupby("islands", sort=False):
        d = stacked(results, f"d_{reading}")
        limits = range_limits(percent, int(part["range"].max()))
        member = range_of(percent, limits)
        for k, own in part.groupby("range"):
            row = {
                "islands": reading,
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
            rows.append(row | relation(own[own["n_combinations"] > 0], rng))
    return pd.DataFrame(rows)


def summary_markdown(surfaces, relations):
    """Twin for people: the surfaces, then the relation with mean roughness, range by range."""
    short = surfaces[["protein", "conformation", "N", "area", "mean_roughness"]].copy()
    short["area"] = short["area"].round(0)
    found = [name for name in ("kept", "surface") if f"d_{name}" in surfaces]
    for name in found:
        short[f"best, {name}"] = surfaces[f"best_{name}"]
        short[f"d held out, {name}"] = surfaces[f"d_held_out_{name}"]
    parts = ["# The surfaces of this run\n", markdown(short, 3), "# Best parameters against mean roughness\n"]
    for name in found:
        rows = relations[relations["islands"] == name]
        table = pd.DataFrame(
            {
                "n_S / %": [
                    f"{a:.1f} - {b:.1f}" for a, b in rows[["n_S_low_percent", "n_S_high_percent"]].to_numpy()
                ],
                "best on average": [
                    combination_text(row) if row["d"] == row["d"] else "" for _, row in rows.iterrows()
                ],
                "its d": rows["d"],
                "sd": rows["d_sd"],
                "different winners": [f"{a} of {b}" for a, b in rows[["n_winners", "n_surfaces"]].to_numpy()],
                "one plateau holds": rows["n_shared"],
                **{f"rho {p}": rows[f"rho_{p}"] for p in PARAMETERS},
                "p": rows["p"],
                "near - far": rows["gain"],
                "95 %": [
                    f"{a:.2f} .. {b:.2f}" if a == a else ""
                    for a, b in rows[["gain_low", "gain_high"]].to_numpy()
                ],
            }
        )
        parts += [f"## islands: {name}\n", markdown(table)]
    parts.append(
        "one plateau holds: the largest number of surfaces on which one and the same combination cannot be told from "
        "the winner. rho: Spearman's rank correlation of the winner's parameter with mean roughness; p: probability of "
        "so large a rho of any parameter by chance (of twenty rows one is expected to fall below 0.05). near - far: d "
        "of a surface with the combination chosen on the surfaces nearest in mean roughness, minus that chosen on the "
        "farthest.\n"
    )
    return "\n".join(parts)
