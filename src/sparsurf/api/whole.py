"""The whole surface that dots are a part of: a page or a table of some dots tells the numbers of the whole."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.evaluation.residues import residue_table
from sparsurf.patches.roughness import RoughnessFunction, roughness_of_patches
from sparsurf.settings import PatchesSettings
from sparsurf.surfaces.components import on_cavities
from sparsurf.surfaces.molecular_surface import surface_of_spheres
from sparsurf.surfaces.surface import Surface
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    import pandas as pd

    from sparsurf.molecules.molecule import Molecule

SAME_AREA = 1e-6  # relative, of a subset, whose areas are sums of those of all dots
AREA_OF_COARSE_MESH = 0.6  # of the area of the dots, at least; a mesh of 500 vertices has 0.89 of it


@dataclass(frozen=True)
class WholeSurface:
    """All dots of the atoms that some dots lie on.

    Attributes
    ----------
    surface : Surface of all dots, as they were placed
    nearest : (n,) int64, of these, the dot nearest to each of the given dots, which is the dot itself for a part of them
    """

    surface: Surface
    nearest: np.ndarray

    @cached_property
    def cavity(self) -> np.ndarray:
        """Whether each dot lies on the wall of a cavity, (N,) bool."""
        return on_cavities(self.surface, self.surface.known_components("surface"))

    def roughness(self, patches: PatchesSettings) -> np.ndarray:
        """Compute R_i of all dots, (N,) float64."""
        from sparsurf.patches.index import build_index  # here: it loads kernels

        index = build_index(self.surface.points, self.surface.normals, patches.d_link)
        definition: str | RoughnessFunction = patches.roughness
        return roughness_of_patches(index, patches.r_patch, available_cores(), definition)

    def is_owned_by(self, dots: Surface) -> bool:
        """Return whether the areas of dots are those of the whole surface, as of a subset, points or the vertices of a mesh."""
        ratio = float(dots.area.sum()) / float(self.surface.area.sum())
        is_part = dots.origin is not None and len(dots.origin.points) > 0
        return abs(ratio - 1) <= SAME_AREA if is_part else ratio >= AREA_OF_COARSE_MESH

    def with_roughness(
        self, table: pd.DataFrame, roughness: np.ndarray, molecule: Molecule, with_area: bool = False
    ) -> pd.DataFrame:
        """Return the `residue_table` of the given dots with the roughness, and the areas, of its residues on the whole surface.

        The mean over some dots of a residue is another number, and would name another residue as the roughest.
        """
        whole = residue_table(self.surface, roughness, molecule, cavity=self.cavity)
        has_dots = table["mean_roughness"].notna()
        taken = {name: whole[name].where(has_dots) for name in ("mean_roughness", "most_rough")}
        if with_area:
            taken |= {str(name): whole[name] for name in whole if str(name).startswith("area")}
        return table.assign(**taken)


def whole_surface(dots: Surface) -> WholeSurface | None:
    """Return the whole surface of dots whose atoms are known, placed again where they are a part of it; else None."""
    if dots.placed:
        return WholeSurface(dots, np.arange(len(dots)))
    whole = placed_again(dots)
    if whole is None:
        return None
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

    return WholeSurface(whole, np.asarray(cKDTree(whole.points).query(dots.points)[1]))


def placed_again(dots: Surface) -> Surface | None:
    """Return all dots of the surface that dots are a part of, or that their atoms have; None if it is not known."""
    origin = dots.origin
    if origin is None:
        return None
    if not len(origin.points):  # of points, or of the vertices of a mesh
        return surface_of_spheres(origin.xyz, origin.radii, origin.rules, origin.d_link, "surface")
    place, xyz = origin.generator()
    whole = place(xyz)
    return replace(whole, origin=origin) if np.array_equal(whole.points, origin.points) else None
