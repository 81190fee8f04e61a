"""A dense surface from few dots with normals, and nothing else.

Around each kept dot a disc is laid on its tangent plane, as far as no other dot is nearer; its places are moved onto
the surface that `interpolants` puts through the dot and its neighbours, and thinned where two discs overlap.
"""

import math

import numpy as np
from numba import njit

from sparsurf.patches.index import ball, build_grid, select_separated
from sparsurf.recovery.interpolants import SLICE, fit, value
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.threads import parallel_map

# A farthest-point subset lies within 0.9 spacings of every dot; more only helps very uneven subsets
REACH = 1.0
STEPS = 4  # of Newton; two do on smooth surfaces, none needs more than four
SURPLUS = 1.3  # places laid per dot wanted: thinning takes what overlaps
LEAST = 10.0  # places per kept dot, so that gaps are found even between dots that are nearly dense enough
APART = 0.65  # least distance of a new dot from all others, in 1 / sqrt(density)
CELL = 1.0  # Å, side of the cells in which the dense dots are thinned
NEAR = 0.05  # Å; a point so near to the surface arrives with the next step
FLAT = 0.2  # a gradient shorter than this belongs to no surface: on it, it is 1
TIE = 0.95  # a place belongs to its own dot unless another is nearer by more than this
RIVALS = 64  # room for so many at first
GOLDEN = math.pi * (3 - math.sqrt(5))  # turn of a sunflower


def recover(points, normals, density=DENSITY, reach=REACH, steps=STEPS, threads=1, keep=True, close=0.0):
    """Dense dots of the surface that some of its dots, with their normals, describe.

    Parameters
    ----------
    points, normals : (n, 3) float64, Å and outward unit vectors
    density : float
        Dots per Å^2 requested; that of the full surface by default.
    reach : float
        How far from a kept dot the surface goes on, in the spacing of the dots around it.
    steps : int
        Newton's steps at most.
    threads : int
    keep : bool
        False leaves the kept dots themselves out: another set of dots of the same surface.
    close : float
        Å; dots whose spacing is below it take fewer neighbours, and places that would be thinned out are not laid: two
        thirds of the time, for nearly the same dots. 0: all dots are treated alike.

    Returns
    -------
    points, normals : (M, 3) float64; the kept dots first, unchanged, then those that fill the gaps between them.
    The same for any number of threads; fewer than four dots are returned alone.
    """
    points, normals = np.ascontiguousarray(points, float), np.ascontiguousarray(normals, float)
    n = len(points)
    if n < 4:
        return points.copy(), normals.copy()
    laid = _laid(points, normals, density, reach, steps, threads, close)
    n_kept = n if keep else 0
    all_points = np.concatenate([points[:n_kept], *(x for x, _ in laid)])
    all_normals = np.concatenate([normals[:n_kept], *(x for _, x in laid)])
    del laid  # memory is highest from here on
    index, n = build_grid(all_points, side=CELL), len(all_points)
    chosen = select_separated(index, np.arange(n), APART / math.sqrt(density), n, n_kept)
    return all_points[chosen], all_normals[chosen]


def _laid(points, normals, density, reach, steps, threads, close):
    """Points and normals around the kept dots, a pair for each slice of them."""
    functions, gap = fit(points, normals, threads, close=close), APART / math.sqrt(density) if close else 0.0
    return parallel_map(
        lambda a, b: _lay(functions, a, b, density, reach, steps, gap), len(points), threads, SLICE
    )


def spacing_of(points, normals):
    """Spacing of the dots around each, (n,) float64, Å, in which `reach` is counted; NaN for a single dot."""
    if len(points) < 2:
        return np.full(len(points), np.nan)
    functions = fit(points, normals)
    return functions.spacing[functions.index.position]


