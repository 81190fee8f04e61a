"""Every reading: those of one surface, and `recovered`, whose kept dots are made a dense surface again."""

from sparsurf.patches import readings
from sparsurf.patches.index import D_LINK, build_index
from sparsurf.recovery.recovering import recover
from sparsurf.surfaces.spacing import DENSITY

RECOVERED = "recovered"


def recovered(points, normals, d_link, area):
    """Index of the surface recovered from kept dots; as dense as `d_link` (Å) needs, whatever the `area`."""
    density = DENSITY * max(1.0, (D_LINK / d_link) ** 2)
    return build_index(*recover(points, normals, density), d_link)


READINGS = readings.READINGS | {
    RECOVERED: readings.Reading("the surface recovered from the kept dots alone", alone=recovered)
}


def readings_in(names, start=""):
    """The readings, in their order, that `names` has: of the columns of a table those called `start` and a reading."""
    return [reading for reading in READINGS if start + reading in names]
