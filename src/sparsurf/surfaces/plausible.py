"""Whether dots and normals can be those of a molecular surface in Å: units, directions, closedness."""

import logging
import math

import numpy as np

from sparsurf import InputError
from sparsurf.molecules.geometry import APART, widest_gap

log = logging.getLogger("sparsurf")

FARTHEST = 2e6  # Å; atoms lie within half of it, a damaged number does not
LARGEST = 1.3e5  # Å^2, the whole of the largest sphere (100 Å)
UNLIKE = 1000  # times the median area; areas of one surface differ by 10
SAMPLE = 200  # dots that are compared with their nearest neighbours
FEWEST = 50  # dots of a surface that is judged
CLOSE = 1.8  # Å, neighbours that belong to the same part of a surface; a twentieth of the dots lies so close
ALIKE = 0.8  # share of neighbours whose normals point to one side; .97 and more on surfaces, .5 by chance
# Å, distance of neighbours by the angle between their normals: 1.5 to 2.3 on molecular surfaces of all densities
ROUNDEST, FLATTEST = 0.4, 10.0
DENSE, MANY = (
    0.8,
    1000,
)  # Å, and dots: of such a surface the normals cancel to .01, of a half of it to .07 or more
OPEN = 0.03


def refuse_implausible(points, normals, path, where):
    """Raise InputError, or warn, where dots are not those of a molecular surface in Å.

    Parameters
    ----------
    points, normals : (N, 3) float, finite
    path : named in messages
    where : function of the index of a dot, how a message calls it
    """
    if len(points) < FEWEST:
        return
    gap, dot = widest_gap(points)
    if gap > APART:
        raise InputError(f"{path}: {where(dot)} lies {gap:.0f} Å from all other dots: remove or repair it.")
    some = np.linspace(0, len(points) - 1, SAMPLE).astype(int)
    distance, other = nearest_of(points, some)
    cosine = (normals[some] * normals[other]).sum(axis=1)
    spacing, alike = float(np.median(distance)), float((cosine > 0).mean())
    if spacing < CLOSE and alike < ALIKE:
        raise InputError(
            f"{path}: {1 - alike:.0%} of neighbouring dots have normals that oppose each other: give outward normals."
        )
    bend = math.acos(min(1.0, float(np.median(cosine))))
    radius = spacing / bend if bend > 0 else math.inf
    if 0 < radius < ROUNDEST:
        raise InputError(
            f"{path}: dots lie {spacing:.3f} Å apart on curves of {radius:.2f} Å: lengths seem to be nm, give Å."
        )
    if FLATTEST < radius < 10 * FLATTEST:
        log.warning("%s: dots lie on curves of %.0f Å; are lengths in Å?", path, radius)
    if len(points) > MANY and spacing < DENSE:
        _warn_of_open(points, normals, path)


def _warn_of_open(points, normals, path):
    rest = np.linalg.norm(normals.mean(axis=0))
    if rest > OPEN:
        message = "%s: the dots do not close around a molecule (%.0f %% of the normals do not cancel); is it cut short?"
        log.warning(message, path, 100 * rest)
    elif ((points - points.mean(axis=0)) * normals).sum() < 0:
        log.warning("%s: normals point inwards; the method wants them outwards", path)


def nearest_of(points, some):
    """Distance from the dots of index `some` to their nearest other dot, and its index, without a kernel."""
    distances, others = np.empty(len(some)), np.empty(len(some), int)
    for n, i in enumerate(some):
        squared = ((points - points[i]) ** 2).sum(axis=1)
        squared[i] = np.inf
        others[n] = squared.argmin()
        distances[n] = math.sqrt(squared[others[n]])
    return distances, others


def number_of_dot(dot):
    """How messages call a dot of which no line is known."""
    return f"dot {dot + 1}"


def refuse_impossible_values(points, area, kind, atom, path, where):
    """Raise InputError where a value of a dot, called `where(its index)`, cannot be; kind and atom may be None."""
    area, kind, atom = (
        np.asarray(np.full(len(points), default) if value is None else value, float)
        for value, default in ((area, np.nan), (kind, -1), (atom, -1))
    )
    unknown = np.isnan(area)
    usual = np.median(area) if len(area) >= FEWEST and not unknown.any() else 0
    largest = min(LARGEST, UNLIKE * usual or LARGEST)
    wrong = {
        f"a coordinate beyond {FARTHEST:.0e} Å": (np.abs(points) >= FARTHEST).any(axis=1),
        "an area that is NaN, unlike others": unknown & (not unknown.all()),
        "a negative area": area < 0,
        f"an area above {largest:.3g} Å^2": area > largest,
        "a kind other than 0, 1 or 2 (-1: unknown)": ~np.isin(kind, range(-1, 3)),
        "an atom that is no index": ~((atom >= -1) & (atom % 1 == 0)),
    }
    for what, rows in wrong.items():
        if rows.any():
            dot = int(np.argmax(rows))
            value = points[dot] if "coordinate" in what else None
            raise InputError(f"{path}: {where(dot)} has {what}{_of(value)}: repair or remove it.")


def _of(place):
    return "" if place is None else " (" + ", ".join(f"{x:g}" for x in place) + ")"
