"""The surface by residue: area, roughness and number of kept dots."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from sparsurf.molecules.molecule import Molecule
from sparsurf.surfaces.components import fields_without_component, on_cavities
from sparsurf.surfaces.surface import CONCAVE, CONTACT, SADDLE, Surface

KIND_NUMBERS = {"contact": CONTACT, "saddle": SADDLE, "concave": CONCAVE}


def residue_table(
    surface: Surface,
    roughness: np.ndarray,
    molecule: Molecule,
    kept: np.ndarray | Sequence[int] = (),
    weight: np.ndarray | Sequence[int] = (),
    component: np.ndarray | None = None,
    cavity: np.ndarray | None = None,
    areas: np.ndarray | None = None,
) -> pd.DataFrame:
    """Tabulate the surface by residue, in the order of the structure.

    `roughness` is R_i of the dots, (N,). A residue without dots outside of cavities is buried: its roughness is NaN.

    `kept` (n,) are the dots of a subset and `weight` (n,) the number that each represents. A closed cavity has a low R_i since
    its wall turns around the probe, not because it is rough: where the `component` (N,) of each dot is known, dots on walls
    of cavities are left out of the roughness. `cavity` (N,) bool says so of dots that are a part of a surface. `areas` (A, 3) are
    the exact areas of the atoms by kind, by default those of dots that carry them; without them, areas are sums over dots.
    """
    table = molecule.residues
    n, residue = len(table), molecule.residue_index[surface.atom]
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
    table["most_rough"] = pd.Series(outside).groupby(residue).min().reindex(range(n)).to_numpy()
    for name, values in fields_without_component(surface).items():
        table[f"mean_{name}"] = pd.Series(values).groupby(residue).mean().reindex(range(n)).to_numpy()
    table["dots"] = np.bincount(residue, minlength=n)
    table["cavity_dots"] = np.bincount(residue[cavity], minlength=n)
    kept = np.asarray(kept, int)
    table["kept"] = np.bincount(residue[kept], minlength=n)
    table["weight"] = np.bincount(residue[kept], weight, n).astype(int)
    return table


def mean_roughness_by_residue(roughness: np.ndarray, residue: np.ndarray, n: int) -> np.ndarray:
    """Average R_i over the dots of each of n residues, (n,) float64; NaN dots are ignored, and residues without dots get NaN."""
    has_roughness = ~np.isnan(roughness)
    with np.errstate(invalid="ignore"):
        return np.bincount(residue[has_roughness], roughness[has_roughness], n) / np.bincount(
            residue[has_roughness], minlength=n
        )


def roughness_over_frames(residues: pd.DataFrame, roughness: np.ndarray | pd.DataFrame) -> pd.DataFrame:
    """Summarise the mean R_i of each residue over the frames of a trajectory, (F, n); NaN where it has no dots."""
    values = pd.DataFrame(roughness)
    return residues.assign(
        mean_roughness=values.mean().to_numpy(),
        sd_roughness=values.std().to_numpy(),
        most_rough=values.min().to_numpy(),
        largest_roughness=values.max().to_numpy(),
        frames=values.notna().sum().to_numpy(),
    )
