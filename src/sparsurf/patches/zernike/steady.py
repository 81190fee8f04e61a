"""The steady descriptor: a function of the surface alone, not of how the molecule lies nor of where its dots fell.

As published, a patch is turned with its mean normal to +z and seen as distances r to the apex of a cone; |c_nm| takes
away the turn about z. What differs, each with its reason:
- the disc is the ball of R_zernike, seen along the mean normal, and the apex lies sqrt(2) R_zernike below its middle,
  where the cone of 45 degrees just holds the ball: no single dot sets the frame;
- a dot's weight falls smoothly to 0 at the rim, so that none enters or leaves at once;
- it also goes with the cosine of its normal to z, which is the area seen from above: dots below an overhang do not count;
- r is no mean per pixel but a smooth field, its gaps filled from all sides at once, see `fields`;
- the field is interpolated and integrated over the disc, see `quadrature`.
What enters is r less that of the plane z = 0, whose coefficients are known: an empty region continues its surroundings.

A field, a number at each dot such as a potential, takes the place of r in the same image: `describe_fields`.
"""

import math
from functools import cache

import numpy as np
from numba import njit

from sparsurf.patches.zernike.fields import MIDDLE, SIDES, WIDE, bumps, fill, lay, widen
from sparsurf.patches.zernike.images import FAST
from sparsurf.patches.zernike.polynomials import N_MAX
from sparsurf.patches.zernike.quadrature import harmonics, points, quarters

STEPS = 11  # the disc's radius in steps of the grid: bumps then reach just beyond the outermost dot
FLOOR = 1e-3  # least weight of a dot: a patch of dots that all lie on the rim has a mean

N_PAIRS = 55  # coefficients with m even > 0, and as many with m odd
N_Z = 121


def describe(index, ids, start, centres, weights, radius, up):
    """Zernike invariants |c_nm| of patches; zero for a patch without dots.

    See `descriptors.Descriptor` for what is given and returned.
    """
    return _invariants(index, ids, start, centres, weights, radius, up, np.empty((0, 0)), radius * _plane())


