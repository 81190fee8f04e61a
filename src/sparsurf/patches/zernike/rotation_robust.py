"""A descriptor that depends only on the surface, not on the orientation of the molecule nor on where its dots fell.

As in the published descriptor, a patch is turned with its mean normal to +z and seen as distances r to the apex of a cone;
|c_nm| is independent of the rotation about z. The differences, each with its reason:
- The disc is the ball of r_zernike, seen along the mean normal. The apex lies sqrt(2) r_zernike below its middle, where the
  cone of 45 degrees just contains the ball: no single dot determines the frame.
- The weight of a dot falls smoothly to 0 at the rim, so that no dot enters or leaves abruptly.
- The weight is also proportional to the cosine of the dot's normal to z, which gives the area seen from above: dots below an
  overhang do not count.
- r is not a mean per pixel but a smooth field, whose gaps are filled from all sides at once, see `fields`.
- The field is interpolated and integrated over the disc, see `quadrature`.
The image holds r less that of the plane z = 0, whose coefficients are known: an empty region continues its surroundings.

A field, a number at each dot such as a potential, can replace r in the same image: `describe_fields`.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from sparsurf.kernels import njit
from sparsurf.patches.zernike.fields import MIDDLE, N_NODES, PADDED_SIDE, add_dots, bumps, fill, widen
from sparsurf.patches.zernike.images import FAST, Descriptor, Patches
from sparsurf.patches.zernike.polynomials import N_MAX
from sparsurf.patches.zernike.quadrature import harmonics, integration_points, quarters

DISC_STEPS = 11  # radius of the disc in steps of the grid: bumps then reach just beyond the outermost dot
MIN_WEIGHT = 1e-3  # of a dot, so that a patch of dots on the rim has a mean

N_PAIRS = 55  # coefficients with m even > 0, and as many with m odd
N_Z = 121


def describe(patches: Patches) -> np.ndarray:
    """Compute the Zernike invariants |c_nm| of patches, (P, N_Z); zero for a patch without dots."""
    return _invariants(patches, np.empty((0, 0)), patches.radius * _plane_coefficients())


def describe_fields(patches: Patches, values: np.ndarray) -> np.ndarray:
    """Compute the invariants (P, F N_Z) of images of fields, `values` (F, N) by position, in place of r; 0 for an empty patch."""
    return _invariants(patches, values, np.zeros(N_MAX // 2 + 1))


def _invariants(patches: Patches, values: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """Compute |c_nm| of images of r, or of `values`; `plane` has the coefficients of a part subtracted before and added again."""
    dots, ids, start, centres, weights, radius, up = patches
    tables, n_images = quarters(DISC_STEPS), max(1, len(values))
    parts = np.empty((4, n_images * (len(start) - 1), len(tables.row)))
    sign = 1.0 if up else -1.0
    _parts(
        dots.xyz, dots.normals, ids, start, centres, weights, radius, sign, values, bumps().ravel(), tables.row, tables.column,
        parts,
    )  # fmt: skip
    out = np.empty((parts.shape[1], N_Z))
    cosines, sines = parts[0] @ tables.even[0], parts[1] @ tables.even[1]
    _moduli(cosines, sines, parts[2] @ tables.odd[0], parts[3] @ tables.odd[1], plane, start, n_images, out)
    return out.reshape(len(start) - 1, -1)


def order() -> np.ndarray:
    """Return the index in `polynomials.indices()` of each column of `describe`."""
    return quarters(DISC_STEPS).order


DESCRIPTOR = Descriptor(N_Z, order, describe)


@cache
def _plane_coefficients() -> np.ndarray:
    """Return c_n0 of r for the plane z = 0 and a disc of radius 1, (11,)."""
    x, y, weight = integration_points()
    z = harmonics(x, y)[order()[2 * N_PAIRS :]].real
    return 4 * z @ (weight * np.sqrt(x * x + y * y + 2.0))


@njit(fastmath=FAST)
def _moduli(
    even_cos: np.ndarray,
    even_sin: np.ndarray,
    odd_cos: np.ndarray,
    odd_sin: np.ndarray,
    plane: np.ndarray,
    start: np.ndarray,
    n_images: int,
    out: np.ndarray,
) -> None:
    """Combine cosine and sine parts to moduli, with the coefficients of the plane added at m = 0."""
    for i in range(len(out)):
        if start[i // n_images + 1] == start[i // n_images]:
            out[i] = 0.0
            continue
        for k in range(N_PAIRS):
            out[i, k] = math.sqrt(even_cos[i, k] ** 2 + even_sin[i, k] ** 2)
            out[i, N_PAIRS + k] = math.sqrt(odd_cos[i, k] ** 2 + odd_sin[i, k] ** 2)
        for k in range(2 * N_PAIRS, N_Z):
            out[i, k] = abs(even_cos[i, k - N_PAIRS] + plane[k - 2 * N_PAIRS])


@njit()
def _parts(
    xyz: np.ndarray,
    normals: np.ndarray,
    ids: np.ndarray,
    start: np.ndarray,
    centres: np.ndarray,
    weights: np.ndarray,
    radius: float,
    sign: float,
    values: np.ndarray,
    bumps: np.ndarray,
    row: np.ndarray,
    column: np.ndarray,
    parts: np.ndarray,
) -> None:
    """Compute the images of r, or of `values`, by patch and mirror symmetry: (even, even), (odd, odd), (odd in x), (odd in y)."""
    buffer_size, n_images = 1, max(1, len(values))
    for i in range(len(centres)):
        buffer_size = max(buffer_size, start[i + 1] - start[i])
    dots, weight = np.empty((4, buffer_size)), np.ones(buffer_size)
    sums, field = np.empty((len(N_NODES), 2, PADDED_SIDE, PADDED_SIDE)), np.empty((PADDED_SIDE, PADDED_SIDE))
    spare, flipped = np.empty((PADDED_SIDE, PADDED_SIDE)), np.empty((PADDED_SIDE, PADDED_SIDE))
    for i in range(len(centres)):
        patch = ids[start[i] : start[i + 1]]
        if len(patch) == 0:
            parts[:, n_images * i : n_images * (i + 1)] = 0.0
            continue
        if len(weights):
            for k in range(len(patch)):
                weight[k] = weights[start[i] + k]
        mean = _orient(xyz, normals, patch, centres[i], weight, radius, sign, dots)
        for image in range(n_images):
            if len(values):
                mean = _insert_values(values[image], patch, dots)
            add_dots(dots[:, : len(patch)], bumps, sums[0].ravel())
            for level in range(1, len(N_NODES)):
                widen(sums[level - 1], N_NODES[level - 1], N_NODES[level], spare, flipped, sums[level])
            fill(sums, mean, field, spare, flipped)
            _split(field, row, column, parts[:, n_images * i + image])


@njit(fastmath=FAST)
def _insert_values(values: np.ndarray, ids: np.ndarray, dots: np.ndarray) -> float:
    """Put the weighted values of a patch's dots in place of r in `dots`; return their weighted mean."""
    weighted_sum = total_weight = 0.0
    for k in range(len(ids)):
        dots[2, k] = dots[3, k] * values[ids[k]]
        weighted_sum += dots[2, k]
        total_weight += dots[3, k]
    return weighted_sum / total_weight


