"""The dense surface that a few dots with normals give back."""

from __future__ import annotations

import numpy as np

from sparsurf.api.inputs import DENSITY as DENSITIES
from sparsurf.api.inputs import DotsLike, Limits, as_dots
from sparsurf.recovery.fields import interpolate_fields
from sparsurf.recovery.recovering import NEWTON_STEPS, REACH
from sparsurf.recovery.recovering import recover as recovered_dots
from sparsurf.surfaces.components import fields_without_component
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.surfaces.surface import Surface
from sparsurf.threads import available_cores

REACHES = Limits(0, 10)  # spacings; at 20, dots lie 15 Å and more off the surface of a peptide
STEPS = Limits(0, 1000, whole=True)


def recover(
    few: DotsLike, *, density: float = DENSITY, reach: float = REACH, steps: int = NEWTON_STEPS
) -> Surface:
    """Place dense dots on the surface that a few dots with normals describe; nothing else is needed.

    Parameters
    ----------
    few : what `minimal` gave, a Surface of the few dots, the path of a file of them, or the pair (points, normals)
    density : float
        Dots per Å^2 requested.
    reach : float
        How far the surface goes on around a dot, in the spacing of the dots there. 2 closes holes between uneven dots;
        more places dots where no surface is.
    steps : int
        Largest number of Newton steps.

    Returns
    -------
    Surface
        The given dots first, unchanged, then those between them; with the fields of the few, interpolated.

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> dense = sparsurf.recover(dots[sparsurf.sample(dots, percent=10)])
    >>> len(dense)
    28436

    Their distance in Å from the nearest dot of the molecule, whose dots lie about 0.4 Å apart:

    >>> from scipy.spatial import cKDTree
    >>> distance = cKDTree(dots.points).query(dense.points)[0]
    >>> round(float(distance.mean()), 2)
    0.16
    """
    density, reach = DENSITIES.check(density, "density"), REACHES.check(reach, "reach")
    steps, kept = STEPS.check(steps, "steps"), as_dots(few)
    points, normals = recovered_dots(kept.points, kept.normals, density, reach, steps, available_cores())
    fields = fields_without_component(kept)
    between = interpolate_fields(kept.points, fields, points[len(kept) :])
    fields = {name: np.concatenate([fields[name], values]) for name, values in between.items()}
    return Surface(points, normals, fields=fields)
