"""Zernike coefficients of a smooth field that is known at the nodes of a square grid.

Between the nodes the field is interpolated by cubic convolution (Keys, IEEE Trans. ASSP 29:1153, 1981) and that surface
is integrated over the disc, so that no edge of a pixel matters. Conventions as in `polynomials`.

The mirror images of a node carry the same |Z_nm|, so a field splits into four parts, even or odd in x and in y, each of
which gives a quarter of the coefficients: cos(m t) is even in y, sin(m t) odd; under x -> -x they keep their sign for
m even and m odd, in this order, and change it otherwise.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from sparsurf.patches.zernike.polynomials import N_MAX, indices, radial

RINGS, RAYS = 64, 64  # points of the integration along the radius and around a quarter


class Quarters(NamedTuple):
    """Matrices of the four parts of a field; made by `quarters`.

    row, column : (Q,) int64, steps from the middle node of the nodes of one quarter that the disc reaches
    even, odd : two pairs (cosine, sine) of (Q, ..) float64, for m even (cosine: m > 0, then m = 0) and m odd
    order : (121,) int64, place in `indices()` of m even > 0, m odd, m = 0
    """

    row: np.ndarray
    column: np.ndarray
    even: tuple
    odd: tuple
    order: np.ndarray


def points():
    """Places x, y and weights of an integral over a quarter of the unit disc; (RINGS * RAYS,) each."""
    r, of_ring = _gauss(RINGS)
    t, of_ray = _gauss(RAYS)
    t, of_ray = t * np.pi / 2, of_ray * np.pi / 2
    weight = (r * of_ring)[:, None] * of_ray
    return (r[:, None] * np.cos(t)).ravel(), (r[:, None] * np.sin(t)).ravel(), weight.ravel()


def _gauss(n):
    """Nodes and weights of Gauss and Legendre on 0..1."""
    x, weight = np.polynomial.legendre.leggauss(n)
    return (x + 1) / 2, weight / 2


def harmonics(x, y):
    """(n + 1)/pi R_nm(r) exp(i m t) at places of the unit disc, (121, len(x)) complex128."""
    out, sector, r2 = {}, np.ones(len(x), complex), x * x + y * y
    for m in range(N_MAX + 1):
        for n, polynomial in radial(m, r2):
            out[n, m] = (n + 1) / np.pi * polynomial * sector
        sector = sector * (x + 1j * y)
    return np.array([out[nm] for nm in indices()])


def cubic(t):
    """Weight of a node at a distance of t steps."""
    t = np.abs(t)
    near, far = (1.5 * t - 2.5) * t * t + 1, ((-0.5 * t + 2.5) * t - 4) * t + 2
    return np.where(t < 1, near, np.where(t < 2, far, 0.0))


@cache
def quarters(steps):
    """The matrices for a disc whose radius is `steps` steps of the grid."""
    x, y, weight = points()
    z = harmonics(x, y) * weight
    m = np.array([m for _, m in indices()])
    node = np.arange(steps + 2)
    row, column = (k.ravel() for k in np.meshgrid(node, node, indexing="ij"))
    reached = np.maximum(row - 2, 0) ** 2 + np.maximum(column - 2, 0) ** 2 < steps**2
    row, column = row[reached], column[reached]
    of_x = {sign: _mirrored(x * steps, node, sign) for sign in (1, -1)}
    of_y = {sign: _mirrored(y * steps, node, sign) for sign in (1, -1)}

    def matrix(values, x_sign, y_sign):
        out = np.stack([(values * of_y[y_sign][:, k]) @ of_x[x_sign] for k in node], axis=1)
        return np.ascontiguousarray(out[:, row, column].T)

    some, none, other = (np.flatnonzero(k) for k in ((m % 2 == 0) & (m > 0), m == 0, m % 2 == 1))
    both = np.concatenate([some, none])
    return Quarters(
        row,
        column,
        (matrix(z[both].real, 1, 1), matrix(z[some].imag, -1, -1)),
        (matrix(z[other].real, -1, 1), matrix(z[other].imag, 1, -1)),
        np.concatenate([some, other, none]),
    )


def _mirrored(x, node, sign):
    """Weights, at places x >= 0 in steps, of the sum (sign 1) or the difference of a node and its mirror image.

    On the middle line both are the same node, and what is weighed is twice its value, or nothing.
    """
    out = cubic(x[:, None] - node) + sign * cubic(x[:, None] + node)
    out[:, node == 0] /= 2
    return out
