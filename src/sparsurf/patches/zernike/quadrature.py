"""Zernike coefficients of a smooth field that is known at the nodes of a square grid.

Between the nodes, the field is interpolated by cubic convolution (Keys, IEEE Trans. ASSP 29:1153, 1981). The result is
integrated over the disc, so that no edge of a pixel matters. Conventions are those of `polynomials`.

The mirror images of a node carry the same |Z_nm|, so a field splits into four parts, even or odd in x and in y. Each of them
gives a quarter of the coefficients: cos(m t) is even in y, sin(m t) odd. Under x -> -x, cos(m t) keeps its sign for m even
and sin(m t) for m odd; they change it otherwise.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from sparsurf.patches.zernike.polynomials import N_MAX, indices, radial

N_RINGS, N_RAYS = 64, 64  # integration points along the radius and around a quarter


class Quarters(NamedTuple):
    """Matrices of the four parts of a field; `quarters` makes it."""

    row: np.ndarray  # (Q,) int64, steps from the middle node of the nodes of a quarter that the disc reaches
    column: np.ndarray  # (Q,) int64
    even: tuple  # pairs (cosine, sine) of (Q, ..) float64, for m even (cosine: m > 0, then m = 0)
    odd: tuple  # the same for m odd
    order: np.ndarray  # (121,) int64, index in `indices()` of m even > 0, m odd, m = 0


def integration_points() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return x, y and weights of an integral over a quarter of the unit disc, (N_RINGS * N_RAYS,) each."""
    r, ring_weight = _gauss_legendre(N_RINGS)
    t, ray_weight = _gauss_legendre(N_RAYS)
    t, ray_weight = t * np.pi / 2, ray_weight * np.pi / 2
    weight = (r * ring_weight)[:, None] * ray_weight
    return (r[:, None] * np.cos(t)).ravel(), (r[:, None] * np.sin(t)).ravel(), weight.ravel()


def _gauss_legendre(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes and weights of Gauss-Legendre quadrature on 0..1."""
    x, weight = np.polynomial.legendre.leggauss(n)
    return (x + 1) / 2, weight / 2


def harmonics(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return (n + 1)/pi R_nm(r) exp(i m t) at points of the unit disc, (121, len(x)) complex128."""
    out, sector, r2 = {}, np.ones(len(x), complex), x * x + y * y
    for m in range(N_MAX + 1):
        for n, polynomial in radial(m, r2):
            out[n, m] = (n + 1) / np.pi * polynomial * sector
        sector = sector * (x + 1j * y)
    return np.array([out[nm] for nm in indices()])


def cubic_kernel(t: np.ndarray) -> np.ndarray:
    """Return the weight of a node at a distance of t steps."""
    t = np.abs(t)
    near, far = (1.5 * t - 2.5) * t * t + 1, ((-0.5 * t + 2.5) * t - 4) * t + 2
    return np.where(t < 1, near, np.where(t < 2, far, 0.0))


@cache
def quarters(steps: int) -> Quarters:
    """Compute the matrices for a disc whose radius is `steps` steps of the grid."""
    x, y, weight = integration_points()
    z = harmonics(x, y) * weight
    m = np.array([m for _, m in indices()])
    node = np.arange(steps + 2)
    row, column = (k.ravel() for k in np.meshgrid(node, node, indexing="ij"))
    reached = np.maximum(row - 2, 0) ** 2 + np.maximum(column - 2, 0) ** 2 < steps**2
    row, column = row[reached], column[reached]
    x_weights = {sign: _mirrored(x * steps, node, sign) for sign in (1, -1)}
    y_weights = {sign: _mirrored(y * steps, node, sign) for sign in (1, -1)}

    def matrix(values: np.ndarray, x_sign: int, y_sign: int) -> np.ndarray:
        out = np.stack([(values * y_weights[y_sign][:, k]) @ x_weights[x_sign] for k in node], axis=1)
        return np.ascontiguousarray(out[:, row, column].T)

    even, zero, odd = (np.flatnonzero(k) for k in ((m % 2 == 0) & (m > 0), m == 0, m % 2 == 1))
    even_and_zero = np.concatenate([even, zero])
    return Quarters(
        row,
        column,
        (matrix(z[even_and_zero].real, 1, 1), matrix(z[even].imag, -1, -1)),
        (matrix(z[odd].real, -1, 1), matrix(z[odd].imag, 1, -1)),
        np.concatenate([even, odd, zero]),
    )


def _mirrored(x: np.ndarray, node: np.ndarray, sign: int) -> np.ndarray:
    """Return weights, at x >= 0 in steps, of the sum (sign 1) or difference of a node and its mirror image; at 0 they are one."""
    out = cubic_kernel(x[:, None] - node) + sign * cubic_kernel(x[:, None] + node)
    out[:, node == 0] /= 2
    return out
