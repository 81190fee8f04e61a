"""Partners of a pair: surfaces with their residues and atoms, the centres that are compared, and where they touch."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.molecules.molecule import Molecule
from sparsurf.patches.index import D_LINK, PatchIndex, build_index
from sparsurf.sampling.samplers import get_samplers
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.spacing import refuse_sparse
from sparsurf.surfaces.surface import Surface
from sparsurf_study.structures import read_study_structure

INTERFACE = 3.0  # Å; dots nearer than this to the partner's surface are interface (authors' scripts)


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


def read_partners(
    surface_1: str | Path,
    surface_2: str | Path,
    structure_1: str | Path | None,
    structure_2: str | Path | None,
    d_link: float,
    name: str,
) -> tuple[Partner, Partner]:
    """Read both partners of the pair `name`; a surface without atoms has no structure."""
    partners = []
    for side, surface, structure in ((1, surface_1, structure_1), (2, surface_2, structure_2)):
        dots = read_npz(surface)
        refuse_sparse(dots.points, d_link, f"{name}, partner {side}")
        molecule = read_study_structure(structure) if structure else None
        partners.append(partner_of(dots, molecule, f"{name} {side}", d_link))
    return partners[0], partners[1]


def select_centres(
    partner: Partner, centres: str | dict, settings: Settings, seed: int, threads: int = 1
) -> np.ndarray:
    """Select the dots whose patches are compared, ascending; `centres` is a section of the config."""
    n_dots = len(partner.surface)
    if isinstance(centres, str):  # all
        return np.arange(n_dots)
    n_centres = min(centres.get("n_dots") or max(1, round(centres["percent"] / 100 * n_dots)), n_dots)
    name = centres["sampler"]
    sampler = get_samplers([name], "complementarity.centres.sampler")[name]
    prepared = PreparedSurface(partner.surface, settings, None, Streams(seed, partner.name), threads)
    return np.sort(sampler(prepared, n_centres, prepared.stream("centres", name)))


def gaps(points: np.ndarray, partner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the dot of the partner that is nearest to each dot: its distance, (N,) Å, and its index."""
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

    distance, dot = cKDTree(partner).query(points)
    return np.asarray(distance), np.asarray(dot)


def interface(points: np.ndarray, partner: np.ndarray, within: float = INTERFACE) -> np.ndarray:
    """Label the dots that have a dot of the partner nearer than `within` Å, (N,) bool."""
    return gaps(points, partner)[0] < within


def native_pairs(points: np.ndarray, partner: np.ndarray, within: float = INTERFACE) -> np.ndarray:
    """Pair each dot that is nearer than `within` Å to the partner with the partner's nearest dot, (P, 2)."""
    gap, nearest = gaps(points, partner)
    touching = np.flatnonzero(gap < within)
    return np.column_stack([touching, nearest[touching]])
