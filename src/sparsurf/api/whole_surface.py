"""Find the whole surface that dots are a part of, whose numbers a page or a table of these dots states.

It is that of their atoms where these are known. Otherwise it is reconstructed from dots whose own patches would be fragmented.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.api.surfaces import placement_of
from sparsurf.errors import InputError
from sparsurf.files import pluralise
from sparsurf.patches.index import D_LINK, build_index
from sparsurf.patches.islands import are_fragmented
from sparsurf.patches.roughness import RoughnessFunction, roughness_of_patches
from sparsurf.settings import PatchesSettings
from sparsurf.surfaces.components import on_cavities
from sparsurf.surfaces.molecular_surface import surface_of_spheres
from sparsurf.surfaces.spacing import DENSITY, area_of
from sparsurf.surfaces.surface import Surface
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    import pandas as pd

    from sparsurf.molecules.molecule import Molecule

log = logging.getLogger("sparsurf")

FEWEST_DOTS = 12  # No surface is reconstructed from fewer dots.
# Dots per Å^2, estimated from their distances. The mean roughness of a surface reconstructed from evenly spread or random dots
# differs by at most .024 from the true one at .1 and above, by .04 at .08, and by .1 at .05.
MIN_DENSITY = 0.1
SAME_AREA = 1e-6  # relative, of a subset, whose areas are sums of those of all dots
AREA_OF_COARSE_MESH = 0.6  # of the area of the dots, at least; a mesh of 500 vertices has 0.89 of it


@dataclass(frozen=True)
class WholeSurface:
    """A surface whose patches hold together, and some dots of it.

    Attributes
    ----------
    surface : Surface of all dots, as they were placed, or as they were reconstructed
    nearest : (n,) int64, of these, the dot nearest to each of the given dots, which is the dot itself for a part of them
    """

    surface: Surface
    nearest: np.ndarray

    @cached_property
    def cavity(self) -> np.ndarray:
        """Whether each dot lies on the wall of a cavity, (N,) bool; not known of a reconstructed surface."""
        components = self.components
        return (
            np.zeros(len(self.surface), bool) if components is None else on_cavities(self.surface, components)
        )

    @cached_property
    def components(self) -> np.ndarray | None:
        """The component of each dot, (N,) int; None for a reconstructed surface."""
        return self.surface.known_components("surface") if self.surface.placed else None

    def roughness(self, patches: PatchesSettings) -> np.ndarray:
        """Compute R_i of all dots, (N,) float64."""
        index = build_index(self.surface.points, self.surface.normals, patches.d_link)
        definition: str | RoughnessFunction = patches.roughness
        return roughness_of_patches(index, patches.r_patch, available_cores(), definition)

    def is_owned_by(self, dots: Surface) -> bool:
        """Return whether the areas of dots are those of the whole surface, as of a subset, points or the vertices of a mesh."""
        if dots.placed:
            return True
        ratio = float(dots.area.sum()) / float(self.surface.area.sum())
        is_part = dots.origin is not None and len(dots.origin.points) > 0
        return abs(ratio - 1) <= SAME_AREA if is_part else ratio >= AREA_OF_COARSE_MESH

    def with_roughness(
        self,
        table: pd.DataFrame,
        roughness: np.ndarray,
        molecule: Molecule,
        with_area: bool = False,
        with_dots: bool = False,
    ) -> pd.DataFrame:
        """Return the `residue_table` of the given dots with the roughness, and the areas, of its residues on the whole surface.

        The mean over some dots of a residue is another number, and would name another residue as the roughest. `with_dots` all
        numbers are those of the whole surface, but for the means of fields that it does not have.
        """
        from sparsurf.evaluation.residues import residue_table  # here: it loads pandas

        whole = residue_table(self.surface, roughness, molecule, cavity=self.cavity)
        if with_dots:
            return whole.assign(**{str(name): table[name] for name in table if name not in whole})
        has_dots = table["mean_roughness"].notna()
        taken = {name: whole[name].where(has_dots) for name in ("mean_roughness", "most_rough")}
        is_complete = table["dots"] == whole["dots"]
        for name in (str(name) for name in whole if str(name).startswith("area")):
            taken[name] = whole[name] if with_area else whole[name].where(is_complete, table[name])
        return table.assign(**taken)


def whole_surface(dots: Surface) -> WholeSurface | None:
    """Return the whole surface of dots whose atoms are known; else None.

    It is placed again where the dots are a part of it, and more densely where its patches would be fragmented.
    """
    whole = dots if dots.placed else placed_again(dots)
    if whole is None or whole.origin is None:
        return None
    origin, rules = whole.origin, replace(placement_of(whole.origin.rules), density="auto")
    # then the same dots would be placed
    suits_already = origin.rules.density == "auto" and origin.d_link == D_LINK
    if not suits_already and are_fragmented(whole.points, whole.normals):
        whole = surface_of_spheres(origin.xyz, origin.radii, rules, D_LINK, "surface")
    if whole is dots:
        return WholeSurface(dots, np.arange(len(dots)))
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

    return WholeSurface(whole, np.asarray(cKDTree(whole.points).query(dots.points)[1]))


def with_patches(function: str, dots: Surface, patches: PatchesSettings) -> WholeSurface:
    """Return the surface whose patches tell the roughness of dots; raise InputError if there is none.

    These are the dots themselves, unless their patches would be fragmented. Then the whole surface of their atoms takes their
    place, or else the surface that is reconstructed from them, and a warning says so in the name of a function.
    """
    n, d_link = len(dots), max(patches.d_link, D_LINK)
    named = pluralise(n, "dot", separator=",")
    if not are_fragmented(dots.points, dots.normals, d_link, patches.r_patch):
        return WholeSurface(dots, np.arange(n))
    message = "%s: patches of the %s would be fragmented, so their roughness is that of the %s"
    if (whole := whole_surface(dots)) is not None:
        log.warning(message, function, named, "whole surface of their atoms")
        return whole
    without = f"{function}: the roughness is left out: patches of the {named} would be fragmented, and"
    if n < FEWEST_DOTS:
        raise InputError(f"{without} a surface is reconstructed from at least {FEWEST_DOTS} dots; give more.")
    density = n / area_of(Surface(dots.points, dots.normals))[0]
    if density < MIN_DENSITY:
        raise InputError(
            f"{without} {density:.2g} dots per Å^2 are too few to reconstruct their surface; give at least {MIN_DENSITY:g}."
        )
    log.warning(message, function, named, "surface reconstructed from them")
    return WholeSurface(_reconstructed(dots), np.arange(n))


def patches_or_none(function: str, dots: Surface, patches: PatchesSettings) -> WholeSurface | None:
    """Return the surface of `with_patches`; None, with a warning, if there is none."""
    try:
        return with_patches(function, dots, patches)
    except InputError as error:
        log.warning("%s", error)
        return None


def _reconstructed(dots: Surface) -> Surface:
    """Reconstruct the dense surface of dots, which come first; each new one has the atom of the nearest, and no known kind."""
    from sparsurf.recovery.reconstructing import (
        reconstruct,
        surface_with_fields,
    )  # here: most surfaces are dense
    from sparsurf.sampling.samplers import nearest_kept

    dense = surface_with_fields(dots, reconstruct(dots, DENSITY, threads=available_cores()))
    nearest, _ = nearest_kept(dense.points, np.arange(len(dots)), available_cores())
    kind = np.where(np.arange(len(dense)) < len(dots), dots.kind[nearest], -1)
    return replace(dense, kind=kind, atom=dots.atom[nearest])


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