@njit(fastmath=FAST)
def _orient(
    xyz: np.ndarray,
    normals: np.ndarray,
    ids: np.ndarray,
    centre: np.ndarray,
    weight: np.ndarray,
    radius: float,
    sign: float,
    dots: np.ndarray,
) -> float:
    """Turn a patch with its mean normal to +z; return the weighted mean of r less that of the plane.

    `dots` receives x and y in steps of the grid, weight times r less that of the plane, and weight.
    """
    n = len(ids)
    mx = my = mz = total = 0.0
    for k in range(n):
        a = np.uintp(ids[k])
        d2 = 0.0
        for c in range(3):
            d2 += (xyz[a, c] - centre[c]) ** 2
        inside = max(0.0, 1.0 - (d2 / radius**2) ** 2)
        g = weight[k] * (inside * inside + MIN_WEIGHT)
        dots[3, k] = g
        mx += g * normals[a, 0]
        my += g * normals[a, 1]
        mz += g * normals[a, 2]
        total += weight[k]
    across = math.sqrt(mx * mx + my * my)
    length = math.sqrt(across * across + mz * mz)
    c1, s1 = (my / across, mx / across) if across > 0.0 else (1.0, 0.0)
    c2, s2 = (sign * mz / length, sign * across / length) if length > 0.0 else (sign, 0.0)
    # Weights with a mean of 1, so that HALF_WEIGHT counts dots whatever their weights
    depth, step, scale = math.sqrt(2.0) * radius, DISC_STEPS / radius, n / total
    sum_of_r = total_weight = 0.0
    for k in range(n):
        a = np.uintp(ids[k])
        x, y, z = xyz[a, 0] - centre[0], xyz[a, 1] - centre[1], xyz[a, 2] - centre[2]
        y1 = s1 * x + c1 * y
        x = c1 * x - s1 * y
        y = c2 * y1 - s2 * z
        z = s2 * y1 + c2 * z + depth
        rho2 = x * x + y * y
        # Less the plane, so that a gap continues the patch around it and not the cone
        r = math.sqrt(rho2 + z * z) - math.sqrt(rho2 + depth * depth)
        cosine = sign * (s2 * (s1 * normals[a, 0] + c1 * normals[a, 1]) + c2 * normals[a, 2])
        g = dots[3, k] * scale * (max(0.0, cosine) + MIN_WEIGHT)
        dots[0, k], dots[1, k] = MIDDLE + x * step, MIDDLE + y * step
        dots[2, k], dots[3, k] = g * r, g
        sum_of_r += g * r
        total_weight += g
    return sum_of_r / total_weight


@njit(fastmath=FAST)
def _split(field: np.ndarray, row: np.ndarray, column: np.ndarray, parts: np.ndarray) -> None:
    """Compute sums and differences of the four mirror images of every node of a quarter."""
    for q in range(len(row)):
        i, j = row[q], column[q]
        a, b = field[MIDDLE + i, MIDDLE + j], field[MIDDLE + i, MIDDLE - j]
        c, d = field[MIDDLE - i, MIDDLE + j], field[MIDDLE - i, MIDDLE - j]
        parts[0, q] = (a + b) + (c + d)
        parts[1, q] = (a - b) - (c - d)
        parts[2, q] = (a - b) + (c - d)
        parts[3, q] = (a + b) - (c + d)
