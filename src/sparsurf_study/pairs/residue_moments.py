"""Describe the residues of a molecule by the shape and the fields of the surface around them.

A tenth of the dots are described, the `places`: moments of their patches, cut from these dots alone. A residue has the mean of
its places. The moments are invariant under rotation.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from sparsurf.dot_fields.named_fields import compute_fields, mean_of_residues
from sparsurf.errors import InputError
from sparsurf.molecules.molecule import Molecule
from sparsurf.patches.descriptors import PATCHES_PER_CALL, describe_fields_of_patches, describe_patches
from sparsurf.patches.index import D_LINK, build_grid
from sparsurf.patches.readings import linked_by_spacing
from sparsurf.patches.zernike.polynomials import indices
from sparsurf.recovery.interpolated_surface import dot_spacing
from sparsurf.sampling.farthest_point import farthest_point_sampling
from sparsurf.surfaces.surface import Surface

MOMENT_FIELDS = ("hydropathy", "volume", "aromaticity", "charge", "potential")
# Volume of a residue inside proteins, Å^3: Zamyatnin, Prog. Biophys. Mol. Biol. 24:107, 1972
VOLUME = {
    "ALA": 88.6, "ARG": 173.4, "ASN": 114.1, "ASP": 111.1, "CYS": 108.5, "GLN": 143.8, "GLU": 138.4, "GLY": 60.1,
    "HIS": 153.2, "ILE": 166.7, "LEU": 166.7, "LYS": 168.6, "MET": 162.9, "MSE": 162.9, "PHE": 189.9, "PRO": 112.7,
    "SER": 89.0, "THR": 116.1, "TRP": 227.8, "TYR": 193.6, "VAL": 140.0,
}  # fmt: skip
RINGS = {"PHE": 1.0, "TYR": 1.0, "TRP": 1.0, "HIS": 0.6}  # aromatic residues; histidine's ring is polar
CHARGES = {"LYS": 1.0, "ARG": 1.0, "ASP": -1.0, "GLU": -1.0}  # The charges of side chains at pH 7.
MOMENT_CHANNELS = ("shape", *MOMENT_FIELDS)
PERCENT_OF_DOTS = 10  # So many of the dots are described.
PATCH_RADIUS = 10.0  # Å, of the patches
ORDER = 10  # highest order n of the moments; finer detail differs between two forms of a protein
MIN_DOTS_IN_PATCH = 12  # patches with fewer dots are not described
PLACES_AT_ONCE = 8 * PATCHES_PER_CALL  # described at a time; their float64 moments need 24 MB


class ResidueMoments(NamedTuple):
    """Descriptors of the residues of a form; NaN for residues without places."""

    moments: np.ndarray  # (R, C, K) float64, mean moments of CHANNELS
    fields: np.ndarray  # (R, F) float64, mean of FIELDS
    places: np.ndarray  # (R,) int, numbers of places


def describe_residues(dots: Surface, molecule: Molecule, name: str, threads: int = 1) -> ResidueMoments:
    """Describe the residues of a molecule from the dots of its surface, whose `atom` refers to its atoms."""
    kept = _farthest_subset(dots)
    table = _fields(molecule, kept.points)
    # The moment of n = 0 is the mean of a field, without its sign. With this offset, the mean is positive
    lift = np.ceil(np.nanmax(np.abs(table.to_numpy()), axis=0))
    moments, described = _moments(kept, (table + lift).to_numpy().T, name, threads)
    moments[:, 1:, 0] -= lift
    n, residue = molecule.n_residues, molecule.residue_index[kept.atom]
    means = _means(moments.reshape(len(moments), -1), residue[described], n)
    return ResidueMoments(
        means.reshape(n, *moments.shape[1:]),
        _means(table.to_numpy(), residue, n),
        np.bincount(residue, minlength=n),
    )


def _fields(molecule: Molecule, points: np.ndarray) -> pd.DataFrame:
    """Return FIELDS at dots (N, F): those that users know, and scales of residues (Å^3, share, e)."""
    table = pd.DataFrame(compute_fields(["hydropathy", "potential"], molecule, points))
    none = dict.fromkeys(VOLUME, 0.0)
    for name, scale in (("volume", VOLUME), ("aromaticity", none | RINGS), ("charge", none | CHARGES)):
        table[name] = mean_of_residues(scale, molecule, points)
    return table[[*MOMENT_FIELDS]]


def _farthest_subset(dots: Surface) -> Surface:
    """Choose PERCENT of the dots by farthest-point sampling, the same for every call."""
    n = max(1, round(PERCENT_OF_DOTS / 100 * len(dots)))
    return dots.take(farthest_point_sampling(build_grid(dots.points), n, np.random.default_rng(0)))


def _moments(kept: Surface, fields: np.ndarray, name: str, threads: int) -> tuple[np.ndarray, np.ndarray]:
    """Return moments (P, C, K) float64 of the dots whose patch is large enough, and the indices (P,) of these dots."""
    area = float((dot_spacing(kept.points, kept.normals) ** 2).sum())
    index = linked_by_spacing(kept.points, kept.normals, D_LINK, area)
    filled = np.array([np.where(np.isfinite(field), field, np.nanmean(field)) for field in fields])
    low = np.array([n <= ORDER for n, _ in indices()])
    moments = np.empty((len(kept), 1 + len(filled), low.sum()), np.float16)
    sizes = np.empty(len(kept), np.int32)
    for begin in range(0, len(kept), PLACES_AT_ONCE):
        block = slice(begin, begin + PLACES_AT_ONCE)
        z, sizes[block] = describe_patches(
            index, kept.points[block], PATCH_RADIUS, True, threads, "rotation_robust"
        )
        moments[block, 0] = z[:, low]
        moments[block, 1:] = describe_fields_of_patches(
            index, kept.points[block], filled, PATCH_RADIUS, threads
        )[:, :, low]
    described = np.flatnonzero(sizes >= MIN_DOTS_IN_PATCH)
    if len(described) == 0:
        raise InputError(
            f"{name}: no patch of {PATCH_RADIUS:g} Å has {MIN_DOTS_IN_PATCH} dots; use a larger surface."
        )
    return moments[described].astype(float), described


def _means(rows: np.ndarray, group: np.ndarray, n: int) -> np.ndarray:
    """Average rows by their group, (n, M)."""
    table = pd.DataFrame(rows).groupby(group).mean()
    return table.reindex(range(n)).to_numpy()


def distances(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Compute distances (R, C + 1), by channel and of all, between moments (R, C, K): rms in standard deviations of proteins."""
    square = (((first - second) / spread_of_moments()) ** 2).mean(axis=2)
    return np.sqrt(np.column_stack([square, square.mean(axis=1)]))


@cache
def spread_of_moments() -> np.ndarray:
    """Return the standard deviations (C, K) float32 of the moments over the places of 22 proteins of a docking benchmark."""
    table = pd.read_csv(Path(__file__).with_name("spread_of_moments.csv"), dtype=np.float32)
    return np.ascontiguousarray(table[[*MOMENT_CHANNELS]].to_numpy().T)