def describe_fields(index, ids, start, centres, weights, radius, up, values):
    """The same invariants of images that hold fields in place of r.

    Parameters
    ----------
    values : (F, N) float64
        Fields at the dots, by position in the index; the other arguments are those of `describe`.

    Returns
    -------
    (P, F N_Z) float64, field after field, in the units of each; zero for a patch without dots
    """
    return _invariants(index, ids, start, centres, weights, radius, up, values, np.zeros(N_MAX // 2 + 1))


def _invariants(index, ids, start, centres, weights, radius, up, values, plane):
    """|c_nm| of the images of r (no `values`) or of fields, less `plane`, coefficients of what is known of them."""
    tables, n_images = quarters(STEPS), max(1, len(values))
    parts = np.empty((4, n_images * (len(start) - 1), len(tables.row)))
    sign = 1.0 if up else -1.0
    _parts(
        index.xyz, index.normals, ids, start, centres, weights, radius, sign, values, bumps().ravel(), tables.row, tables.column,
        parts,
    )  # fmt: skip
    out = np.empty((parts.shape[1], N_Z))
    cosines, sines = parts[0] @ tables.even[0], parts[1] @ tables.even[1]
    _moduli(cosines, sines, parts[2] @ tables.odd[0], parts[3] @ tables.odd[1], plane, start, n_images, out)
    return out.reshape(len(start) - 1, -1)


def order():
    """Place of each column of `describe` in `polynomials.indices()`."""
    return quarters(STEPS).order


@cache
def _plane():
    """c_n0 of r for the plane z = 0 and a disc of radius 1, (11,)."""
    x, y, weight = points()
    z = harmonics(x, y)[order()[2 * N_PAIRS :]].real
    return 4 * z @ (weight * np.sqrt(x * x + y * y + 2.0))


@njit(cache=True, nogil=True, fastmath=FAST)
def _moduli(even_cos, even_sin, odd_cos, odd_sin, plane, start, n_images, out):
    for i in range(len(out)):
        if start[i // n_images + 1] == start[i // n_images]:
            out[i] = 0.0
            continue
        for k in range(N_PAIRS):
            out[i, k] = math.sqrt(even_cos[i, k] ** 2 + even_sin[i, k] ** 2)
            out[i, N_PAIRS + k] = math.sqrt(odd_cos[i, k] ** 2 + odd_sin[i, k] ** 2)
        for k in range(2 * N_PAIRS, N_Z):
            out[i, k] = abs(even_cos[i, k - N_PAIRS] + plane[k - 2 * N_PAIRS])


@njit(cache=True, nogil=True)
def _parts(xyz, normals, ids, start, centres, weights, radius, sign, values, bumps, row, column, parts):
    """The images of patches, split by mirror symmetry: (even, even), (odd, odd), (odd in x), (odd in y).

    A patch has one image for each row of `values`, or, where there is none, one of r.
    """
    room, n_images = 1, max(1, len(values))
    for i in range(len(centres)):
        room = max(room, start[i + 1] - start[i])
    dots, weight = np.empty((4, room)), np.ones(room)
    sums, field = np.empty((len(SIDES), 2, WIDE, WIDE)), np.empty((WIDE, WIDE))
    spare, flipped = np.empty((WIDE, WIDE)), np.empty((WIDE, WIDE))
    for i in range(len(centres)):
        patch = ids[start[i] : start[i + 1]]
        if len(patch) == 0:
            parts[:, n_images * i : n_images * (i + 1)] = 0.0
            continue
        if len(weights):
            for k in range(len(patch)):
                weight[k] = weights[start[i] + k]
        mean = _place(xyz, normals, patch, centres[i], weight, radius, sign, dots)
        for image in range(n_images):
            if len(values):
                mean = _take(values[image], patch, dots)
            lay(dots[:, : len(patch)], bumps, sums[0].ravel())
            for level in range(1, len(SIDES)):
                widen(sums[level - 1], SIDES[level - 1], SIDES[level], spare, flipped, sums[level])
            fill(sums, mean, field, spare, flipped)
            _split(field, row, column, parts[:, n_images * i + image])


@njit(cache=True, nogil=True, fastmath=FAST)
def _take(values, ids, dots):
    """Values of a patch's dots in place of r in `dots`; returns their weighted mean."""
    total = of_weights = 0.0
    for k in range(len(ids)):
        dots[2, k] = dots[3, k] * values[ids[k]]
        total += dots[2, k]
        of_weights += dots[3, k]
    return total / of_weights


@njit(cache=True, nogil=True, fastmath=FAST)
def _place(xyz, normals, ids, centre, weight, radius, sign, dots):
    """Turn a patch with its mean normal to +z; fill `dots` with x and y in steps of the grid, r less that of the plane,
    and the weight of each. Returns the weighted mean of r less that of the plane."""
    n = len(ids)
    mx = my = mz = total = 0.0
    for k in range(n):
        a = np.uintp(ids[k])
        d2 = 0.0
        for c in range(3):
            d2 += (xyz[a, c] - centre[c]) ** 2
        inside = max(0.0, 1.0 - (d2 / radius**2) ** 2)
        g = weight[k] * (inside * inside + FLOOR)
        dots[3, k] = g
        mx += g * normals[a, 0]
        my += g * normals[a, 1]
        mz += g * normals[a, 2]
        total += weight[k]
    across = math.sqrt(mx * mx + my * my)
    length = math.sqrt(across * across + mz * mz)
    c1, s1 = (my / across, mx / across) if across > 0.0 else (1.0, 0.0)
    c2, s2 = (sign * mz / length, sign * across / length) if length > 0.0 else (sign, 0.0)
    depth, step, scale = math.sqrt(2.0) * radius, STEPS / radius, n / total
    sum_of_r = of_weights = 0.0
    for k in range(n):
        a = np.uintp(ids[k])
        x, y, z = xyz[a, 0] - centre[0], xyz[a, 1] - centre[1], xyz[a, 2] - centre[2]
        y1 = s1 * x + c1 * y
        x = c1 * x - s1 * y
        y = c2 * y1 - s2 * z
        z = s2 * y1 + c2 * z + depth
        rho2 = x * x + y * y
        r = math.sqrt(rho2 + z * z) - math.sqrt(rho2 + depth * depth)
        cosine = sign * (s2 * (s1 * normals[a, 0] + c1 * normals[a, 1]) + c2 * normals[a, 2])
        g = dots[3, k] * scale * (max(0.0, cosine) + FLOOR)
        dots[0, k], dots[1, k] = MIDDLE + x * step, MIDDLE + y * step
        dots[2, k], dots[3, k] = g * r, g
        sum_of_r += g * r
        of_weights += g
    return sum_of_r / of_weights


@njit(cache=True, nogil=True, fastmath=FAST)
def _split(field, row, column, parts):
    """Sums and differences of the four mirror images of every node of a quarter."""
    for q in range(len(row)):
        i, j = row[q], column[q]
        a, b = field[MIDDLE + i, MIDDLE + j], field[MIDDLE + i, MIDDLE - j]
        c, d = field[MIDDLE - i, MIDDLE + j], field[MIDDLE - i, MIDDLE - j]
        parts[0, q] = (a + b) + (c + d)
        parts[1, q] = (a - b) - (c - d)
        parts[2, q] = (a - b) + (c - d)
        parts[3, q] = (a + b) - (c + d)
