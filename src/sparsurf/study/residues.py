"""The surface residue by residue: how much of it each one makes, how rough it is, how many of its dots are kept."""

import numpy as np
import pandas as pd

from sparsurf.surfaces.components import fields_alone
from sparsurf.surfaces.surface import CONCAVE, CONTACT, SADDLE

KINDS = {"contact": CONTACT, "saddle": SADDLE, "concave": CONCAVE}


def residue_table(surface, roughness, molecule, kept=(), weight=()):
    """One row per residue, in the order of the structure.

    Parameters
    ----------
    surface : Surface
        Its `atom` counts the atoms of the molecule; its fields are averaged.
    roughness : (N,) float64, R_i
    molecule : molecules.molecule.Molecule
    kept : (n,) int
        Dots of a subset.
    weight : (n,) int
        Number of dots that each of them stands for.

    Returns
    -------
    DataFrame: chain, residue, residue_name; area and area_contact, area_saddle, area_concave in Å^2; mean_roughness and
    least_roughness, mean and lowest R_i of its dots; mean_<field>; dots, kept, and weight, the dots that its kept ones
    stand for. A residue without dots is buried: no area, R_i NaN.
    """
    table = molecule.residues
    n, residue = len(table), molecule.residue_index[surface.atom]
    table["area"] = np.bincount(residue, surface.area, n)
    for name, kind in KINDS.items():
        table[f"area_{name}"] = np.bincount(residue, surface.area * (surface.kind == kind), n)
    table["mean_roughness"] = mean_roughness_by_residue(roughness, residue, n)
    table["least_roughness"] = pd.Series(roughness).groupby(residue).min().reindex(range(n)).to_numpy()
    for name, values in fields_alone(surface).items():
        table[f"mean_{name}"] = pd.Series(values).groupby(residue).mean().reindex(range(n)).to_numpy()
    table["dots"] = np.bincount(residue, minlength=n)
    kept = np.asarray(kept, int)
    table["kept"] = np.bincount(residue[kept], minlength=n)
    table["weight"] = np.bincount(residue[kept], weight, n).astype(int)
    return table


def mean_roughness_by_residue(roughness, residue, n):
    """Mean R_i of the dots of each of n residues, (n,) float64; NaN for one without dots."""
    with np.errstate(invalid="ignore"):
        return np.bincount(residue, roughness, n) / np.bincount(residue, minlength=n)


def roughness_over_frames(residues, roughness):
    """How the mean R_i of each residue varies over the frames of a trajectory.

    Parameters
    ----------
    residues : DataFrame with chain, residue, residue_name
    roughness : (F, n) float64, mean R_i of each residue in each frame; NaN where it has no dots

    Returns
    -------
    DataFrame: `residues` with mean, sd, least and largest mean R_i over the frames in which the residue has dots, and
    their number.
    """
    known = pd.DataFrame(roughness)
    return residues.assign(
        mean_roughness=known.mean().to_numpy(),
        sd_roughness=known.std().to_numpy(),
        least_roughness=known.min().to_numpy(),
        largest_roughness=known.max().to_numpy(),
        frames=known.notna().sum().to_numpy(),
    )
