"""A partner of a pair: a surface with its residues and atoms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from sparsurf.molecules.molecule import Molecule
from sparsurf.patches.index import D_LINK, PatchIndex, build_index
from sparsurf.surfaces.surface import Surface


@dataclass(frozen=True, eq=False)
class Partner:
    """A surface prepared for maps.

    Attributes
    ----------
    name : str
    surface : Surface
    index : PatchIndex
    residue : (N,) int64, row of `residues` under each dot; None if the atoms are unknown
    residues : DataFrame with chain, residue and residue_name; None if the atoms are unknown
    heavy_atoms : (A, 3) float64, Å; None if the atoms are unknown
    """

    name: str
    surface: Surface
    index: PatchIndex
    residue: np.ndarray | None = None
    residues: pd.DataFrame | None = None
    heavy_atoms: np.ndarray | None = None


def partner_of(
    surface: Surface, molecule: Molecule | None = None, name: str = "", d_link: float = D_LINK
) -> Partner:
    """Prepare a surface for maps; without the molecule to which `surface.atom` refers, there are no residues."""
    index = build_index(surface.points, surface.normals, d_link)
    if molecule is None or surface.atom.min() < 0:
        return Partner(name, surface, index)
    heavy = molecule.xyz[0][molecule.heavy]
    return Partner(name, surface, index, molecule.residue_index[surface.atom], molecule.residues, heavy)
