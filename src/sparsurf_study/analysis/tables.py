"""Tables of a study: the grid, and the best combinations per range of n_S and overall."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from sparsurf.errors import InputError
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import cross_validated, estimate, reference_values
from sparsurf.files import read_bytes
from sparsurf.sampling.combination import PARAMETERS, combination_labels, join_combinations
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.surface import Reconstruction, Surface
from sparsurf_study.analysis.best_set import best_set
from sparsurf_study.columns import missing_columns

if TYPE_CHECKING:
    from sparsurf.surfaces.surface import Surface
    from sparsurf_study.analysis.grid import Grid


def read_table(path: Path | str, rows: int | None = None, unit: str = "rows") -> pd.DataFrame:
    """Read a table of a run, and check its columns against catalogue.yaml and its number of `rows`, which are of the `unit`."""
    try:
        text = read_bytes(path).decode("utf-8")
        table = pd.read_csv(io.StringIO(text))
    except InputError:  # a ValueError, but its sentence says more than the next one
        raise
    except ValueError as error:
        reason = str(error).splitlines()[0]
        raise InputError(f"{path} cannot be read ({reason}): delete it and run the study again.") from None
    # pandas does not notice that the last line is cut within a number
    if not text.endswith("\n"):
        raise InputError(f"{path} is cut short: delete it and run the study again.")
    if missing := missing_columns(Path(path).name, table.columns):
        raise InputError(f"{path} lacks the column {missing[0]}: delete it and run the study again.")
    if rows is not None and len(table) != rows:
        raise InputError(
            f"{path} has {len(table)} rows for {rows} {unit}: delete it and run the study again."
        )
    return table


def read_roughness(path: Path | str, surface: Surface) -> np.ndarray:
    """Read R_i of the dots of a surface, (N,), from roughness.csv, each between 0 and 1."""
    table = read_table(path, len(surface), "dots")
    values = pd.to_numeric(table.get("roughness", pd.Series(["none"])), errors="coerce").to_numpy(float)
    if not ((values >= 0) & (values <= 1)).all():
        raise InputError(f"{path} has an R_i that is not between 0 and 1: delete it and run the study again.")
    return values


def read_prepared(
    surface: str, roughness: str, settings: Settings, streams: Streams, threads: int = 1
) -> PreparedSurface:
    """Prepare a surface of a study, whose dots and roughness lie in files."""
    dots = read_npz(surface)
    return PreparedSurface(dots, settings, read_roughness(roughness, dots), streams, threads)


def read_residues(path: Path | str) -> pd.DataFrame:
    """Read a table of residues; "" for a chain without name, while a chain or an ion may be called NA."""
    names = dict.fromkeys(["chain", "residue"], str)
    return pd.read_csv(path, dtype=names, keep_default_na=False, na_values=[""]).fillna({"chain": ""})


def read_minimal(path: Path | str, surface: Surface) -> pd.DataFrame:
    """Read minimal.csv, whose weights add up to the number of dots of the surface."""
    table = read_table(path)
    if "weight" not in table or table["weight"].sum() != len(surface):
        raise InputError(
            f"{path} does not represent all {len(surface)} dots: delete it and run the study again."
        )
    return table


def surface_of_minimal(table: pd.DataFrame) -> Surface:
    """Return the kept dots of a minimal.csv, which say how their surface is reconstructed."""
    reconstruction = Reconstruction.of_columns(
        {str(name): column.to_numpy() for name, column in table.items()}
    )
    points, normals = table[["x", "y", "z"]].to_numpy(), table[["nx", "ny", "nz"]].to_numpy()
    return Surface(points, normals, reconstruction=reconstruction)


def grid_table(grid: Grid) -> pd.DataFrame:
    """Summarise a grid: the rows of grid.csv, one per combination."""
    table = pd.DataFrame(grid.combinations, columns=PARAMETERS)
    table["n_S"] = grid.n_s.mean(axis=1)
    table["n_S_percent"] = 100 * table["n_S"] / grid.n_dots
    table["n_S_expected"] = grid.n_s_expected
    for r, reading in enumerate(grid.readings):
        values = {"Z_tS": grid.z_ts[r], "Z_tR": grid.z_tr[r], "d": d_values(grid, r)}
        for name, x in values.items():
            mean = estimate(x)
            table[f"{name}_{reading}"], table[f"{name}_se_{reading}"] = mean.mean, mean.error
            table[f"{name}_low_{reading}"], table[f"{name}_high_{reading}"] = mean.low, mean.high
        table[f"median_patch_size_{reading}"], table[f"median_patch_size_uniform_{reading}"] = (
            grid.median_patch_size[r]
        )
    return table


def d_values(grid: Grid, r: int) -> np.ndarray:
    """Return d of every combination, draw and test dot, under reading number r: (K, D, T) float64."""
    return grid.z_tr[r].astype(np.float64) - grid.z_ts[r]


def ranges_table(
    table: pd.DataFrame, grid: Grid, n_ranges: int = 10, floors: Mapping[str, float] | None = None
) -> pd.DataFrame:
    """Choose the combination with the highest d in each range of n_S, under each reading: the rows of ranges.csv (Table I).

    `d_cv` is measured on test dots and draws that were not used for the selection; d is too high, as it is the criterion.
    `best_set` are the combinations that contain the truly best one with 95 % confidence. A range without combinations has NaN.
    The combination that keeps the most dots is in no range, see `range_index`.
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
    return add_reference_columns(pd.DataFrame(rows), all_reference_values(grid, floors))


