"""One side of a pair: a surface with what is known of its atoms, and the scores of its dots."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from sparsurf.molecules.residues import standard_name
from sparsurf.pairs import baselines
from sparsurf.patches.index import D_LINK, R_PATCH, PatchIndex, build_index
from sparsurf.patches.roughness import PUBLISHED, roughness
from sparsurf.surfaces.surface import Surface


@dataclass(frozen=True, eq=False)
class Partner:
    """A surface ready for its maps.

    Attributes
    ----------
    name : str
    surface : Surface
    index : PatchIndex
    roughness : (N,) float64, R_i
    residue : (N,) int64, row of `residues` under each dot; None where no atoms are known
    residues : DataFrame with chain, residue and residue_name; None where no atoms are known
    heavy_atoms : (A, 3) float64, Å; None where no atoms are known
    """

    name: str
    surface: Surface
    index: PatchIndex
    roughness: np.ndarray
    residue: np.ndarray = None
    residues: pd.DataFrame = None
    heavy_atoms: np.ndarray = None


def partner_of(surface, molecule=None, name="", r_patch=R_PATCH, d_link=D_LINK, threads=1, kind=PUBLISHED):
    """Make a surface ready.

    Parameters
    ----------
    surface : Surface
    molecule : molecules.Molecule, optional
        The atoms that `surface.atom` counts; without them there are no residues.
    name : str
    r_patch, d_link : float, Å
    threads : int
    kind : str, of roughness, see `roughness.ROUGHNESS`

    Returns
    -------
    Partner
    """
    index = build_index(surface.points, surface.normals, d_link)
    rough = roughness(index, r_patch, threads, kind)
    if molecule is None or surface.atom.min() < 0:
        return Partner(name, surface, index, rough)
    first = np.unique(molecule.residue_index, return_index=True)[1]
    residues = pd.DataFrame(
        {key: getattr(molecule, key)[first] for key in ("chain", "residue", "residue_name")}
    )
    heavy = molecule.xyz[0][~np.isin(molecule.element, ["H", "D"])]
    return Partner(name, surface, index, rough, molecule.residue_index[surface.atom], residues, heavy)


def baseline_scores(partner, at, threads=1):
    """The references of a propensity at some dots, the higher the likelier interface.

    Parameters
    ----------
    partner : Partner
    at : (n,) int, dots

    Returns
    -------
    dict, name -> (n,) float64: flatness (R_i), planarity, distance from the centroid, and where atoms are known
    protrusion and hydropathy.
    """
    points = partner.surface.points
    scores = {
        "flatness": partner.roughness[at],
        "planarity": baselines.planarity(points, points[at], threads=threads),
        "centroid": baselines.distance_from_centroid(points, points[at]),
    }
    if partner.residues is not None:
        names = partner.residues["residue_name"].map(standard_name).to_numpy(str)[partner.residue]
        scores["protrusion"] = baselines.protrusion(points[at], partner.heavy_atoms, threads=threads)
        scores["hydropathy"] = baselines.hydropathy(points, points[at], names, threads=threads)
    return scores
