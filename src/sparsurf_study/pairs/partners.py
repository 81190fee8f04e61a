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
    """A surface prepared for maps; what follows from its atoms is None if these are unknown."""

    name: str
    surface: Surface
    index: PatchIndex
    residue: np.ndarray | None = None  # (N,) int64, row of `residues` under each dot
    residues: pd.DataFrame | None = None  # chain, residue, residue_name
    heavy_atoms: np.ndarray | None = None  # (A, 3) float64, Å


def partner_of(
    surface: Surface, molecule: Molecule | None = None, name: str = "", d_link: float = D_LINK
) -> Partner:
    """Prepare a surface for maps; without the molecule to which `surface.atom` refers, there are no residues."""
    index = build_index(surface.points, surface.normals, d_link)
    if molecule is None or surface.atom.min() < 0:
        return Partner(name, surface, index)
    heavy = molecule.xyz[0][molecule.heavy]
    return Partner(name, surface, index, molecule.residue_index[surface.atom], molecule.residues, heavy)
