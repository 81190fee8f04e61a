"""Choose what a page shows of the dots that are given: all of a surface, some of it, or the surface that they stand for."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.api.page_metadata import About, heard
from sparsurf.api.whole_surface import WholeSurface, patches_or_none, whole_surface
from sparsurf.patches.index import build_grid, select_separated
from sparsurf.settings import PatchesSettings
from sparsurf.surfaces.components import (
    columns_of_components,
    on_cavities,
    stored_components,
    summarize_components,
    volume_in_words,
)

if TYPE_CHECKING:
    import pandas as pd

    from sparsurf.surfaces.surface import Surface
    from sparsurf.views.page.page import Extent

# The picture of a surface with more dots shows about so many, evenly spread: enough for the eye, in a page that stays small
MAX_DOTS_OF_PICTURE, FEWER_DOTS = 200_000, 50_000
# Of dots chosen one after another, each at a distance from those before: dots on an area of the squared distance
DOTS_PER_SQUARED_DISTANCE = 0.7


@dataclass(frozen=True)
class ShownSurface:
    """What a page shows of dots.

    Attributes
    ----------
    given : the dots that were given
    about : what the page says besides
    why : why the patches are those of another surface
    surface : the dots that are drawn
    whole : the surface whose patches tell the roughness, and in it the dots that are drawn; None if patches would be fragmented
    kept : the dots of `surface` that are marked
    values : (N,) numbers that give colours, if there are any
    roughness : (N,) R_i of the drawn dots; None if it follows from them alone
    roughness_of_whole : (M,) of all dots of `whole`, where some of them are drawn; else None
    distance : Å, between the dots that are drawn of a large surface; 0 for others
    """

    given: Surface
    about: About
    why: str
    surface: Surface
    whole: WholeSurface | None
    kept: np.ndarray
    values: np.ndarray | None
    roughness: np.ndarray | None
    roughness_of_whole: np.ndarray | None = None
    distance: float = 0.0

    @property
    def is_reconstructed(self) -> bool:
        """Whether the drawn surface was made from the given dots."""
        return self.surface is not self.given and not self.distance

    @property
    def part_of(self) -> WholeSurface | None:
        """The surface that the drawn dots are all of, or a part of, by their atoms."""
        return self.whole if self.surface.origin is not None and not self.about.is_whole else None

    @cached_property
    def stands_for_whole(self) -> bool:
        """Whether areas and means of the page are those of the whole surface, as of a subset or of a large surface."""
        return self.distance > 0 or (self.part_of is not None and self.part_of.is_owned_by(self.surface))

    @property
    def is_selection(self) -> bool:
        """Whether the dots are those of some residues, say, of a surface."""
        return self.part_of is not None and not self.stands_for_whole

    @cached_property
    def components(self) -> np.ndarray | None:
        """The component of each drawn dot, where it is known."""
        whole, surface = self.whole, self.surface
        if whole is not None and (self.distance or whole.surface is surface) and whole.components is not None:
            return whole.components[whole.nearest]
        return surface.placed.components(surface) if surface.placed else stored_components(surface)

    @cached_property
    def cavity(self) -> np.ndarray | None:
        """Whether each drawn dot lies on the wall of a cavity, where that is known."""
        if self.whole is not None and self.roughness_of_whole is not None:
            return self.whole.cavity[self.whole.nearest]
        return None if self.components is None else on_cavities(self.surface, self.components)

    def with_roughness(self, table: pd.DataFrame) -> pd.DataFrame:
        """Return the table of residues of the drawn dots, with the roughness of their residues on the whole surface."""
        if self.whole is None or self.roughness_of_whole is None:
            return table
        molecule, has_all = self.surface.known_molecule("show"), self.distance > 0
        return self.whole.with_roughness(
            table, self.roughness_of_whole, molecule, self.stands_for_whole, has_all
        )

    @property
    def extent(self) -> Extent:
        """How much of their surface the given dots are."""
        from sparsurf.views.page.page import Extent

        surface, whole, cavity = self.given, self.part_of, self.cavity
        if whole is None:
            area = surface.total_area  # NaN where areas are not known
            walls = surface.area_of_walls(cavity) if cavity is not None else 0.0
            volume = _volume(surface) if self.about.is_whole else ""
            return Extent(area, walls, is_known=self.about.is_whole, volume=volume)
        is_removed = surface.origin is not None and surface.origin.rules.cavities == "remove"
        if whole.is_owned_by(surface):  # a coarse mesh has a smaller area than the surface that it stands for
            area, walls = whole.surface.total_area, whole.surface.area_of_walls(whole.cavity)
            volume = _volume(whole.surface)
            return Extent(area, walls, is_known=True, cavities_are_removed=is_removed, volume=volume)
        return Extent(np.nan, selected_of=len(whole.surface))


def _volume(surface: Surface) -> str:
    """Return the exact volume and the handles of all dots of a surface, in words; empty where their atoms are not known."""
    if not surface.placed:
        return ""
    return volume_in_words(summarize_components(columns_of_components(surface)), "\N{NO-BREAK SPACE}Å³")


def shown_surface(
    given: Surface, about: About, patches: PatchesSettings, values: np.ndarray | None = None
) -> ShownSurface:
    """Choose what is shown of dots; of dots whose atoms are known, the roughness is that of the whole surface.

    Of other dots whose patches would be fragmented, the surface that is reconstructed from them is shown; it has no roughness
    where they are too few.
    """
    with heard("show") as messages:
        whole = _surface_of_patches(given, about, patches)
    kept, why = np.asarray(about.kept, dtype=int), " ".join(messages.sentences)
    shown = ShownSurface(given, about, why, given, whole, kept, values, about.roughness)
    if whole is None:  # patches would be fragmented
        return replace(shown, roughness=np.full(len(given), np.nan))
    distance = 0.0
    if whole.surface is given:
        distance = _distance_of_dots(given, about)
        if not distance:
            return shown
        whole = replace(whole, nearest=_fewer_dots(given, distance))
        chosen = None if values is None else values[whole.nearest]
        shown = replace(shown, surface=given.take(whole.nearest), whole=whole, values=chosen)
    elif given.origin is None:  # reconstructed from the dots, which come first
        further = np.full(len(whole.surface) - len(given), np.nan)
        return replace(
            shown,
            surface=whole.surface,
            kept=kept if len(kept) else whole.nearest,
            values=None if values is None else np.append(values, further),
            roughness=None,
        )
    of_whole = whole.roughness(patches)  # the patches of a part would end at its border
    return replace(shown, roughness=of_whole[whole.nearest], roughness_of_whole=of_whole, distance=distance)


def _distance_of_dots(surface: Surface, about: About) -> float:
    """Return the distance, Å, at which the picture of a whole surface keeps about `FEWER_DOTS` dots; 0 where it keeps all."""
    is_small = surface.molecule is None or len(surface) <= MAX_DOTS_OF_PICTURE
    if is_small or about.is_whole or len(about.kept):
        return 0.0
    return math.sqrt(DOTS_PER_SQUARED_DISTANCE * float(surface.area.sum()) / FEWER_DOTS)


def _fewer_dots(surface: Surface, distance: float) -> np.ndarray:
    """Choose dots that lie a distance apart, Å, and the first one of each residue: indices (n,), ascending."""
    molecule = surface.known_molecule("show")
    first = np.unique(molecule.residue_index[surface.atom], return_index=True)[1]
    order = np.concatenate([first, np.delete(np.arange(len(surface)), first)])
    return np.sort(select_separated(build_grid(surface.points), order, distance, len(order), len(first)))


def _surface_of_patches(surface: Surface, about: About, patches: PatchesSettings) -> WholeSurface | None:
    """Return the surface whose patches tell the roughness of dots; None, with a warning, if there is none."""
    if about.is_whole:
        return WholeSurface(surface, np.arange(len(surface)))
    return patches_or_none("show", surface, patches) if surface.origin is None else whole_surface(surface)
