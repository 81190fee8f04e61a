"""Relax kept dots: move them so that the surface recovered from them comes closer to all dots of the full one.

In each round, every dot of the full surface is assigned to the nearest kept dot, and its height above the surface around
that dot is computed. A plane is fitted to the heights of each kept dot by least squares. The kept dot moves along its normal,
and its normal tilts, by half of what the plane indicates. Nothing is random.
"""

import math

import numpy as np
from numba import njit

from sparsurf.recovery.interpolants import Interpolants, fit_interpolants, interpolant_value
from sparsurf.recovery.recovering import MIN_GRADIENT
from sparsurf.threads import parallel_map

ROUNDS = 8  # three give most of the gain, eight all of it
DAMPING = 0.5  # share of each step that is taken, as neighbours move at the same time
RIDGE = 0.02  # of the fit, relative to its constant term: a dot with few dots around it tilts little
CANDIDATES = 4  # nearest kept dots; a dot is assigned to the first of them on its side
MAX_HEIGHT = 1.0  # Å; a dot farther away belongs to another sheet
DOTS_PER_TASK = 4096


def relax(
    points: np.ndarray,
    normals: np.ndarray,
    all_points: np.ndarray,
    all_normals: np.ndarray,
    rounds: int = ROUNDS,
    threads: int = 1,
) -> tuple[np.ndarray, np.ndarray]:
    """Move kept dots to positions from which the surface is recovered better; fewer than four stay unchanged.

    `points` and `normals` are those of the kept dots, (n, 3), `all_points` and `all_normals` those of the full surface, in Å.
    """
    points, normals = np.array(points, float), np.array(normals, float)
    for _ in range(rounds if len(points) >= 4 else 0):
        functions = fit_interpolants(points, normals, threads)
        owner, height = _heights(functions, points, normals, all_points, all_normals, threads)
        valid = np.abs(height) < MAX_HEIGHT
        owner, height, owned_points = owner[valid], height[valid], all_points[valid]
        spacing = functions.spacing[functions.index.position]
        spacing = np.where(spacing > 0, spacing, np.inf)  # a dot without neighbours keeps its normal
        tangents = _tangents(normals)
        offset = np.einsum("jc,jkc->jk", owned_points - points[owner], tangents[owner]) / spacing[owner, None]
        lift, tilt = _fit_planes(owner, offset, height, len(points))
        points = points + DAMPING * lift[:, None] * normals
        normals = normals - DAMPING * np.einsum("ik,ikc->ic", tilt / spacing[:, None], tangents)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return points, normals


def _heights(
    functions: Interpolants,
    points: np.ndarray,
    normals: np.ndarray,
    all_points: np.ndarray,
    all_normals: np.ndarray,
    threads: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the kept dot to which every dot is assigned, (N,), and the height above the surface around it, (N,), Å."""
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

    near = np.asarray(cKDTree(points).query(all_points, k=min(CANDIDATES, len(points)), workers=threads)[1])
    same_side = np.einsum("jkc,jc->jk", normals[near], all_normals) > 0
    owner = near[np.arange(len(near)), np.argmax(same_side, axis=1)]
    height = np.where(same_side.any(axis=1), 0.0, np.inf)
    position = functions.index.position[owner]
    parallel_map(
        lambda begin, end: _add_heights(
            functions, position[begin:end], all_points[begin:end], height[begin:end]
        ),
        len(owner),
        threads,
        DOTS_PER_TASK,
    )
    return owner, height


@njit(cache=True, nogil=True)
def _add_heights(
    functions: Interpolants, position: np.ndarray, points: np.ndarray, height: np.ndarray
) -> None:
    """Add to `height` f over the length of its gradient, with the function of the kept dot at each position."""
    for j in range(len(points)):
        f, u, v, w = interpolant_value(functions, position[j], points[j, 0], points[j, 1], points[j, 2])
        height[j] += f / max(math.sqrt(u * u + v * v + w * w), MIN_GRADIENT)


def _tangents(normals: np.ndarray) -> np.ndarray:
    """Return two unit vectors perpendicular to each normal and to each other, (n, 2, 3)."""
    axis = np.where(np.abs(normals[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]])
    first = np.cross(normals, axis)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normals, first)], axis=1)


def _fit_planes(
    owner: np.ndarray, offset: np.ndarray, height: np.ndarray, n: int
) -> tuple[np.ndarray, np.ndarray]:
    """Fit a plane to the heights of each kept dot; return the height at the dot, (n,), and the slopes, (n, 2)."""
    columns = np.column_stack([np.ones(len(owner)), offset])
    matrix, right = np.zeros((n, 3, 3)), np.zeros((n, 3))
    for a in range(3):
        right[:, a] = np.bincount(owner, columns[:, a] * height, n)
        for b in range(3):
            matrix[:, a, b] = np.bincount(owner, columns[:, a] * columns[:, b], n)
    matrix += np.eye(3) * (RIDGE * matrix[:, :1, :1] + 1e-9)
    plane = np.linalg.solve(matrix, right[..., None])[..., 0]
    return plane[:, 0], plane[:, 1:]
