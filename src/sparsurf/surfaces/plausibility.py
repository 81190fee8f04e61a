"""Detect dots that cannot be those of a molecular surface in Å: wrong units, columns or rows exchanged, normals inwards."""

import logging
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sparsurf.errors import FILE, InputError
from sparsurf.molecules.plausibility import MAX_MOLECULE_GAP, widest_gap

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

log = logging.getLogger("sparsurf")

CHECKED_DOTS = 200  # dots that are compared with their nearest neighbours
MIN_DOTS_TO_JUDGE = 50  # smaller surfaces are not checked for plausibility
N_SURROUNDING, N_BESIDE = 40, 6  # nearest dots by which the inside of a surface, and its tangents, are found
N_FAR = 1000  # dots that stand for all others
SAME_DOT_PLACE = 1e-6  # Å
MAX_DOTS_IN_ONE_PLACE = 9
MAX_ALONE = 5  # distance to the nearest dot over its median: 1.6 on surfaces; beyond 5 for one random dot in 10 million
MAX_AREA_RATIO = 1.5  # of the sum of areas to its estimate, or the reverse: within .93 and 1.04 on surfaces of all densities
NEIGHBOUR_DISTANCE = 1.8  # Å; neighbours this close belong to the same part of a surface
MIN_SHARE_OF_ALIKE_NORMALS = 0.8  # neighbours with normals to one side: .97 on surfaces, .5 by chance
MIN_ALIKE_OF_DENSE, MIN_ALIKE_TO_REPORT = 0.85, 0.95  # the same of all that lie beside; .98 on dense surfaces
# Angles between normals of neighbouring dots, radians, below which directions are judged
DENSE_ANGLE, MEDIUM_ANGLE = 0.34, 0.5
# Å, radius of curvature: distance of neighbours over the angle between their normals.
# It is 1.5 to 2.3 on molecular surfaces of all densities.
MIN_CURVATURE_RADIUS, MAX_CURVATURE_RADIUS = 0.4, 10.0
# The same of surfaces with convex and concave parts: at most 2.7 Å with probes up to 3 Å and densities from 0.5 per Å^2 on
MOLECULAR_RADII = (1.2, 3.0)
# The share of convex neighbours on such surfaces; it is .43 to .68 on molecules.
SHARE_OF_CONVEX = (0.3, 0.8)
# Mean |cosine| between a normal and the directions to the neighbouring dots: .13 on dense surfaces, .33 on a subset of
# 5 %; .42 and more where columns are exchanged, axes mirrored, or positions inexact.
MAX_COSINE_OF_TANGENTS = 0.38
SHIFTS = (-3, -2, -1, 1, 2, 3)  # rows by which normals may have slipped
# Of that mean |cosine|, what is left of it if the normals have slipped: .8 and less; on true surfaces 1.3 and more
MAX_SHIFTED, MAX_COSINE_OF_SHIFTED = 0.9, 0.3
# Median of the sum of the winding numbers behind and before a dot: 1 if its normal is outward, -1 if inward
INWARD = -0.4
# A surface of this many dots this close (Å) is checked for being closed: 1 % of the normals of a whole
# surface do not cancel, of half a surface 7 % or more.
MAX_SPACING_OF_CLOSED, MIN_DOTS_OF_CLOSED = 0.8, 1000
MAX_NOT_CANCELLED = 3  # %


class Sample:
    """What is measured on a sample of n dots, each with the nearest others (n, k)."""

    def __init__(self, points: np.ndarray, normals: np.ndarray) -> None:
        # From all parts of the file, as errors often concern one part
        dots = np.linspace(0, len(points) - 1, CHECKED_DOTS).astype(int)
        tree = _tree(points)
        distances, around = _surrounding(tree, dots)
        neighbours = around[:, :N_BESIDE]
        steps, turns = (
            points[neighbours] - points[dots][:, None],
            normals[neighbours] - normals[dots][:, None],
        )
        directions = steps / np.maximum(np.linalg.norm(steps, axis=2), 1e-9)[:, :, None]
        cosine = (normals[neighbours] * normals[dots][:, None]).sum(axis=2)
        self.gap, self.dot_at_gap = widest_gap(points)  # width of the widest slab without dots, Å
        alone = np.asarray(tree.query(points, k=2)[0])[:, 1]  # distance of each dot to its nearest other one
        self.alone, self.alone_dot = float(alone.max()), int(alone.argmax())  # Å
        in_place = (distances < SAME_DOT_PLACE).sum(axis=1)
        self.most_in_place, self.crowded_dot = int(in_place.max()), int(dots[in_place.argmax()])
        self.spacing = float(np.median(distances[:, 0]))  # Å
        self.angle = math.acos(min(1.0, float(np.median(cosine[:, 0]))))  # between normals of neighbours
        self.radius = self.spacing / self.angle if self.angle > 0 else math.inf  # of curvature, Å
        self.alike_nearest, self.alike = float((cosine[:, 0] > 0).mean()), float((cosine > 0).mean())
        self.opposing = 100 * (1 - min(self.alike_nearest, self.alike))  # %
        self.opposing_beside = 100 * (1 - self.alike)  # % of all pairs
        convex = float(((turns * steps).sum(axis=2) > 0).mean())
        self.molecular = SHARE_OF_CONVEX[0] < convex < SHARE_OF_CONVEX[1] and self.angle < MEDIUM_ANGLE
        # mean |cosine| between directions to neighbours and normals, and normals of some rows further
        tilt = {shift: _tilt(normals[(dots + shift) % len(normals)], directions) for shift in (0, *SHIFTS)}
        shift = min(SHIFTS, key=tilt.__getitem__)
        self.tilt, self.shifted_tilt = tilt[0], tilt[shift]
        self.rows = f"{abs(shift)} row{'s' * (abs(shift) > 1)} further {'up' if shift > 0 else 'down'}"
        behind, before = _windings(points, normals, dots, distances, around)
        self.inside = float(np.median(behind + before))  # about 1 if normals are outward, -1 if inward
        self.dense = len(points) > MIN_DOTS_OF_CLOSED and self.spacing < MAX_SPACING_OF_CLOSED
        self.not_cancelled = 100 * float(np.linalg.norm(normals.mean(axis=0)))  # % of the normals


