"""Compare the surfaces of a run, and relate their best parameters to their mean roughness.

Does mean roughness predict the best parameters? Two answers, per reading and range of n_S: its rank correlation with the
winners' parameters, and the d that a surface gets from the combination chosen on the surfaces nearest to it in mean
roughness, compared with the farthest. Roughness helps only if the near ones choose better.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from sparsurf.errors import InputError
from sparsurf.evaluation.floors import FRESH
from sparsurf.sampling.combination import PARAMETERS, Combination
from sparsurf.surfaces.components import summarize_components
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.spacing import spacing
from sparsurf_study.analysis.relation import relate_to_roughness
from sparsurf_study.analysis.tables import range_index, range_limits, read_roughness, read_table

N_NEAREST = 3  # number of surfaces that are 'near', and that are 'far'
GUESSES = ["d_from_near", "d_from_far", "d_from_all"]


@dataclass(frozen=True)
class SurfaceResult:
    """Numbers and tables of one conformation that the summary needs."""

    protein: str
    conformation: str
    n_dots: int
    area: float
    spacing: float
    mean_roughness: float
    grid: pd.DataFrame = field(default_factory=pd.DataFrame)  # empty unless sampled, as the next two
    ranges: pd.DataFrame = field(default_factory=pd.DataFrame)
    best: dict[str, Any] = field(default_factory=dict)
    minimal: pd.DataFrame | None = None
    recovered: pd.DataFrame | None = None
    components: pd.DataFrame | None = None


def read_result(folder: Path | str, sampled: bool = True, minimal: bool = True) -> SurfaceResult:
    """Read one conformation from its folder, <protein>/<conformation>, with the results of the grid if it was `sampled`.

    Its `minimal` subset may not be finished when its best combinations are summarised, so that these do without it.
    """
    folder = Path(folder)

    def optional_table(name: str) -> pd.DataFrame | None:
        path = folder / f"{name}.csv"
        return read_table(path) if path.is_file() else None

    try:
        surface = read_npz(folder / "surface.npz")
        residues = optional_table("residues") if minimal else None
        result = SurfaceResult(
            folder.parent.name,
            folder.name,
            len(surface),
            float((surface if residues is None else residues).area.sum()),  # exact by residues
            spacing(surface.points),
            float(read_roughness(folder / "roughness.csv", surface).mean()),
            minimal=optional_table("minimal") if minimal else None,
            recovered=optional_table("recovered") if minimal else None,
            components=optional_table("components") if minimal else None,
        )
        if not sampled:
            return result
        best = json.loads((folder / "best.json").read_text(encoding="utf-8"))
        ranges = read_table(folder / "ranges.csv")
        grid = read_table(folder / "grid.csv", best["combinations"], "combinations")
        return replace(result, grid=grid, ranges=ranges, best=best)
    except InputError:  # a ValueError, but its sentence says more than the next one
        raise
    except (OSError, KeyError, ValueError) as error:
        raise InputError(
            f"{folder} lacks results of its conformation ({error}): run the study again."
        ) from None


def surfaces_table(results: Sequence[SurfaceResult]) -> pd.DataFrame:
    """Tabulate the conformations: the rows of surfaces.csv, without columns of values that were not measured."""
    rows = []
    for result in results:
        row: dict[str, Any] = {"protein": result.protein, "conformation": result.conformation}
        row |= {"N": result.n_dots, "area": result.area}
        if result.components is not None:
            of_components = summarize_components(result.components)
            row |= {key: of_components[key] for key in ("volume", "components", "cavities")}
        row |= {"spacing": result.spacing, "mean_roughness": result.mean_roughness}
        if result.minimal is not None:
            n = len(result.minimal)
            row |= {"minimal_n_S": n, "minimal_n_S_percent": 100 * n / result.n_dots}
        row |= {} if result.recovered is None else _recovered_columns(result.recovered.iloc[0])
        row |= {} if result.grid.empty else _grid_columns(result)
        rows.append(row)
    # A column keeps its place where other rows lack it
    longest_first = sorted(rows, key=len, reverse=True)
    return pd.DataFrame(rows, columns=[*dict.fromkeys(name for row in longest_first for name in row)])


def _recovered_columns(everywhere: pd.Series) -> dict[str, float]:
    """Return the density of the minimal subset, the interval of its share, and the errors of its reconstructed surface."""
    of_subset = ("n_S_percent_low", "n_S_percent_high", "density")
    of_surface = (
        "mean",
        "high_99",
        "back_99",
        "largest",
        *(key for key in everywhere.index if str(key).startswith("Z_")),
    )
    names = {f"minimal_{key}": key for key in of_subset} | {f"recovered_{key}": key for key in of_surface}
    return {name: everywhere[key] for name, key in names.items()}


def _grid_columns(result: SurfaceResult) -> dict[str, Any]:
    """Return the best combination by reading, and the noise floor."""
    row = {
        f"best_{reading}": str(Combination.from_row(result.best[reading]["unrestricted"]))
        for reading in evaluated_readings(result)
    }
    floors = result.best["references"].get("floors", {})
    return row | ({"Z_resampled": floors[FRESH]} if floors else {})


def evaluated_readings(result: SurfaceResult) -> list[str]:
    """Return the readings under which a conformation was evaluated."""
    return list(result.ranges["reading"].unique())


def summary_table(results: Sequence[SurfaceResult]) -> pd.DataFrame:
    """Combine ranges.csv of all conformations, with the choices of other surfaces: the rows of summary.csv.

    `local` is the combination (of this range) with the highest mean d on this surface and those nearest in mean roughness,
    `N_NEAREST` in all. `GUESSES` are d that this surface gets from the best of the `N_NEAREST` nearest other surfaces (of other
    proteins, if any), of as many farthest, and of all: without a selection bias. NaN if there are too few.
    """
    chosen = {reading: chosen_nearby(results, reading) for reading in evaluated_readings(results[0])}
    tables = []
    for s, result in enumerate(results):
        for reading, ranges in result.ranges.groupby("reading", sort=False):
            rows = ranges.assign(
                protein=result.protein,
                conformation=result.conformation,
                mean_roughness=result.mean_roughness,
                range=np.arange(1, len(ranges) + 1),
            )
            guesses, local = chosen[str(reading)]
            rows["local"], rows[GUESSES] = local[s], guesses[s]
            tables.append(rows)
    table = pd.concat(tables, ignore_index=True)
    first = ["protein", "conformation", "mean_roughness", "reading", "range"]
    last = ["local", *GUESSES, "n_best_set", "best_set"]  # best_set may be long
    return table[first + [name for name in table if name not in first + last] + last]


def chosen_nearby(results: Sequence[SurfaceResult], reading: str) -> tuple[np.ndarray, np.ndarray]:
    """Return d of every surface and range under the choices of `GUESSES`, (S, ranges, 3), and `local`, (S, ranges)."""
    d, percent = stack_column(results, f"d_{reading}"), stack_column(results, "n_S_percent")
    n_ranges = int((results[0].ranges["reading"] == reading).sum())
    guesses = np.full((len(results), n_ranges, 3), np.nan)
    local = np.full((len(results), n_ranges), np.nan, object)
    for s, result in enumerate(results):
        neighbours = nearest_first(results, s)
        near = min(N_NEAREST, len(neighbours) // 2)
        groups = (
            neighbours[:near],
            neighbours[len(neighbours) - near :],
            neighbours,
            np.append(neighbours[: N_NEAREST - 1], s),
        )
        scores = [d[group].mean(axis=0) if len(group) else None for group in groups]
        member = range_index(percent[s], range_limits(percent[s], n_ranges))
        for k in np.unique(member[member < n_ranges]):
            inside = np.flatnonzero(member == k)
            best = [None if score is None else inside[np.argmax(score[inside])] for score in scores]
            guesses[s, k] = [np.nan if b is None else d[s, b] for b in best[:3]]
            local[s, k] = str(Combination.from_row(result.grid.loc[best[3]]))
    return guesses, local


def nearest_first(results: Sequence[SurfaceResult], s: int) -> np.ndarray:
    """Return the surfaces other than number s, of other proteins if there are any, by distance in mean roughness."""
    distance = np.array([abs(result.mean_roughness - results[s].mean_roughness) for result in results])
    order = [k for k in np.argsort(distance, kind="stable") if k != s]
    foreign = [k for k in order if results[k].protein != results[s].protein]
    return np.array(foreign or order, int)


def stack_column(results: Sequence[SurfaceResult], column: str) -> np.ndarray:
    """Stack one column of all grids, (S, K); refuses grids that differ in combinations or readings."""
    first = results[0].grid[PARAMETERS].to_numpy()
    for result in results:
        if column not in result.grid or not np.array_equal(result.grid[PARAMETERS].to_numpy(), first):
            raise InputError(
                f"{result.protein}/{result.conformation} was not evaluated as {results[0].protein}/"
                f"{results[0].conformation} was (other combinations or readings): run the study again."
            )
    return np.stack([result.grid[column].to_numpy(float) for result in results])


def relation_table(
    results: Sequence[SurfaceResult], summary: pd.DataFrame, rng: np.random.Generator
) -> pd.DataFrame:
    """Find, per reading and range, the best combination on average, and whether the winners follow mean roughness."""
    percent = stack_column(results, "n_S_percent").mean(axis=0)
    rows = []
    for reading, part in summary.groupby("reading", sort=False):
        d = stack_column(results, f"d_{reading}")
        limits = range_limits(percent, int(part["range"].max()))
        member = range_index(percent, limits)
        for k in sorted(part["range"].unique().tolist()):
            rows_of_range = part[part["range"] == k]
            row = {"reading": reading, "range": k}
            row |= {"n_S_low_percent": limits[k - 1], "n_S_high_percent": limits[k]}
            inside = np.flatnonzero(member == k - 1)
            if len(inside):
                best = inside[np.argmax(d[:, inside].mean(axis=0))]
                row |= results[0].grid.loc[best, PARAMETERS].to_dict()
                row |= {"n_S_percent": percent[best], "d": d[:, best].mean()}
                row["d_sd"] = d[:, best].std(ddof=1) if len(results) > 1 else np.nan
            row["d_from_all"] = rows_of_range["d_from_all"].mean()
            rows.append(row | relate_to_roughness(rows_of_range[rows_of_range["n_combinations"] > 0], rng))
    return pd.DataFrame(rows)
