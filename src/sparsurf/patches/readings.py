"""How 'the points not connected are removed' can be read: every reading once, with what makes it.

Most readings ask which dots of the one surface form a patch's island; one with `alone` makes a surface of its own from
the kept dots only, whose patches are then described whole. To add a reading, write one entry here, or, where it needs
recovery, in `recovery.readings`, which has them all.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sparsurf.patches.index import build_index

SCALE = 1.6  # linking distance of the reading 'scaled', in mean spacings of the kept dots


@dataclass(frozen=True)
class Reading:
    """One reading.

    words : str
        Its name in tables and figures.
    among_kept : bool
        Islands are removed among the kept dots; else once, on the full surface.
    alone : callable, optional
        (points, normals) of the kept dots, d_link, and area and density of the full surface, Å, Å^2 and dots per Å^2 ->
        Index of the surface that the kept dots make by themselves.
    of_many : callable, optional
        As `alone`, in less time and with a larger error: for the thousands of subsets of a grid.
    """

    words: str
    among_kept: bool = False
    alone: Callable | None = None
    of_many: Callable | None = None


def linked_by_spacing(points, normals, d_link, area, density=None, scale=SCALE):
    """Index of kept dots linked within `scale` times their mean spacing, 1 / sqrt(dots per Å^2), and at least D_link."""
    return build_index(points, normals, max(d_link, scale * np.sqrt(area / len(points))))


READINGS = {
    "as_coded": Reading("as coded", among_kept=True),
    "as_written": Reading("as written"),
    "scaled": Reading("scaled", alone=linked_by_spacing),
}
PUBLISHED = "as_coded"  # the authors' code, and Table I
TEXT = "as_written"  # the paper's text
OF_GRID = tuple(name for name, reading in READINGS.items() if not reading.alone)  # one pass serves them all
