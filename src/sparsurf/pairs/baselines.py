"""Simple properties of a dot's surroundings, as baselines for a propensity; higher values indicate an interface."""

from __future__ import annotations

import numpy as np

from sparsurf.pairs.neighbourhoods import means_within

REACH = 10.0  # Å, radius within which planarity, hydropathy and protrusion are computed
# Hydropathy index (Kyte & Doolittle, J. Mol. Biol. 157:105, 1982)
KYTE_DOOLITTLE = {
    "ILE": 4.5, "VAL": 4.2, "LEU": 3.8, "PHE": 2.8, "CYS": 2.5, "MET": 1.9, "MSE": 1.9, "ALA": 1.8, "GLY": -0.4,
    "THR": -0.7, "SER": -0.8, "TRP": -0.9, "TYR": -1.3, "PRO": -1.6, "HIS": -3.2, "GLU": -3.5, "GLN": -3.5,
    "ASP": -3.5, "ASN": -3.5, "LYS": -3.9, "ARG": -4.5,
}  # fmt: skip


def planarity(points: np.ndarray, at: np.ndarray, reach: float = REACH, threads: int = 1) -> np.ndarray:
    """Compute minus the root mean square distance in Å of the dots within `reach` from the plane fitted to them [1]_.

    Parameters
    ----------
    points : (N, 3) float64, Å, all dots
    at : (n, 3) float64, Å, positions at which it is computed
    reach : float, Å
    threads : int

    Returns
    -------
    (n,) float64; 0 is a plane

    References
    ----------
    .. [1] Jones & Thornton, J. Mol. Biol. 272:121 (1997).
    """
    x = points - points.mean(axis=0)
    squares = np.stack([x[:, i] * x[:, j] for i in range(3) for j in range(3)], axis=1)
    means, _ = means_within(at, points, np.hstack([x, squares]), reach, threads)
    covariance = means[:, 3:].reshape(-1, 3, 3) - means[:, :3, None] * means[:, None, :3]
    return -np.sqrt(np.maximum(np.linalg.eigvalsh(covariance)[:, 0], 0.0))


def protrusion(at: np.ndarray, heavy_atoms: np.ndarray, reach: float = REACH, threads: int = 1) -> np.ndarray:
    """Compute minus the number of heavy atoms within `reach`, which is highest where the surface protrudes.

    Dots are ranked as by the protrusion index CX, the ratio of the free to the filled volume of that sphere [1]_.

    Parameters
    ----------
    at : (n, 3) float64, Å
    heavy_atoms : (A, 3) float64, Å
    reach : float, Å
    threads : int

    Returns
    -------
    (n,) float64

    References
    ----------
    .. [1] Pintar et al., Bioinformatics 18:980 (2002).
    """
    return -means_within(at, heavy_atoms, np.zeros(len(heavy_atoms)), reach, threads)[1].astype(np.float64)


def hydropathy(
    points: np.ndarray, at: np.ndarray, residue_names: np.ndarray, reach: float = REACH, threads: int = 1
) -> np.ndarray:
    """Compute the mean Kyte-Doolittle index over the dots within `reach`.

    Parameters
    ----------
    points : (N, 3) float64, Å
    at : (n, 3) float64, Å
    residue_names : (N,) str, the standard residue under each dot; dots of other residues do not count
    reach : float, Å
    threads : int

    Returns
    -------
    (n,) float64; NaN if no dot within reach belongs to a standard amino acid
    """
    names, name_of = np.unique(residue_names, return_inverse=True)
    index = np.array([KYTE_DOOLITTLE.get(str(name), np.nan) for name in names])[name_of]
    known = ~np.isnan(index)
    if not known.any():
        return np.full(len(at), np.nan)
    return means_within(at, points[known], index[known], reach, threads)[0]


def distance_from_centroid(points: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Compute the distance in Å of positions (n, 3) from the mean of all dots (N, 3)."""
    return np.linalg.norm(at - points.mean(axis=0), axis=1)
