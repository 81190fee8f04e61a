"""The reading `recovered`, which reconstructs a dense surface from the kept dots, and the readings that a table has."""

from __future__ import annotations

import math
from collections.abc import Container
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from sparsurf import registry
from sparsurf.arguments import D_LINK
from sparsurf.patches.readings import Reading
from sparsurf.surfaces.surface import DENSITY

if TYPE_CHECKING:
    from sparsurf.patches.index import PatchIndex

RECOVERED = "recovered"
DENSITY_TOLERANCE = 1.05  # a surface generated at DENSITY has up to 2 % more dots, which does not matter
# In spacings of the full surface: for closer dots, using fewer neighbours changes Z by less than 0.005.
CLOSE_SPACINGS = 2.0


def recovered_index(
    points: np.ndarray,
    normals: np.ndarray,
    d_link: float,
    area: float,  # noqa: ARG001
    density: float,
    close: float = 0.0,
) -> PatchIndex:
    """Index the surface reconstructed from kept dots at the density of the full surface; `close` is in spacings of that."""
    # here: pages need the names of the readings, but no kernel
    from sparsurf.patches.index import build_index
    from sparsurf.recovery.interpolated_surface import interpolate_surface

    density = comparable_density(density, d_link)
    return build_index(
        *interpolate_surface(points, normals, density, close=close / math.sqrt(density)), d_link
    )


def comparable_density(density: float, d_link: float = D_LINK) -> float:
    """Return the density (dots per Å^2) at which a surface is reconstructed for comparison with a full one.

    The descriptor of a patch depends on it: against 20 dots per Å^2, Z is 1.8 times the noise floor at 5.35, 1.2 times at 20.
    """
    # A shorter link needs more dots, or each patch of the reconstructed surface would be fragmented
    least = DENSITY * max(1.0, (D_LINK / d_link) ** 2)
    return density if density > DENSITY_TOLERANCE * least else least


ON_RECOVERED = Reading(
    build_index=recovered_index, build_approximate_index=partial(recovered_index, close=CLOSE_SPACINGS)
)


def readings_of_columns(names: Container[str], start: str = "") -> list[str]:
    """Return the readings, in their order, for which `names` contains `start` followed by the reading."""
    return [reading for reading in registry.TABLE["reading"] if start + reading in names]
