"""A partner of a pair: a surface with its residues and atoms, and the baseline scores of its dots."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.residues import standard_name
from sparsurf.pairs import baselines
from sparsurf.patches.index import D_LINK, R_PATCH, PatchIndex, build_index
from sparsurf.patches.roughness import PUBLISHED, roughness
from sparsurf.surfaces.surface import Surface


@dataclass(frozen=True, eq=False)
class Partner:
    """A surface prepared for maps.

    Attributes
    ----------
    name : str
    surface : Surface
    index : PatchIndex
    roughness : (N,) float64, R_i
    residue : (N,) int64, row of `residues` under each dot; None if the atoms are unknown
    residues : DataFrame with chain, residue and residue_name; None if the atoms are unknown
    heavy_atoms : (A, 3) float64, Å; None if the atoms are unknown
    """

    name: str
    surface: Surface
    index: PatchIndex
    roughness: np.ndarray
    residue: np.ndarray | None = None
    residues: pd.DataFrame | None = None
    heavy_atoms: np.ndarray | None = None


def partner_of(
    surface: Surface,
    molecule: Molecule | None = None,
    name: str = "",
    r_patch: float = R_PATCH,
    d_link: float = D_LINK,
    threads: int = 1,
    roughness_kind: str = PUBLISHED,
) -> Partner:
    """Prepare a surface for maps.

    Parameters
    ----------
    surface : Surface
    molecule : molecules.Molecule, optional
        Its atoms, to which `surface.atom` refers; without them there are no residues.
    name : str
    r_patch, d_link : float, Å
    threads : int
    roughness_kind : str, of roughness, see `roughness.ROUGHNESS`

    Returns
    -------
    Partner
    """
    index = build_index(surface.points, surface.normals, d_link)
    rough = roughness(index, r_patch, threads, roughness_kind)
    if molecule is None or surface.atom.min() < 0:
        return Partner(name, surface, index, rough)
    heavy = molecule.xyz[0][molecule.heavy]
    return Partner(
        name, surface, index, rough, molecule.residue_index[surface.atom], molecule.residues, heavy
    )


def baseline_scores(partner: Partner, at: np.ndarray, threads: int = 1) -> dict[str, np.ndarray]:
    """Compute the baselines of a propensity at some dots; higher values indicate an interface.

    Parameters
    ----------
    partner : Partner
    at : (n,) int, dots
    threads : int

    Returns
    -------
    dict, name -> (n,) float64
        Flatness (R_i), planarity, distance from the centroid; if the atoms are known, protrusion and hydropathy too.
    """
    points = partner.surface.points
    scores = {
        "flatness": partner.roughness[at],
        "planarity": baselines.planarity(points, points[at], threads=threads),
        "centroid": baselines.distance_from_centroid(points, points[at]),
    }
    if partner.residues is not None and partner.heavy_atoms is not None:
        names = partner.residues["residue_name"].map(standard_name).to_numpy(str)[partner.residue]
        scores["protrusion"] = baselines.protrusion(points[at], partner.heavy_atoms, threads=threads)
        scores["hydropathy"] = baselines.hydropathy(points, points[at], names, threads=threads)
    return scores