@njit(cache=True, nogil=True)
def _lay(functions, begin, end, density, reach, steps, gap=0.0):
    """Points and normals of the surface around the kept dots of a slice, each nearest to its own dot, and `gap` Å off."""
    index = functions.index
    per = np.empty(end - begin, np.int64)
    places = most = 0
    for i in range(begin, end):
        # places in a square of the spacing
        square = max(SURPLUS * density * functions.spacing[i] ** 2, LEAST)
        per[i - begin] = int(math.pi * reach**2 * square)
        places, most = places + per[i - begin], max(most, per[i - begin])
    points, normals = np.empty((places, 3)), np.empty((places, 3))
    turn, untaken = GOLDEN * np.arange(most), np.empty((most, 3))
    cosine, sine = np.cos(turn), np.sin(turn)
    found, rivals = np.empty(len(index.dot) + 1, np.int32), np.empty((3, RIVALS))
    m = 0
    for i in range(begin, end):
        x, y, z = index.xyz[i, 0], index.xyz[i, 1], index.xyz[i, 2]
        u, v = _tangents(index.normals[i])
        radius = reach * functions.spacing[i]
        rivals, n_rivals = _rivals(index, i, 2.0 * radius, found, rivals)
        nearest = int(per[i - begin] * gap**2 / max(radius**2, 1e-12)) + 1
        n = 0
        for k in range(nearest, per[i - begin]):
            r = radius * math.sqrt(k / per[i - begin])
            a, b = r * cosine[k], r * sine[k]
            px, py, pz = x + a * u[0] + b * v[0], y + a * u[1] + b * v[1], z + a * u[2] + b * v[2]
            untaken[n, 0], untaken[n, 1], untaken[n, 2] = px, py, pz
            n += 0 if _taken(rivals, n_rivals, px, py, pz, r) else 1
        m = _project(functions, i, untaken[:n], steps, 0.5 * radius, points, normals, m)
    return points[:m].copy(), normals[:m].copy()


@njit(cache=True, nogil=True)
def _tangents(n):
    """Two unit vectors perpendicular to the unit vector n and to each other."""
    sign = 1.0 if n[2] >= 0 else -1.0
    a = -1.0 / (sign + n[2])
    b = n[0] * n[1] * a
    return (1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]), (b, sign + n[1] * n[1] * a, -n[1])


@njit(cache=True, nogil=True)
def _rivals(index, i, radius, found, rivals):
    """Places (3, at least n) and number n of the dots within `radius` of position i that look the same way."""
    m = ball(index, index.xyz[i, 0], index.xyz[i, 1], index.xyz[i, 2], radius, found)
    if m > rivals.shape[1]:
        rivals = np.empty((3, 2 * m))
    n = 0
    for e in range(m):
        j = found[e]
        cosine = 0.0
        for c in range(3):
            cosine += index.normals[i, c] * index.normals[j, c]
        if j != i and cosine > 0.0:
            for c in range(3):
                rivals[c, n] = index.xyz[j, c]
            n += 1
    return rivals, n


@njit(cache=True, nogil=True)
def _taken(rivals, n_rivals, x, y, z, r):
    """Whether a rival is clearly nearer to a place than the dot at distance r."""
    least = (TIE * r) ** 2
    nearer = 0
    for e in range(n_rivals):  # all of them: faster than a loop that may end early
        gap = (rivals[0, e] - x) ** 2 + (rivals[1, e] - y) ** 2 + (rivals[2, e] - z) ** 2
        nearer += 1 if gap < least else 0
    return nearer > 0


@njit(cache=True, nogil=True)
def _project(functions, i, places, steps, longest, points, normals, m):
    """Write those of the places (n, 3) that arrive on f = 0 of the dot at position i, and the normals there, from row m on.

    Returns the row behind them.
    """
    for k in range(len(places)):  # in one call: handing over the functions takes as long as a step
        x, y, z = places[k, 0], places[k, 1], places[k, 2]
        f = g = u = v = w = 0.0
        for _ in range(steps):
            f, u, v, w = value(functions, i, x, y, z)
            g = math.sqrt(u * u + v * v + w * w)
            if g < FLAT:
                break
            along = min(max(f / g, -longest), longest) / g
            x, y, z = x - along * u, y - along * v, z - along * w
            if abs(f) < NEAR * g:
                break
        if g >= FLAT and abs(f) < NEAR * g:
            points[m, 0], points[m, 1], points[m, 2] = x, y, z
            normals[m, 0], normals[m, 1], normals[m, 2] = u / g, v / g, w / g
            m += 1
    return m
