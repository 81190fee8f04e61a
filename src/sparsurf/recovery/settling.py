"""Kept dots moved off their places, so that the surface recovered from them comes nearer to all dots of the full one.

In each round the full surface's dots tell how far they lie above the surface recovered so far, each to the kept dot nearest to
it; a plane is fitted to these heights by least squares, and the kept dot is moved along its normal, and its normal tilted, by
half of what the plane says. Nothing is drawn at random.
"""

import math

import numpy as np
from numba import njit
from scipy.spatial import cKDTree

from sparsurf.recovery.interpolants import fit, value
from sparsurf.recovery.recovering import FLAT
from sparsurf.threads import parallel_map

ROUNDS = 8  # after three most is gained, after eight all
DAMPED = 0.5  # share of each step: neighbours move at the same time
RIDGE = 0.02  # of the weight of a dot's own place: few dots around do not tilt it far
NEAREST = 4  # kept dots among which the first on the same side is a dot's own
WILD = 1.0  # Å; a dot farther off than this belongs to another sheet
SLICE = 4096  # dots per task


def settle(points, normals, all_points, all_normals, rounds=ROUNDS, threads=1):
    """Kept dots at better places.

    Parameters
    ----------
    points, normals : (n, 3) float64, of the kept dots, Å and unit vectors
    all_points, all_normals : (N, 3) float64, of the full surface
    rounds, threads : int

    Returns
    -------
    points, normals : (n, 3) float64; as they were for fewer than four dots.
    """
    points, normals = np.array(points, float), np.array(normals, float)
    for _ in range(rounds if len(points) >= 4 else 0):
        functions = fit(points, normals, threads)
        place = functions.index.position
        own, height = _heights(functions, points, normals, all_points, all_normals, threads)
        known = np.abs(height) < WILD
        own, height, seen = own[known], height[known], all_points[known]
        spacing = functions.spacing[place]
        spacing = np.where(spacing > 0, spacing, np.inf)  # a dot without neighbours keeps its normal
        across = _tangents(normals)
        aside = np.einsum("jc,jkc->jk", seen - points[own], across[own]) / spacing[own, None]
        lift, tilt = _planes(own, aside, height, len(points))
        points = points + DAMPED * lift[:, None] * normals
        normals = normals - DAMPED * np.einsum("ik,ikc->ic", tilt / spacing[:, None], across)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return points, normals


def _heights(functions, points, normals, all_points, all_normals, threads):
    """The kept dot of every dot, (N,), and how far the dot lies above the surface around that, (N,), Å."""
    near = cKDTree(points).query(all_points, k=min(NEAREST, len(points)), workers=threads)[1]
    alike = np.einsum("jkc,jc->jk", normals[near], all_normals) > 0
    own = near[np.arange(len(near)), np.argmax(alike, axis=1)]
    height = np.where(alike.any(axis=1), 0.0, np.inf)
    at = functions.index.position[own]
    parallel_map(
        lambda a, b: _above(functions, at[a:b], all_points[a:b], height[a:b]), len(own), threads, SLICE
    )
    return own, height


@njit(cache=True, nogil=True)
def _above(functions, at, places, height):
    """Add to `height` f over the length of its gradient, of the kept dot at each position."""
    for j in range(len(places)):
        f, u, v, w = value(functions, at[j], places[j, 0], places[j, 1], places[j, 2])
        height[j] += f / max(math.sqrt(u * u + v * v + w * w), FLAT)


def _tangents(normals):
    """Two unit vectors perpendicular to each normal and to each other, (n, 2, 3)."""
    axis = np.where(np.abs(normals[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]])
    first = np.cross(normals, axis)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normals, first)], axis=1)


def _planes(own, aside, height, n):
    """Height at the dot, (n,), and slopes, (n, 2), of the plane through the heights that belong to each kept dot."""
    columns = np.column_stack([np.ones(len(own)), aside])
    square, right = np.zeros((n, 3, 3)), np.zeros((n, 3))
    for a in range(3):
        right[:, a] = np.bincount(own, columns[:, a] * height, n)
        for b in range(3):
            square[:, a, b] = np.bincount(own, columns[:, a] * columns[:, b], n)
    square += np.eye(3) * (RIDGE * square[:, :1, :1] + 1e-9)
    plane = np.linalg.solve(square, right[..., None])[..., 0]
    return plane[:, 0], plane[:, 1:]
