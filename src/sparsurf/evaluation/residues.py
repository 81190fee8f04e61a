"""The surface by residue: area, roughness and number of kept dots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.kernels import njit
from sparsurf.molecules.molecule import Molecule
from sparsurf.surfaces.components import fields_without_component, on_cavities
from sparsurf.surfaces.surface import CONCAVE, CONTACT, SADDLE, Surface

if TYPE_CHECKING:
    import pandas as pd

KIND_NUMBERS = {"contact": CONTACT, "saddle": SADDLE, "concave": CONCAVE}


def residue_table(
    surface: Surface, roughness: np.ndarray, molecule: Molecule, *of_dots: Any, **named: Any
) -> pd.DataFrame:
    """Return the `residue_columns` of the same arguments as a DataFrame."""
    import pandas as pd  # here: it takes long to load

    return pd.DataFrame(residue_columns(surface, roughness, molecule, *of_dots, **named))


def residue_columns(
    surface: Surface,
    roughness: np.ndarray,
    molecule: Molecule,
    kept: np.ndarray | Sequence[int] = (),
    weight: np.ndarray | Sequence[int] = (),
    component: np.ndarray | None = None,
    cavity: np.ndarray | None = None,
    areas: np.ndarray | None = None,
) -> dict[str, np.ndarray]:
    """Tabulate the surface by residue, in the order of the structure, as columns by name.

    `roughness` is R_i of the dots, (N,). A residue without dots outside of cavities is buried: its roughness is NaN.

    `kept` (n,) are the dots of a subset and `weight` (n,) the number that each represents. A closed cavity has a low R_i since
    its wall turns around the probe, not because it is rough: where the `component` (N,) of each dot is known, dots on walls
    of cavities are left out of the roughness. `cavity` (N,) bool says so of dots that are a part of a surface. `areas` (A, 3) are
    the exact areas of the atoms by kind, by default those of dots that carry them; without them, areas are sums over dots.
    """
    table, residue = molecule.residue_columns(), molecule.residue_index[surface.atom]
    n = len(table["residue"])
    areas = surface.exact_areas if areas is None else areas
    if areas is None:
        by_kind = [
            np.bincount(residue, surface.area * (surface.kind == kind), n) for kind in KIND_NUMBERS.values()
        ]
        table["area"] = np.bincount(residue, surface.area, n)
    else:
        by_kind = [np.bincount(molecule.residue_index, of_kind, n) for of_kind in areas.T]
        table["area"] = np.sum(by_kind, axis=0)
    for name, values in zip(KIND_NUMBERS, by_kind, strict=True):
        table[f"area_{name}"] = values
    if cavity is None:
        cavity = np.zeros(len(surface), bool) if component is None else on_cavities(surface, component)
    outside = np.where(cavity, np.nan, roughness)
    table["mean_roughness"] = mean_roughness_by_residue(outside, residue, n)
    table["most_rough"] = np.full(n, np.nan)
    np.fmin.at(table["most_rough"], residue, outside)
    for name, values in fields_without_component(surface).items():
        table[f"mean_{name}"] = mean_by_group(values, residue, n)
    table["dots"] = np.bincount(residue, minlength=n)
    table["cavity_dots"] = np.bincount(residue[cavity], minlength=n)
    kept = np.asarray(kept, int)
    table["kept"] = np.bincount(residue[kept], minlength=n)
    table["weight"] = np.bincount(residue[kept], weight, n).astype(int)
    return table


def mean_by_group(values: np.ndarray, group: np.ndarray, n: int) -> np.ndarray:
    """Average the values (N,) of each of n groups, (n,) float64, as `sum_by_group`; a group without values has NaN."""
    with np.errstate(invalid="ignore"):
        return sum_by_group(values, group, n) / np.bincount(group[~np.isnan(values)], minlength=n)


def sum_by_group(values: np.ndarray, group: np.ndarray, n: int) -> np.ndarray:
    """Sum the values (N,) of each of n groups, (n,) float64; NaN does not count. To the last bit, it adds as pandas 3 does."""
    values, steps = np.ascontiguousarray(values, float), np.diff(group, prepend=-1)
    if (steps < 0).any() or np.isnan(values).any():
        return _sum_by_group(values, np.ascontiguousarray(group, np.int64), n)
    sums, first = np.zeros(n), np.flatnonzero(steps)
    sums[group[first]] = np.add.reduceat(values, first)
    return sums


@njit()
def _sum_by_group(values: np.ndarray, group: np.ndarray, n: int) -> np.ndarray:
    """Sum the values of each group; what a sum loses to rounding is added to the next value (Kahan)."""
    sums, lost = np.zeros(n), np.zeros(n)
    for i in range(len(values)):
        if not np.isnan(values[i]):
            k = group[i]
            value = values[i] - lost[k]
            total = sums[k] + value
            lost[k] = total - sums[k] - value
            if np.isnan(lost[k]):  # of infinite numbers
                lost[k] = 0.0
            sums[k] = total
    return sums


def mean_roughness_by_residue(roughness: np.ndarray, residue: np.ndarray, n: int) -> np.ndarray:
    """Average R_i over the dots of each of n residues, (n,) float64; NaN dots are ignored, and residues without dots get NaN."""
    has_roughness = ~np.isnan(roughness)
    with np.errstate(invalid="ignore"):
        return np.bincount(residue[has_roughness], roughness[has_roughness], n) / np.bincount(
            residue[has_roughness], minlength=n
        )


def roughness_over_frames(residues: pd.DataFrame, roughness: np.ndarray | pd.DataFrame) -> pd.DataFrame:
    """Summarise the mean R_i of each residue over the frames of a trajectory, (F, n); NaN where it has no dots."""
    import pandas as pd

    values = pd.DataFrame(roughness)
    return residues.assign(
        mean_roughness=values.mean().to_numpy(),
        sd_roughness=values.std().to_numpy(),
        most_rough=values.min().to_numpy(),
        largest_roughness=values.max().to_numpy(),
        frames=values.notna().sum().to_numpy(),
    )
