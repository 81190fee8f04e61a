"""The surface around each kept dot as a function that is 0 at its neighbours, with their normals as gradients.

Hermite interpolation with radial functions (Wu 1992; Macedo, Gois & Velho, Comput. Graph. Forum 30:27, 2011). Each kept
dot has one function, fitted to its neighbours, so that the cost is linear in the number of dots:

    f(x) = n_0 . d + c / 2 d . d + sum_j [a_j phi(|x - p_j|) - b_j . grad phi(|x - p_j|)],   d = x - p_0

The first two terms are the sphere through the dot with the mean curvature c of its neighbours. phi is Wendland's
function of compact support that is positive definite in three dimensions and four times differentiable (Adv. Comput. Math.
4:389, 1995), phi(t) = (1 - t)^6 (35 t^2 + 18 t + 3). Its support includes all pairs of neighbours. It then
differs little from polyharmonic splines, but the linear system can be solved by Cholesky's method.
"""

import math
from typing import NamedTuple

import numpy as np

from sparsurf.kernels import njit
from sparsurf.patches.index import PatchIndex, build_grid
from sparsurf.recovery.neighbours import local_spacing, nearest_on_same_side
from sparsurf.surfaces.vectors import point
from sparsurf.threads import parallel_map

# The dot itself counts. With 8 the error is a third larger, and with 24 a twentieth smaller
DOTS_OF_INTERPOLANT = 12
CLOSE_NEIGHBOURS = 8  # for close dots, see `fit_interpolants`
SUPPORT = 3.0  # of phi, in distances to the farthest neighbour; larger values do not change the error
SURFACE_RIDGE = 1e-5  # relative to the diagonal; keeps coincident dots from making the system singular
DOTS_PER_TASK = 512  # kept dots per task


class Interpolants(NamedTuple):
    """Functions f of all kept dots, by position in `index`, made by `fit_interpolants` and evaluated by `interpolant_value`."""

    index: PatchIndex  # type: ignore[assignment]  # hides tuple.index
    spacing: np.ndarray  # (n,) float64, Å
    count: np.ndarray  # type: ignore[assignment]  # hides tuple.count; (n,) int64, neighbours in use
    curvature: np.ndarray  # (n,) float64, c, in 1 / supports
    centre: np.ndarray  # (n, 3, k) float64, neighbours relative to their dot, in supports
    coefficient: np.ndarray  # (n, 4, k) float64, a_j and b_j, in supports
    support: np.ndarray  # (n,) float64, Å


def fit_interpolants(
    points: np.ndarray,
    normals: np.ndarray,
    threads: int = 1,
    neighbours: int = DOTS_OF_INTERPOLANT,
    close: float = 0.0,
) -> Interpolants:
    """Fit a function to the nearest dots of every dot (n >= 2), including itself, fewer where closer than `close` Å."""
    index, n, k = build_grid(points, normals), len(points), min(neighbours, len(points))
    near, distances = np.empty((n, k), np.int32), np.empty((n, k))
    box = np.maximum(np.ptp(index.xyz, axis=0), 1.0)
    # Where the search begins, and grows if it finds too few dots: the area of the box stands for that of the surface
    first = 1.5 * math.sqrt(2 * (box[0] * box[1] + box[1] * box[2] + box[2] * box[0]) / n)
    parallel_map(
        lambda begin, end: nearest_on_same_side(index, begin, end, first, near, distances),
        n,
        threads,
        DOTS_PER_TASK,
    )
    # At least a thousandth of an Å for dots that coincide, whose distances are 0
    support = SUPPORT * np.maximum(distances[:, -1], 1e-3)
    curvature, centre, coefficient = np.zeros(n), np.zeros((n, 3, k)), np.zeros((n, 4, k))
    count, spacing = (near >= 0).sum(axis=1), local_spacing(distances)
    count = np.where(spacing < close, np.minimum(count, CLOSE_NEIGHBOURS), count)
    parallel_map(
        lambda begin, end: _fit(index, begin, end, near, count, support, curvature, centre, coefficient),
        n,
        threads,
        DOTS_PER_TASK,
    )
    return Interpolants(index, spacing, count, curvature, centre, coefficient, support)


@njit()
def _fit(
    index: PatchIndex,
    begin: int,
    end: int,
    near: np.ndarray,
    count: np.ndarray,
    support: np.ndarray,
    curvature: np.ndarray,
    centre: np.ndarray,
    coefficient: np.ndarray,
) -> None:
    """Write curvature, centre and coefficient of the functions of a slice of positions."""
    k = near.shape[1]
    matrix, right = np.empty((4 * k, 4 * k)), np.empty(4 * k)
    for i in range(begin, end):
        m, s = count[i], support[i]
        top = bottom = 0.0
        for a in range(m):
            j = near[i, a]
            for c in range(3):
                centre[i, c, a] = (index.xyz[j, c] - index.xyz[i, c]) / s
                top += centre[i, c, a] * (index.normals[j, c] - index.normals[i, c])
                bottom += centre[i, c, a] ** 2
        curvature[i] = bend = top / max(bottom, 1e-12)
        for a in range(m):
            j = near[i, a]
            height = 0.0
            for c in range(3):
                x = centre[i, c, a]
                height += x * (index.normals[i, c] + 0.5 * bend * x)
                right[4 * a + 1 + c] = index.normals[j, c] - index.normals[i, c] - bend * x
            right[4 * a] = -height
            for b in range(a + 1):
                _write_block(centre[i], a, b, matrix)
            for c in range(4):
                matrix[4 * a + c, 4 * a + c] *= 1.0 + SURFACE_RIDGE
        _solve(matrix, right, 4 * m)
        for a in range(m):
            for c in range(4):
                coefficient[i, c, a] = right[4 * a + c]


