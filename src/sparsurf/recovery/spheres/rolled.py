"""The surface that a probe rolls over inferred atoms, shut where atoms are missing.

The centres that the probe can take around a molecule are bounded by the atoms that it touches alone, so that no atom inside is
needed: around inferred atoms they fall into connected sets, and those on which probe centres of dots lie are those of the
molecule. Where an atom is missing, outside and inside are joined. No probe centre lies within a probe radius of a point on or
inside the surface, so that each dot that no atom explains, and each probe centre inside, is a ball that keeps the probe out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sparsurf.kernels import njit
from sparsurf.patches.index import PatchIndex, build_grid, select_separated
from sparsurf.recovery.spheres.explanations import touched_atoms
from sparsurf.recovery.spheres.inside import Inside
from sparsurf.surfaces.components import centres_apart_from
from sparsurf.surfaces.dot_placement import Dots, Rolled, place_dots, roll_probe
from sparsurf.surfaces.grid import columns_around, in_column
from sparsurf.surfaces.molecular_surface import lattice_of_density
from sparsurf.surfaces.vectors import point, squared_distance

# Å, by which the ball of a dot is smaller than the probe, which touches the dot: the rounding of a file
ROUNDING_OF_DOTS = 5e-4
# Å, between the probe centre of a dot and the sphere of an atom that it lies on; far above rounding, far below the distance
# between two sets of centres
ON_SPHERE = 2e-3
# Winding number above which a probe centre is inside: of true ones, the highest is 0.6, and where the probe leaks in, it is 0.9
INSIDE = 0.75
# Å, from the probe centre of a dot, which is outside: what is inside lies two probe radii away. Where concave parts are not
# trimmed, as in files of DMS, the winding number is wrong.
OUTSIDE = 1.0
# Å: the ball at a probe centre inside is so much smaller than its distance from the guide, which errs by less, in steps
MARGIN, STEP = 1.5, 0.25
SAME_PLACE = 1e-6  # Å, between probe centres of two rounds: far above rounding
BALL_GAP = 1.0  # Å, between balls at probe centres inside, so that few shut a leak
# Å, of a dot of the rolled surface from the guide: true ones lie within 1.8. Where dots are missing on one side of the molecule,
# the probe rolls inside, and what is farther away is left out.
FARTHEST_FROM_GUIDE = 2.0
ROUNDS_OF_BALLS = 6  # of balls inside; one or two shut all leaks that were seen


class RolledSurface(NamedTuple):
    """A probe rolled over inferred atoms and balls, on which dots of any density are placed."""

    rolled: Rolled
    centres: np.ndarray  # (S, 3) float64, Å, of the spheres: atoms, then balls
    radii: np.ndarray  # (S,) float64, Å
    n_atoms: int
    guide: PatchIndex

    def place(self, density: float) -> Dots:
        """Place dots at `density` per Å^2, those on balls included, which are numbered behind the atoms."""
        dots = place_dots(self.rolled, lattice_of_density(density))
        return dots.take(_are_near(self.guide, dots.points, FARTHEST_FROM_GUIDE))


def rolled_surface(
    probes: np.ndarray,
    centres: np.ndarray,
    radii: np.ndarray,
    unexplained: np.ndarray,
    depth: np.ndarray,
    probe: float,
    inside: Inside,
    guide: np.ndarray,
    exact: bool = True,
    threads: int = 1,
) -> RolledSurface:
    """Roll a probe over atoms (A, 3) with radii (A,), Å, where the probe centres (n, 3) of dots lie.

    No atom explains the dots `unexplained` (m, 3), which lie at a `depth` (m,), Å, in the probe of another dot, and `inside`
    knows what lies inside the surface of the dots `guide`.
    """
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

    spheres = np.concatenate([centres, unexplained])
    # so that no ball keeps the probe from where it lies at another dot
    sizes = np.concatenate([radii, -np.maximum(depth, 0) - ROUNDING_OF_DOTS])
    tree, outside = cKDTree(probes), np.empty((0, 3))
    before: Rolled | None = None
    for _ in range(ROUNDS_OF_BALLS):
        rolled = before = _roll_where_dots_lie(probes, spheres, sizes, probe, exact, before)
        found = rolled.rolling.probes[~rolled.left_out.probes] + rolled.origin
        # Only the sums of few places take time: of those that no other round, and no dot, tells to be outside
        for places, distance in ((tree, OUTSIDE), (cKDTree(outside), SAME_PLACE)):
            found = found[np.isinf(places.query(found, distance_upper_bound=distance)[0])]
        is_inside = inside.winding_numbers(found, threads) > INSIDE
        outside, found = np.concatenate([outside, found[~is_inside]]), found[is_inside]
        if len(found) == 0:
            break
        depth = np.asarray(cKDTree(guide).query(found)[0])
        order = np.argsort(-depth, kind="stable")
        grid = build_grid(found)
        chosen = select_separated(grid, order, BALL_GAP, len(found), 0)
        spheres = np.concatenate([spheres, found[chosen]])
        steps = np.floor(np.maximum(depth[chosen] - MARGIN, 0) / STEP)
        sizes = np.append(sizes, STEP * steps - ROUNDING_OF_DOTS)
    return RolledSurface(
        rolled, spheres, sizes, len(centres), build_grid(guide, side=FARTHEST_FROM_GUIDE / 2)
    )


def _roll_where_dots_lie(
    probes: np.ndarray,
    spheres: np.ndarray,
    sizes: np.ndarray,
    probe: float,
    exact: bool,
    before: Rolled | None,
) -> Rolled:
    """Roll a probe over spheres, and leave out the sets of its centres on which no probe centre of a dot lies."""
    rolled = roll_probe(spheres, sizes, probe, exact, before)
    rolling, places = rolled.rolling, probes - rolled.origin
    start, touched = touched_atoms(places, rolling.atoms.centre, rolling.atoms.reach, ON_SPHERE)
    return rolled._replace(left_out=centres_apart_from(rolling, places, start, touched))


@njit()
def _are_near(grid: PatchIndex, points: np.ndarray, distance: float) -> np.ndarray:
    """Return which points (n, 3) have a point of a grid within a distance, (n,) bool."""
    near = np.zeros(len(points), np.bool_)
    for i in range(len(points)):
        centre = point(points, i)
        for within in (0.5 * distance, distance):  # most have one nearby
            columns = columns_around(grid.lattice, centre, within)
            for c in range(columns.n):
                for q in in_column(grid.start, columns, c):
                    if squared_distance(point(grid.xyz, q), centre) < within * within:
                        near[i] = True
                        break
                if near[i]:
                    break
            if near[i]:
                break
    return near