class DotCheck(NamedTuple):
    """What is wrong with dots: a sentence on a sample `s` and on one `dot`, which an attribute of the sample names."""

    is_wrong: Callable[[Sample], bool]
    sentence: str
    dot: str = ""
    refuse: bool = False  # or warn
    last: bool = False  # what follows would say it again


DOT_CHECKS = (  # The checks stand in the order in which they count.
    DotCheck(
        lambda s: s.gap > MAX_MOLECULE_GAP,
        "{dot} lies {s.gap:.0f} Å from all other dots: remove or repair it",
        "dot_at_gap",
        refuse=True,
    ),
    DotCheck(
        lambda s: s.most_in_place > MAX_DOTS_IN_ONE_PLACE or s.spacing < SAME_DOT_PLACE,
        "{dot} and others lie in one place; give each dot once",
        "crowded_dot",
        refuse=True,
    ),
    DotCheck(
        lambda s: (
            (s.spacing < NEIGHBOUR_DISTANCE and s.alike_nearest < MIN_SHARE_OF_ALIKE_NORMALS)
            or (s.angle < DENSE_ANGLE and s.alike < MIN_ALIKE_OF_DENSE)
        ),
        "{s.opposing:.0f} % of neighbouring dots have normals that oppose each other: give outward normals",
        refuse=True,
    ),
    DotCheck(
        lambda s: 0 < s.radius < MIN_CURVATURE_RADIUS,
        "dots lie {s.spacing:.3f} Å apart on curves of {s.radius:.2f} Å: the lengths seem to be in nm; convert them to Å",
        refuse=True,
    ),
    DotCheck(
        lambda s: s.shifted_tilt < min(MAX_COSINE_OF_SHIFTED, MAX_SHIFTED * s.tilt),
        "its normals fit the dots {s.rows}: write each dot and its normal in one row",
        refuse=True,
    ),
    DotCheck(
        lambda s: s.angle < MEDIUM_ANGLE and s.tilt > MAX_COSINE_OF_TANGENTS,
        "its normals are not perpendicular to the surface (mean cosine to neighbouring dots {s.tilt:.2f}): compare the order, "
        "signs and units of the columns x,y,z and nx,ny,nz",
        refuse=True,
    ),
    DotCheck(
        lambda s: s.angle < DENSE_ANGLE and s.alike < MIN_ALIKE_TO_REPORT,
        "{s.opposing_beside:.0f} % of neighbouring dots have normals that oppose each other; are all of them outward?",
    ),
    DotCheck(
        lambda s: (
            MAX_CURVATURE_RADIUS < s.radius < 10 * MAX_CURVATURE_RADIUS
            or (s.molecular and not MOLECULAR_RADII[0] < s.radius < MOLECULAR_RADII[1])
        ),
        "dots lie on curves of {s.radius:.2g} Å; are lengths in Å?",
    ),
    DotCheck(
        lambda s: s.alone > MAX_ALONE * s.spacing,
        "{dot} lies {s.alone:.1f} Å from the nearest other dot, where most lie {s.spacing:.1f} Å apart; is it misplaced?",
        "alone_dot",
    ),
    DotCheck(
        lambda s: s.inside < INWARD, "normals point inwards; the method needs outward normals", last=True
    ),
    DotCheck(
        lambda s: s.dense and s.not_cancelled > MAX_NOT_CANCELLED,
        "the dots do not close around a molecule ({s.not_cancelled:.0f} % of the normals do not cancel); is it cut short?",
        last=True,
    ),
)


