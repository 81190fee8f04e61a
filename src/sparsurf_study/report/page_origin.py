"""Where the pages of a surface are from: the dots of a study, with the atoms that they were placed on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sparsurf.api.origin import OriginRow, rows_of_surface
from sparsurf.api.page_metadata import About
from sparsurf.evaluation.minimal_subset import on_molecule
from sparsurf_study.structures import read_study_structure

if TYPE_CHECKING:
    from sparsurf.settings import Settings
    from sparsurf.surfaces.surface import Surface


def with_atoms(dots: Surface, structure: str, settings: Settings) -> Surface:
    """Return dots that know the atoms of the structure that they were placed on; the dots as they are where there is none."""
    if not structure:
        return dots
    return on_molecule(dots, read_study_structure(structure), settings)


def origin_of_page(dots: Surface, file: str) -> tuple[OriginRow, ...]:
    """Return the rows of the origin of a page of dots `with_atoms`, which follow from its file alone: it has no date."""
    return rows_of_surface(About(files=(file,), is_dated=False), dots)
