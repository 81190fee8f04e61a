"""Every reading: those of one surface, and `recovered`, whose kept dots are made a dense surface again."""

import math
from functools import partial

from sparsurf.patches import readings
from sparsurf.patches.index import D_LINK, build_index
from sparsurf.recovery.recovering import recover
from sparsurf.surfaces.spacing import DENSITY

RECOVERED = "recovered"
DENSER = 1.05  # a surface laid at DENSITY has up to 2 % more dots, which make no difference
CLOSE = 2.0  # spacings of the full surface: up to there, fewer neighbours change Z by less than .005


def recovered(points, normals, d_link, area, density, close=0.0):
    """Index of the surface recovered from kept dots, as dense as the full one (`density`), whatever the `area`.

    `close` is that of `recover`, in spacings of the full surface.
    """
    density = fair_density(density, d_link)
    return build_index(*recover(points, normals, density, close=close / math.sqrt(density)), d_link)


def fair_density(density, d_link=D_LINK):
    """Dots per Å^2 at which a surface is recovered that is compared with one of `density`, linked within `d_link` (Å).

    Dots that are fewer per Å^2 describe a patch otherwise: against 20 per Å^2, Z of a surface recovered at 5.35 is 1.8 times
    the floor, at 20 it is 1.2 times.
    """
    least = DENSITY * max(1.0, (D_LINK / d_link) ** 2)
    return density if density > DENSER * least else least


OF_MANY = partial(recovered, close=CLOSE)
READINGS = readings.READINGS | {
    RECOVERED: readings.Reading("recovered", build_index=recovered, build_index_fast=OF_MANY)
}


def readings_in(names, start=""):
    """The readings, in their order, that `names` has: of the columns of a table those called `start` and a reading."""
    return [reading for reading in READINGS if start + reading in names]