def check_plausibility(points: np.ndarray, normals: np.ndarray, where: Callable[[int], str]) -> None:
    """Raise InputError, or warn, if dots (N, 3) cannot be those of a molecular surface in Å; `where` names a dot."""
    if len(points) > 1 and not np.ptp(points, axis=0).any():
        raise InputError(f"{FILE}: all its dots lie in one place; give the dots of a surface.")
    if len(points) < MIN_DOTS_TO_JUDGE:
        return
    sample = Sample(points, normals)
    for check in DOT_CHECKS:
        if not check.is_wrong(sample):
            continue
        dot = where(getattr(sample, check.dot)) if check.dot else ""
        sentence = check.sentence.format(s=sample, dot=dot)
        if check.refuse:
            raise InputError(f"{FILE}: {sentence}.")
        log.warning("%s: %s", FILE, sentence)
        if check.last:
            return


def areas_are_known(points: np.ndarray, area: np.ndarray, weighted: bool, judge: bool) -> bool:
    """Return whether areas are those of the dots: their sum is compared with an estimate from the spacing of some dots.

    Dots that are `weighted` may be crowded, and own more area than their spacing implies. Unless `judge`, nothing is compared.
    """
    if np.isnan(area).all():
        return False
    if not area.any():
        log.warning("%s: all areas are 0; they are estimated from the spacing of the dots", FILE)
        return False
    if not judge or len(points) < MIN_DOTS_TO_JUDGE:
        return True
    distances, _ = _surrounding(_tree(points), np.linspace(0, len(points) - 1, CHECKED_DOTS).astype(int))
    ratio = area.sum() / (len(points) * np.mean(np.pi * distances[:, N_BESIDE - 1] ** 2 / N_BESIDE))
    if ratio > MAX_AREA_RATIO and not weighted:
        raise InputError(
            f"{FILE}: its areas are {ratio:.2g} times as large as the spacing of its dots implies: give the area of each dot "
            "in Å^2, or none."
        )
    if ratio < 1 / MAX_AREA_RATIO:
        message = (
            "%s: its areas are %.2g times as large as the spacing of its dots implies; they are left out, and estimated where "
            "they are needed"
        )
        log.warning(message, FILE, ratio)
    return bool(ratio >= 1 / MAX_AREA_RATIO)


def _tree(points: np.ndarray) -> "cKDTree":
    """Return the search tree of all dots."""
    from scipy.spatial import cKDTree  # here: it takes long to load

    return cKDTree(points)


def _surrounding(tree: "cKDTree", sample: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the nearest other dots of a few dots: distances (n, k), ascending, and indices (n, k)."""
    k = min(N_SURROUNDING, tree.n - 1)
    distances, around = map(np.asarray, tree.query(tree.data[sample], k=k + 1))
    is_self = around == sample[:, None]
    is_self[~is_self.any(axis=1), -1] = True  # if dots coincide, another may stand for the dot itself
    shape = (len(sample), k)
    return distances[~is_self].reshape(shape), around[~is_self].reshape(shape)


def _tilt(normals: np.ndarray, directions: np.ndarray) -> float:
    """Compute the mean |cosine| between normals (n, 3) and directions (n, k, 3)."""
    return float(np.abs((directions * normals[:, None]).sum(axis=2)).mean())


def _windings(
    points: np.ndarray, normals: np.ndarray, sample: np.ndarray, distances: np.ndarray, around: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Compute the winding number of the surface behind and before a few dots, (n,) each: about 1 inside and 0 outside.

    The dots around each dot, see `_surrounding`, count one by one; of the others, N_FAR stand for all (Barill et al., ACM
    Trans. Graph. 37:43, 2018).
    """
    reach = distances[:, min(N_BESIDE, distances.shape[1]) - 1]
    area = float(np.median(np.pi * reach**2 / N_BESIDE))
    step = -(-len(points) // N_FAR)
    far = np.arange(0, len(points), step)
    beyond = np.linalg.norm(points[far] - points[sample][:, None], axis=2) > distances[:, -1:]
    near = np.column_stack([sample, around])

    def solid_angles(points_inside: np.ndarray, dots: np.ndarray) -> np.ndarray:
        rays = points[dots] - points_inside[:, None]
        cubes = np.maximum(np.linalg.norm(rays, axis=2), 1e-9) ** 3
        return (rays * normals[dots]).sum(axis=2) / cubes

    def winding(points_inside: np.ndarray) -> np.ndarray:
        far_angles = (solid_angles(points_inside, far) * beyond).sum(axis=1) * step
        return (solid_angles(points_inside, near).sum(axis=1) + far_angles) * area / (4 * np.pi)

    offset = reach[:, None] * normals[sample]
    return winding(points[sample] - offset), winding(points[sample] + offset)
