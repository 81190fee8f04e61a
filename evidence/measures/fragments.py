"""Table I on a surface of one of the paper's fragments: its ten combinations, and the choice of each range made again."""

import numpy as np
import pandas as pd

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.sampling import published
from sparsurf.sampling.combination import PUBLISHED_ROWS, TABLE_1, Combination
from sparsurf.study import tables
from sparsurf.study.best_set import best_set
from sparsurf.study.grid import Grid
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.study.statistics import cross_validated, estimate
from sparsurf.surfaces.molecular_surface import surface_of_frame
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.surfaces.surface import Surface

FROM_FILE = "file"  # the dots are those of the file
PUBLISHED_BEST = 5  # row of Table I with the highest d, (1, 0, 6, 0)


def dots_of(path: str, dots: str, settings: dict) -> Surface:
    """Read the dots of a file, or place dots on the structure in it ('dms' or 'exact', see `surface.reentrant`)."""
    if dots == FROM_FILE:
        return read_surface(path)
    molecule = read_molecule(path)
    return surface_of_frame(molecule, 0, radii(molecule, "dms"), settings | {"reentrant": dots})


def rows_table(grid: Grid) -> pd.DataFrame:
    """Compare d and Z of the published combinations with the published values.

    Parameters
    ----------
    grid : Grid of the published combinations, in the order of Table I

    Returns
    -------
    DataFrame, one row per reading and row of Table I: reading, row, combination, n_S_percent, d_published, Z_published, d and
    Z with 95 % intervals, d_inside and Z_inside (whether the published value lies inside, 0 or 1)
    """
    rows = []
    for r, reading in enumerate(grid.readings):
        d, z = estimate(tables.d_values(grid, r)), estimate(grid.z_ts[r])
        for k, combination in enumerate(PUBLISHED_ROWS):
            row = {"reading": reading, "row": k + 1, "combination": str(Combination(*combination))}
            row["n_S_percent"] = 100 * grid.n_s[k].mean() / grid.n_dots
            for name, of_name, key in (("d", d, "d"), ("Z", z, "Z_tS")):
                value = TABLE_1[key][k]
                row |= {
                    f"{name}_published": value,
                    name: of_name.mean[k],
                    f"{name}_low": of_name.low[k],
                    f"{name}_high": of_name.high[k],
                    f"{name}_inside": int(of_name.low[k] <= value <= of_name.high[k]),
                }
            rows.append(row)
    return pd.DataFrame(rows)


def choices_table(grid: Grid) -> pd.DataFrame:
    """Ask what choosing again on this surface gains over the combination of Table I.

    Each published combination is compared with all combinations of the range of n_S into which it falls here.

    Returns
    -------
    DataFrame, one row per reading and row of Table I: reading, row, n_S_percent, range (from 1, the one into which it falls),
    n_S_lowest_percent and n_S_highest_percent of the grid, d, gain with its 95 % interval (d of the combination chosen here minus
    d of the published one, cross-validated), may_be_best (0 or 1: it is in the confidence set of the best), rank in its range
    """
    percent = 100 * grid.n_s.mean(axis=1) / grid.n_dots
    limits = tables.range_limits(percent, len(PUBLISHED_ROWS))
    member, rows = tables.range_index(percent, limits), []
    for r, reading in enumerate(grid.readings):
        d = tables.d_values(grid, r)
        means = d.mean(axis=(1, 2))
        for k, combination in enumerate(PUBLISHED_ROWS):
            found = np.flatnonzero(np.isclose(grid.combinations, combination).all(axis=1))
            if not len(found):  # a grid of few combinations
                continue
            own = found[0]
            inside = np.flatnonzero(member == member[own])
            gain = cross_validated(d[inside] - d[own])
            rows.append(
                {
                    "reading": reading,
                    "row": k + 1,
                    "n_S_percent": percent[own],
                    "range": member[own] + 1,
                    "n_S_lowest_percent": percent.min(),
                    "n_S_highest_percent": percent.max(),
                    "d": means[own],
                    "gain": float(gain.mean),
                    "gain_low": float(gain.low),
                    "gain_high": float(gain.high),
                    "may_be_best": int(best_set(d[inside])[np.flatnonzero(inside == own)[0]]),
                    "rank": int((means[inside] > means[own]).sum()) + 1,
                    "n_combinations": len(inside),
                }
            )
    return pd.DataFrame(rows)


def surface_row(prepared: PreparedSurface) -> dict[str, float]:
    """Return dots, centres and roughness of a surface."""
    rough = prepared.roughness
    return {
        "dots": len(prepared.points),
        "centres": len(prepared.cover.centre),
        "mean_roughness": rough.mean(),
        "lowest_roughness": rough.min(),
        "highest_roughness": rough.max(),
    }


def published_grid(sampling: dict[str, list[float]]) -> np.ndarray:
    """Return the grid of combinations of the paper, (K, 4)."""
    return published.parameter_grid(**sampling)
