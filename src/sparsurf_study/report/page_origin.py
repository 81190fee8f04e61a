"""Where the pages of a surface are from: the dots of a study, with the atoms that they were placed on."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from sparsurf.api.about import About
from sparsurf.api.origin import OriginRow, rows_of_surface
from sparsurf.molecules.read_molecule import read_study_structure
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.surface import Surface, SurfaceOrigin

if TYPE_CHECKING:
    from sparsurf.settings import Settings


def with_atoms(dots: Surface, structure: str, settings: Settings) -> Surface:
    """Return dots that know the atoms of the structure that they were placed on; the dots as they are where there is none."""
    if not structure:
        return dots
    molecule = read_study_structure(structure)
    radii_of_atoms = radii(molecule, settings.surface.radii)
    origin = SurfaceOrigin.of_atoms(
        molecule, 0, molecule.xyz[0], settings.surface, settings.patches.d_link, radii_of_atoms
    )
    return replace(dots, origin=origin)


def origin_of_page(dots: Surface, file: str) -> tuple[OriginRow, ...]:
    """Return the rows of the origin of a page of dots `with_atoms`, which follow from its file alone: it has no date."""
    return rows_of_surface(About(files=(file,), is_dated=False), dots)
