"""Readings of the paper's instruction that 'the points not connected are removed'.

Most readings decide which dots of the one surface form a patch's island. A reading with `build_index` makes a separate
surface from the kept dots only, and its whole patches are described. `registry` lists all readings, and `recovery.readings` holds
the one that reconstructs a surface.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from sparsurf import registry

if TYPE_CHECKING:
    from sparsurf.patches.index import PatchIndex

ReadingLike: TypeAlias = "str | Callable[..., PatchIndex]"
# A subset is fragmented if the island of its median patch has less than this share of the kept dots. At one half, the linking
# distance is about as long as the mean spacing of the kept dots (.96 to 1.05 of it), where random dots begin to link everywhere.
FRAGMENTED_BELOW = 0.5
# Linking distance of the reading 'kept_scaled', in mean spacings of the kept dots. Random dots form one island over the whole
# surface above 1.2, but their patches still lose a quarter of their dots there, and 3 % at 1.6.
SCALED_LINK = 1.6


@dataclass(frozen=True)
class Reading:
    """One reading of where all but the largest island of a patch are removed."""

    # Whether the largest island is that of the kept dots; otherwise it is that of the full surface
    among_kept: bool = False
    # From points and normals of the kept dots, d_link, and area and density of the full surface (Å, Å^2, dots per Å^2) to
    # the index of the surface that the kept dots form by themselves. A grid has thousands of subsets, for which a faster
    # function with a larger error may stand.
    build_index: Callable[..., PatchIndex] | None = None
    build_approximate_index: Callable[..., PatchIndex] | None = None


def linked_by_spacing(
    points: np.ndarray,
    normals: np.ndarray,
    d_link: float,
    area: float,
    density: float | None = None,  # noqa: ARG001
) -> PatchIndex:
    """Link kept dots within SCALED_LINK times their mean spacing on a full surface of `area` Å², and at least `d_link` Å."""
    from sparsurf.patches.index import build_index  # here: pages need names of readings, no kernel

    return build_index(points, normals, max(d_link, SCALED_LINK * np.sqrt(area / len(points))))


AMONG_KEPT = Reading(among_kept=True)
SCALED = Reading(build_index=linked_by_spacing)
ON_FULL = Reading()
KEPT_READING = "kept"  # The reading of the authors' code, and of Table I.
SCALED_READING = "kept_scaled"
FULL_READING = "full"
# These decide which dots of one surface form a patch, so that one pass computes them together
GRID_READINGS = (KEPT_READING, FULL_READING)


def reading_of(value: ReadingLike) -> Reading:
    """Return the reading of a name, or of a function like `build_index`."""
    _, reading = registry.load("reading", value, "reading")
    return reading if isinstance(reading, Reading) else Reading(build_index=reading)


def words_of(name: str) -> str:
    """Return the name of a reading in tables and figures."""
    return registry.label("reading", name)