def all_reference_values(grid: Grid, floors: Mapping[str, float] | None) -> dict[str, Any]:
    """Return `statistics.reference_values`, with the noise floors (floor -> Z) if they were measured."""
    return reference_values(grid.z_tot) | ({"floors": floors} if floors else {})


def floors_by_name(floors: pd.DataFrame) -> dict[str, float]:
    """Return floor -> Z of a table of `floors.floors_table`."""
    return dict(zip(floors["floor"], floors["Z"].astype(float), strict=True))


def add_reference_columns(table: pd.DataFrame, references: Mapping[str, Any]) -> pd.DataFrame:
    """Add the reference values to every row of a table of Z: Z_empty, Z_mean_descriptor, and Z_resampled if measured."""
    table = table.assign(Z_empty=references["Z_empty"], Z_mean_descriptor=references["Z_mean_descriptor"])
    return table.assign(Z_resampled=references["floors"]["fresh dots"]) if "floors" in references else table


def _winner(table: pd.DataFrame, d: np.ndarray, reading: str, inside: np.ndarray) -> dict[str, Any]:
    """Return the row of the highest d among the combinations `inside`."""
    sub = table.iloc[inside]
    best = int(np.argmax(sub[f"d_{reading}"].to_numpy()))
    validated = cross_validated(d[inside])
    winner, of_reading = sub.iloc[best], ("d", "d_low", "d_high", "Z_tS", "Z_tR", "median_patch_size")
    row = {"n_combinations": len(inside)} | {key: winner[key] for key in [*PARAMETERS, "n_S", "n_S_percent"]}
    row |= {"d_cv": float(validated.mean), "d_cv_low": float(validated.low)}
    row |= {"d_cv_high": float(validated.high)} | {key: winner[f"{key}_{reading}"] for key in of_reading}
    candidates = sub[best_set(d[inside])]
    row["n_best_set"] = len(candidates)
    row["best_set"] = join_combinations(combination_labels(candidates))
    return row


def best_combinations(
    table: pd.DataFrame, grid: Grid, max_n_s_percent: float, floors: Mapping[str, float] | None = None
) -> dict[str, Any]:
    """Choose the best combinations of a surface, and return them with the reference values: the content of best.json.

    Per reading, `unrestricted` has the highest d at the largest alpha (the paper fixes alpha = 1), and `under_max_n_S` that
    with n_S at most `max_n_s_percent` % of the dots.
    """
    alpha = table["alpha"].max()
    few = table["n_S_percent"].to_numpy() <= max_n_s_percent
    out: dict[str, Any] = {"N": grid.n_dots, "combinations": len(table), "draws": grid.n_s.shape[1]}
    out |= {"max_n_S_percent": max_n_s_percent, "references": all_reference_values(grid, floors)}
    for r, reading in enumerate(grid.readings):
        d = d_values(grid, r)
        unrestricted = _winner(table, d, reading, np.flatnonzero(table["alpha"] == alpha))
        if few.any():
            bounded = _winner(table, d, reading, np.flatnonzero(few))
        else:
            least = table["n_S_percent"].min()
            bounded = {
                "answer": f"No combination of the grid keeps {max_n_s_percent:g} % of the dots or fewer; "
                f"the smallest n_S is {least:.2f} %. Add smaller values of alpha."
            }
        out[reading] = {"unrestricted": unrestricted, "under_max_n_S": bounded}
    return out


def range_limits(values: ArrayLike, n_ranges: int) -> np.ndarray:
    """Return the limits of equal ranges between the smallest and the largest value: (n_ranges + 1,) float64."""
    return np.linspace(np.min(values), np.max(values), n_ranges + 1)


def range_index(values: np.ndarray, limits: np.ndarray | Sequence[float]) -> np.ndarray:
    """Return the index of the range, from 0, to which each value belongs: with its lower limit, without its upper one.

    So, as in the authors' script, the largest value belongs to no range (index n) unless it is the only one.
    """
    if limits[0] == limits[-1]:
        return np.zeros(len(values), int)
    return np.clip(np.searchsorted(limits, values, side="right") - 1, 0, len(limits) - 1)


def bin_index(values: np.ndarray, limits: np.ndarray | Sequence[float]) -> np.ndarray:
    """Return the index of the bin, from 0, to which each value belongs; the last bin contains its upper limit."""
    return np.minimum(range_index(values, limits), len(limits) - 2)
