"""Rotations of least squares and principal axes, and whether points determine them.

Points on a line do not determine the rotation about this line, and points that spread equally in two directions do not
determine their axes. Rounding would then decide, differently on each machine.
"""

from __future__ import annotations

import numpy as np

from sparsurf.errors import InputError

# Å, rms, from the line through them, of points that determine a rotation. Files store coordinates to 0.001 to 0.01 Å: nearer to
# the line, their rounding would decide by more than 0.1 rad.
MIN_DISTANCE_FROM_LINE = 0.1
EQUAL = 1e-8  # relative difference of two eigenvalues, or relative asymmetry, that counts as none
MIN_SPREAD = 1e-6  # Å, rms; points that spread less are in one place
NEGLIGIBLE = 1e-12  # Eigenvalues below this share of the largest are rounding errors.
SIGNIFICANT_SHARE = 0.5  # share of the largest length in a subspace at which a coordinate sets its axis


def best_rotations(covariance: np.ndarray, weight: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Compute the rotations that superpose points onto others by least squares (Kabsch, Acta Cryst. A 32:922, 1976).

    `covariance` (..., 3, 3), Å^2, is the sum of x_i y_j over the points x to rotate and the fixed points y, relative to their
    means; x @ rotation is nearest to y. The distance, Å, is that of the points from a line, root mean square, if x is y: below
    MIN_DISTANCE_FROM_LINE, or 0 for a mirror image that several rotations fit, the rotation is not determined.
    """
    u, s, vt = np.linalg.svd(covariance)
    sign = np.sign(np.linalg.det(u) * np.linalg.det(vt))
    u[..., :, 2] *= sign[..., None]  # a rotation, not a reflection
    # A rotation by t about the first axis lowers the sum of x . y by (1 - cos t) times this.
    loss = s[..., 1] + sign * s[..., 2]
    return u @ vt, np.sqrt(np.maximum(loss, 0) / weight)


def rigid_fit(points: np.ndarray, fixed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fit points onto others (n, 3), Å, not on a line; return rotation and shift: points @ rotation + shift fits `fixed`."""
    share = np.full(len(points), 1 / len(points))
    middle, target = share @ points, share @ fixed
    rotation, distance = best_rotations(((points - middle) * share[:, None]).T @ (fixed - target))
    if distance < MIN_DISTANCE_FROM_LINE:
        raise InputError(
            "the points to fit lie on a line, or are a mirror image, so that several rotations fit equally well: use more points."
        )
    return rotation, target - middle @ rotation


def principal_axes(points: np.ndarray, up: np.ndarray | None = None) -> np.ndarray:
    """Find the axes along which points (n, 3) spread, the widest first: unit vectors as rows, or two perpendicular to `up`.

    The longer tail of an axis, by its third moment, points along it. Where points determine no axis, the coordinate axes do:
    equal spreads take the first of x, y and z that lies near their plane, and equal tails let the largest component of the
    axis be positive.
    """
    x = points - points.mean(axis=0)
    plane = np.eye(3) if up is None else _perpendicular(up)
    if (x**2).sum() < len(x) * MIN_SPREAD**2:
        x = np.zeros_like(x)
    values, vectors = np.linalg.eigh(plane @ (x.T @ x) @ plane.T)
    axes = canonical_axes(values[::-1], plane.T @ vectors[:, ::-1]).T
    along = x @ axes.T
    tail, size = (along**3).sum(axis=0), (np.abs(along) ** 3).sum(axis=0)
    return axes * np.where(np.abs(tail) > EQUAL * size, np.sign(tail), _signs(axes))[:, None]


def canonical_axes(values: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Choose eigenvectors, columns (d, k), of equal eigenvalues (k,), descending, by a rule instead of by rounding.

    The first is chosen nearest to the first coordinate that is long enough in their subspace, with a positive sign; the next one
    the same among those perpendicular to it.
    """
    out = vectors.copy()
    size = np.maximum(np.abs(values), NEGLIGIBLE * abs(values[0]))
    new_group = size[:-1] - size[1:] > EQUAL * size[:-1]
    for group in np.split(np.arange(len(values)), np.flatnonzero(new_group) + 1):
        if len(group) > 1:
            out[:, group] = _canonical_basis(vectors[:, group])
    return out


def _canonical_basis(basis: np.ndarray) -> np.ndarray:
    """Return the basis of the subspace of `basis` (d, k) that does not depend on which basis is given."""
    left, out = (basis**2).sum(axis=1), np.zeros_like(basis)
    for k in range(basis.shape[1]):
        row = int(np.argmax(left > SIGNIFICANT_SHARE * left.max()))
        axis = basis @ basis[row] - out[:, :k] @ out[row, :k]
        out[:, k] = axis / np.linalg.norm(axis)
        left = left - out[:, k] ** 2
    return out


def _perpendicular(up: np.ndarray) -> np.ndarray:
    """Return two unit vectors perpendicular to `up` and to each other, as rows."""
    first = np.cross(up, np.eye(3)[np.argmin(np.abs(up).round(6))])
    first = first / np.linalg.norm(first)
    return np.array([first, np.cross(up, first)])


def _signs(axes: np.ndarray) -> np.ndarray:
    """Return the sign of the largest component of each axis; the first of equal ones."""
    size = np.abs(axes)
    largest = np.argmax(size > (1 - EQUAL) * size.max(axis=1, keepdims=True), axis=1)
    return np.where(axes[np.arange(len(axes)), largest] < 0, -1.0, 1.0)
