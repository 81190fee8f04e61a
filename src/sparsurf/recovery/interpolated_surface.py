"""Place the dense dots of the surface that is interpolated between few dots with normals.

Around each kept dot, points are placed on the part of its tangent plane that is nearer to it than to other dots. They move
onto the surface that `interpolants` fits to the dot and its neighbours, and are thinned where they overlap.
"""

import math

import numpy as np

from sparsurf.kernels import njit
from sparsurf.patches.index import PatchIndex, ball, build_grid, select_separated
from sparsurf.recovery.interpolants import DOTS_PER_TASK, Interpolants, fit_interpolants, interpolant_value
from sparsurf.surfaces.decimation import GRID_STEP
from sparsurf.surfaces.grid_mesh import mesh_of_dense
from sparsurf.surfaces.mesh import Mesh
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.surfaces.vectors import point, set_point
from sparsurf.threads import parallel_map

# A farthest-point subset lies within 0.9 spacings of every dot; a larger reach only helps very uneven subsets.
REACH = 1.0
MIN_INTERPOLATED = 4  # dots; fewer span no surface
NEWTON_STEPS = 4  # two are enough on smooth surfaces, none needs more than four
SURPLUS = 1.3  # points placed per requested dot: thinning removes those that overlap
# In a square of the spacing, so that gaps are filled even between dots that are nearly dense enough
MIN_POINTS_PER_DOT = 10.0
MIN_DOT_SEPARATION = 0.65  # of a new dot from all others, in 1 / sqrt(density)
CELL = 1.0  # Å, side of the cells in which the dense dots are thinned
MAX_RESIDUAL = 0.05  # Å; a point this close to the surface has converged with the next step
MIN_GRADIENT = 0.2  # on the surface the length is 1; a point with a shorter gradient is not near the surface
# A point belongs to the dot it was placed around unless another is nearer by more than this factor
TIE = 0.95
FIRST_RIVALS = 64  # rivals for which memory is allocated at first
GOLDEN_ANGLE = math.pi * (3 - math.sqrt(5))  # between successive points, as in a sunflower


def recovered_mesh(
    points: np.ndarray,
    normals: np.ndarray,
    step: float = GRID_STEP,
    density: float = DENSITY,
    reach: float = REACH,
    steps: int = NEWTON_STEPS,
    threads: int = 1,
) -> Mesh:
    """Triangulate the surface that `recover` interpolates between dots, see `mesh_of_dense`."""
    return mesh_of_dense(*interpolate_surface(points, normals, density, reach, steps, threads), step, threads)


