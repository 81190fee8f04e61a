"""Points by the published rule of dMaSIF (Sverrisson et al., CVPR 2021, Fig. 3), on a CPU; dMaSIF itself runs it on a GPU.

Its points lie on a level set of a smooth distance from the atoms. They are drawn around the atoms, descend to the level,
and are averaged in cubes. The values below are the defaults of its code.
"""

import math

import numpy as np

from sparsurf.kernels import njit
from sparsurf.surfaces.exact_distance import exact_distance
from sparsurf.surfaces.molecular_surface import roll_spheres
from sparsurf.surfaces.radii import PROBE_RADIUS

LEVEL, SMOOTHNESS, CUBE = 1.05, 0.5, 1.0  # Å
PER_ATOM, STEPS = 20, 4
WITHIN, OUTSIDE = (
    0.1,
    1.5,
)  # of the level: how near to it a point is kept, and how far out it must be after `STEPS` steps outwards
INWARD = 0.5  # Å, by which the points are moved in the end
FAR = 20.0  # Å beyond the nearest atom: the others weigh less than 1e-8
# Å, its radii of C, H, O, N, S by those of DMS
RADII = {1.90: 1.70, 1.20: 1.10, 1.40: 1.52, 1.50: 1.55, 1.85: 1.80}
SEED = 0


def points_of_dmasif(xyz: np.ndarray, radii: np.ndarray) -> tuple[np.ndarray, np.ndarray, None, None]:
    """Return points and normals on atoms with radii of DMS."""
    smoothness = SMOOTHNESS / RADII[1.20] * np.array([RADII.get(round(r, 2), RADII[1.90]) for r in radii])
    rng = np.random.default_rng(SEED)
    drawn = np.repeat(xyz, PER_ATOM, axis=0) + 10 * LEVEL * rng.normal(size=(PER_ATOM * len(xyz), 3))
    for _ in range(STEPS):
        distance, gradient = soft_distance(drawn, xyz, smoothness)
        drawn = drawn - (distance - LEVEL)[:, None] * gradient
    distance, gradient = soft_distance(drawn, xyz, smoothness)
    near = np.abs(distance - LEVEL) < WITHIN * LEVEL
    drawn, gradient = drawn[near], gradient[near]
    moved = drawn
    for _ in range(STEPS):
        moved = moved + LEVEL * unit(soft_distance(moved, xyz, smoothness)[1])
    drawn = drawn[soft_distance(moved, xyz, smoothness)[0] > OUTSIDE * LEVEL]
    _, cube, n = np.unique(np.floor(drawn / CUBE), axis=0, return_inverse=True, return_counts=True)
    points = np.zeros((len(n), 3))
    np.add.at(points, cube.ravel(), drawn)
    points /= n[:, None]
    normals = unit(soft_distance(points, xyz, smoothness)[1])
    return points - INWARD * normals, normals, None, None


def moved_points_of_dmasif(xyz: np.ndarray, radii: np.ndarray) -> tuple[np.ndarray, np.ndarray, None, None]:
    """Return the same points, moved along their normals by their mean distance from the solvent-excluded surface."""
    points, normals, *_ = points_of_dmasif(xyz, radii)
    offset = exact_distance(points, roll_spheres(xyz, radii, PROBE_RADIUS)).mean()
    return points - offset * normals, normals, None, None


def unit(vectors: np.ndarray) -> np.ndarray:
    """Return vectors (N, 3) divided by their lengths."""
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


@njit()
def soft_distance(
    points: np.ndarray, xyz: np.ndarray, smoothness: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the smooth distance of points from atoms, Eq. (1) of the paper, and its gradient (N, 3)."""
    distance, gradient, d = np.empty(len(points)), np.empty((len(points), 3)), np.empty(len(xyz))
    for i in range(len(points)):
        nearest, most = np.inf, -np.inf
        for a in range(len(xyz)):
            x, y, z = points[i, 0] - xyz[a, 0], points[i, 1] - xyz[a, 1], points[i, 2] - xyz[a, 2]
            d[a] = math.sqrt(x * x + y * y + z * z)
            nearest, most = min(nearest, d[a]), max(most, -d[a] / smoothness[a])
        weights = weighted = total = 0.0
        slopes = np.zeros((3, 3))  # of the three sums
        for a in range(len(xyz)):
            if d[a] > nearest + FAR:
                continue
            weight, share = math.exp(nearest - d[a]), math.exp(-d[a] / smoothness[a] - most)
            weights += weight
            weighted += smoothness[a] * weight
            total += share
            for c in range(3):
                towards = (points[i, c] - xyz[a, c]) / max(d[a], 1e-12)
                slopes[0, c] -= weight * towards
                slopes[1, c] -= smoothness[a] * weight * towards
                slopes[2, c] -= share / smoothness[a] * towards
        mean, logarithm = weighted / weights, most + math.log(total)
        distance[i] = -mean * logarithm
        for c in range(3):
            of_mean = (slopes[1, c] - mean * slopes[0, c]) / weights
            gradient[i, c] = -of_mean * logarithm - mean * slopes[2, c] / total
    return distance, gradient
