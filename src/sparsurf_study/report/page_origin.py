"""Where the pages of a surface are from: the dots of a study, with the atoms that they were placed on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sparsurf.api.origin import OriginRow, rows_of_surface
from sparsurf.api.page_metadata import About
from sparsurf.surfaces.molecular_surface import as_placed
from sparsurf_study.structures import read_study_structure

if TYPE_CHECKING:
    from sparsurf.settings import Settings
    from sparsurf.surfaces.surface import Surface


def with_atoms(dots: Surface, structure: str, settings: Settings) -> Surface:
    """Return dots with the structure that they were placed on, so that areas are exact; the dots as they are without one."""
    if not structure:
        return dots
    return as_placed(dots, read_study_structure(structure), settings.surface, settings.patches.d_link)


def origin_of_page(dots: Surface, file: str) -> tuple[OriginRow, ...]:
    """Return the rows of the origin of a page of dots `with_atoms`, which follow from its file alone: it has no date."""
    return rows_of_surface(About(files=(file,), is_dated=False), dots)