def interpolate_surface(
    points: np.ndarray,
    normals: np.ndarray,
    density: float = DENSITY,
    reach: float = REACH,
    steps: int = NEWTON_STEPS,
    threads: int = 1,
    keep: bool = True,
    close: float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Interpolate a dense surface between dots and normals, (n, 3) each, at `density` dots per Å^2: kept dots come first.

    The surface extends from a kept dot by `reach` times the spacing of the dots around it. Dots closer than `close` Å use fewer
    neighbours, and points that thinning would remove are not placed, in two thirds of the time. Without `keep`, the result is
    another set of dots of the same surface. Fewer than four dots are returned unchanged.
    """
    points, normals = np.ascontiguousarray(points, float), np.ascontiguousarray(normals, float)
    n = len(points)
    if n < MIN_INTERPOLATED:
        return points.copy(), normals.copy()
    discs = _discs(points, normals, density, reach, steps, threads, close)
    n_kept = n if keep else 0
    all_points = np.concatenate([points[:n_kept], *(disc_points for disc_points, _ in discs)])
    all_normals = np.concatenate([normals[:n_kept], *(disc_normals for _, disc_normals in discs)])
    del discs  # the peak of memory comes next
    # Kept dots come first and always stay, so that they are among the result
    index, n = build_grid(all_points, side=CELL), len(all_points)
    chosen = select_separated(index, np.arange(n), MIN_DOT_SEPARATION / math.sqrt(density), n, n_kept)
    return all_points[chosen], all_normals[chosen]


def _discs(
    points: np.ndarray,
    normals: np.ndarray,
    density: float,
    reach: float,
    steps: int,
    threads: int,
    close: float,
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return points and normals around the kept dots, a pair for each slice of them."""
    functions = fit_interpolants(points, normals, threads, close=close)
    gap = MIN_DOT_SEPARATION / math.sqrt(density) if close else 0.0
    return parallel_map(
        lambda begin, end: _place_discs(functions, begin, end, density, reach, steps, gap),
        len(points),
        threads,
        DOTS_PER_TASK,
    )


def dot_spacing(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Compute the spacing of the dots around each, the unit of `reach`: (n,) float64, Å; NaN for a single dot."""
    if len(points) < 2:
        return np.full(len(points), np.nan)
    functions = fit_interpolants(points, normals)
    return functions.spacing[functions.index.position]


@njit()
def _place_discs(
    functions: Interpolants,
    begin: int,
    end: int,
    density: float,
    reach: float,
    steps: int,
    gap: float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Place points, with normals, around the kept dots of a slice, at least `gap` Å from their dot and nearest to it."""
    index = functions.index
    per_dot = np.empty(end - begin, np.int64)
    total = largest = 0
    for i in range(begin, end):
        in_square = max(SURPLUS * density * functions.spacing[i] ** 2, MIN_POINTS_PER_DOT)
        per_dot[i - begin] = int(math.pi * reach**2 * in_square)
        total, largest = total + per_dot[i - begin], max(largest, per_dot[i - begin])
    points, normals = np.empty((total, 3)), np.empty((total, 3))
    turn, free = GOLDEN_ANGLE * np.arange(largest), np.empty((largest, 3))
    cosine, sine = np.cos(turn), np.sin(turn)
    nearby, rivals = np.empty(len(index.dot) + 1, np.int32), np.empty((3, FIRST_RIVALS))
    m = 0
    for i in range(begin, end):
        x, y, z = point(index.xyz, i)
        u, v = _tangents(index.normals[i])
        radius = reach * functions.spacing[i]
        # A rival farther away than twice the radius is nearer to no point of the disc
        rivals, n_rivals = _rivals(index, i, 2.0 * radius, nearby, rivals)
        first = int(per_dot[i - begin] * gap**2 / max(radius**2, 1e-12)) + 1
        n = 0
        for k in range(first, per_dot[i - begin]):
            r = radius * math.sqrt(k / per_dot[i - begin])
            a, b = r * cosine[k], r * sine[k]
            px, py, pz = x + a * u[0] + b * v[0], y + a * u[1] + b * v[1], z + a * u[2] + b * v[2]
            set_point(free, n, (px, py, pz))
            n += 0 if _nearer_to_rival(rivals, n_rivals, px, py, pz, r) else 1
        m = _project(functions, i, free[:n], steps, 0.5 * radius, points, normals, m)
    return points[:m].copy(), normals[:m].copy()


@njit()
def _tangents(n: np.ndarray) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Return two unit vectors perpendicular to the unit vector n and to each other."""
    # Duff et al., J. Comput. Graph. Tech. 6:1 (2017): no direction of n makes the denominator small
    sign = 1.0 if n[2] >= 0 else -1.0
    a = -1.0 / (sign + n[2])
    b = n[0] * n[1] * a
    return (1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]), (b, sign + n[1] * n[1] * a, -n[1])


@njit()
def _rivals(
    index: PatchIndex, i: int, radius: float, nearby: np.ndarray, rivals: np.ndarray
) -> tuple[np.ndarray, int]:
    """Return positions (3, at least n) and number n of the dots within `radius` of position i that face the same way."""
    m = ball(index, point(index.xyz, i), radius, nearby)
    if m > rivals.shape[1]:
        rivals = np.empty((3, 2 * m))
    n = 0
    for e in range(m):
        j = nearby[e]
        cosine = 0.0
        for c in range(3):
            cosine += index.normals[i, c] * index.normals[j, c]
        if j != i and cosine > 0.0:
            for c in range(3):
                rivals[c, n] = index.xyz[j, c]
            n += 1
    return rivals, n


@njit()
def _nearer_to_rival(rivals: np.ndarray, n_rivals: int, x: float, y: float, z: float, r: float) -> bool:
    """Return whether a rival is clearly nearer to a point than the dot at distance r."""
    least = (TIE * r) ** 2
    nearer = 0
    for e in range(n_rivals):  # all of them: faster than a loop that may end early
        distance2 = (rivals[0, e] - x) ** 2 + (rivals[1, e] - y) ** 2 + (rivals[2, e] - z) ** 2
        nearer += 1 if distance2 < least else 0
    return nearer > 0


@njit()
def _project(
    functions: Interpolants,
    i: int,
    starts: np.ndarray,
    steps: int,
    max_step: float,
    points: np.ndarray,
    normals: np.ndarray,
    m: int,
) -> int:
    """Move points (n, 3) onto f = 0 of dot i; write those that converge, with normals, from row m on; return the next row."""
    for k in range(len(starts)):  # in one call, since passing the functions takes as long as a step
        x, y, z = point(starts, k)
        f = g = u = v = w = 0.0
        for _ in range(steps):
            f, u, v, w = interpolant_value(functions, i, x, y, z)
            g = math.sqrt(u * u + v * v + w * w)
            if g < MIN_GRADIENT:
                break
            # Far from the dot the function is no distance, and a free step could reach another part of the surface
            along = min(max(f / g, -max_step), max_step) / g
            x, y, z = x - along * u, y - along * v, z - along * w
            if abs(f) < MAX_RESIDUAL * g:
                break
        if g >= MIN_GRADIENT and abs(f) < MAX_RESIDUAL * g:
            set_point(points, m, (x, y, z))
            set_point(normals, m, (u / g, v / g, w / g))
            m += 1
    return m