@njit(inline="always")
def phi(r: float) -> tuple[float, float, float]:
    """Return Wendland's function at r (in supports), its derivative over r, and the derivative of that over r."""
    u = 1.0 - r if r < 1.0 else 0.0
    u4 = u * u * u * u
    return u4 * u * u * ((35.0 * r + 18.0) * r + 3.0), -56.0 * (1.0 + 5.0 * r) * u4 * u, 1680.0 * u4


@njit(inline="always")
def _write_block(centre: np.ndarray, a: int, b: int, matrix: np.ndarray) -> None:
    """Write the block of neighbours a and b into the lower triangle: value and gradient at a of the functions at b."""
    x, y, z = centre[0, a] - centre[0, b], centre[1, a] - centre[1, b], centre[2, a] - centre[2, b]
    f, g, h = phi(math.sqrt(x * x + y * y + z * z))
    p, q = 4 * a, 4 * b
    matrix[p, q], matrix[p, q + 1], matrix[p, q + 2], matrix[p, q + 3] = f, -g * x, -g * y, -g * z
    matrix[p + 1, q], matrix[p + 2, q], matrix[p + 3, q] = g * x, g * y, g * z
    matrix[p + 1, q + 1], matrix[p + 2, q + 2], matrix[p + 3, q + 3] = (
        -g - h * x * x,
        -g - h * y * y,
        -g - h * z * z,
    )
    matrix[p + 1, q + 2] = matrix[p + 2, q + 1] = -h * x * y
    matrix[p + 1, q + 3] = matrix[p + 3, q + 1] = -h * x * z
    matrix[p + 2, q + 3] = matrix[p + 3, q + 2] = -h * y * z


@njit()
def _solve(matrix: np.ndarray, right: np.ndarray, m: int) -> None:
    """Solve the system by Cholesky's method, in place on the lower triangle and in `right`; m is a multiple of four."""
    for i in range(0, m, 4):
        for j in range(i):  # four rows at once, so that each number of row j is read only once
            p, q, r, s = matrix[i, j], matrix[i + 1, j], matrix[i + 2, j], matrix[i + 3, j]
            for c in range(j):
                other = matrix[j, c]
                p -= matrix[i, c] * other
                q -= matrix[i + 1, c] * other
                r -= matrix[i + 2, c] * other
                s -= matrix[i + 3, c] * other
            inverse = matrix[j, j]  # the diagonal holds the inverse
            matrix[i, j], matrix[i + 1, j] = p * inverse, q * inverse
            matrix[i + 2, j], matrix[i + 3, j] = r * inverse, s * inverse
        for a in range(i, i + 4):
            for j in range(i, a + 1):
                total = matrix[a, j]
                for c in range(j):
                    total -= matrix[a, c] * matrix[j, c]
                matrix[a, j] = total * matrix[j, j] if j < a else 1.0 / math.sqrt(max(total, 1e-12))
    for i in range(m):
        total = right[i]
        for c in range(i):
            total -= matrix[i, c] * right[c]
        right[i] = total * matrix[i, i]
    for i in range(m - 1, -1, -1):
        right[i] *= matrix[i, i]
        for c in range(i):
            right[c] -= matrix[i, c] * right[i]


@njit()
def interpolant_value(
    functions: Interpolants, i: int, x: float, y: float, z: float
) -> tuple[float, float, float, float]:
    """Return f of the kept dot at position i, in Å, and its gradient, at a point (Å)."""
    index, s = functions.index, functions.support[i]
    x, y, z = (x - index.xyz[i, 0]) / s, (y - index.xyz[i, 1]) / s, (z - index.xyz[i, 2]) / s
    # whole arrays: a view of a row costs more than reading its numbers
    centre, c = functions.centre, functions.coefficient
    nx, ny, nz = point(index.normals, i)
    f = u = v = w = 0.0
    for a in range(centre.shape[2]):
        dx, dy, dz = x - centre[i, 0, a], y - centre[i, 1, a], z - centre[i, 2, a]
        p, g, h = phi(math.sqrt(dx * dx + dy * dy + dz * dz))
        along = c[i, 1, a] * dx + c[i, 2, a] * dy + c[i, 3, a] * dz
        f += c[i, 0, a] * p - g * along
        q = c[i, 0, a] * g - h * along
        u += q * dx - g * c[i, 1, a]
        v += q * dy - g * c[i, 2, a]
        w += q * dz - g * c[i, 3, a]
    bend = functions.curvature[i]
    f += x * (nx + 0.5 * bend * x) + y * (ny + 0.5 * bend * y) + z * (nz + 0.5 * bend * z)
    return s * f, u + nx + bend * x, v + ny + bend * y, w + nz + bend * z
