"""The method written as plainly as it reads, one patch at a time: the reference of the fast kernels."""

import math
from functools import cache

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse.csgraph import connected_components
from scipy.special import eval_jacobi


def island(points, ids, d_link):
    """Largest set of linked dots among `ids` (ascending); on a tie the one with the lowest dot."""
    ids = np.asarray(ids)
    if len(ids) == 0:
        return ids
    gaps = np.linalg.norm(points[ids][:, None] - points[ids][None], axis=2)
    _, label = connected_components(gaps < d_link, directed=False)
    return ids[label == np.argmax(np.bincount(label))]


def patch(points, i, radius, d_link):
    """Dots within `radius` of dot i, islands removed."""
    return island(points, np.flatnonzero(np.linalg.norm(points - points[i], axis=1) <= radius), d_link)


def roughness(points, normals, i, radius, d_link):
    """R_i, equation 1 of the paper."""
    n = normals[patch(points, i, radius, d_link)]
    if len(n) == 1:
        return 1.0
    mean = n.mean(axis=0)
    cosine = n @ mean / np.linalg.norm(n, axis=1) / np.linalg.norm(mean)
    return max(0.0, cosine.mean())


def cover(points, radius, d_link):
    """List of (dot that starts the patch, centre, dots) of the sweep."""
    covered, out = set(), []
    for i in range(len(points)):
        if i not in covered:
            dots = patch(points, i, radius, d_link)
            centre = dots[np.argmin(np.linalg.norm(points[dots] - points[i], axis=1))]
            out.append((i, centre, dots))
            covered.update(dots.tolist())
    return out


def probability(alpha, beta, gamma, delta, r, distance, radius):
    """p of equation 2, with 0^0 = 1."""
    return alpha * (1 - r) ** beta * (distance / radius) ** (gamma * (1 + r) + delta)


def upright(mean, up):
    """The turn about z, then x, that takes the mean normal to +z, or to -z."""
    a = math.atan2(mean[0], mean[1])
    about_z = np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])
    mean = about_z @ mean
    b = math.atan2(mean[1], mean[2]) + (0 if up else math.pi)
    about_x = np.array([[1, 0, 0], [0, math.cos(b), -math.sin(b)], [0, math.sin(b), math.cos(b)]])
    return about_x @ about_z


def image(points, normals, up=True, weights=None):
    """25 x 25 image of a patch before the gaps are filled; None where it has no extent."""
    w = np.ones(len(points)) if weights is None else weights
    x = points - (w[:, None] * points).sum(axis=0) / w.sum()
    x = x @ upright((w[:, None] * normals).sum(axis=0), up).T
    rho = np.hypot(x[:, 0], x[:, 1])
    if rho.max() == 0:
        return None
    r = np.hypot(rho, x[:, 2] - (x[:, 2] - rho).min())
    edge = 1.01 * rho.max()
    lines = np.linspace(-edge, edge, 26)
    out = np.zeros((25, 25))
    for j in range(25):
        for i in range(25):
            inside = (x[:, 0] > lines[i]) & (x[:, 0] <= lines[i + 1])
            inside &= (-x[:, 1] > lines[j]) & (-x[:, 1] <= lines[j + 1])
            if w[inside].any():
                out[j, i] = np.average(r[inside], weights=w[inside])
    return out


def fill(picture):
    """Gaps of an image filled, everything outside the disc zero (method of the authors' scripts)."""
    f = picture.copy()
    disc = [(i, j) for i in range(25) for j in range(25) if (i - 12) ** 2 + (j - 12) ** 2 < 144]

    def mean(i, j):
        block = f[i - 1 : i + 2, j - 1 : j + 2]
        return block[block != 0].mean() if (block != 0).any() else 0.0

    def sweep(ready):
        changed = False
        for i, j in disc:
            if f[i, j] == 0 and ready(i, j):
                f[i, j] = mean(i, j)
                changed = changed or f[i, j] != 0
        return changed

    def straight(i, j):
        return (f[i - 1, j] and f[i + 1, j]) or (f[i, j - 1] and f[i, j + 1])

    def diagonal(i, j):
        return (f[i - 1, j - 1] and f[i + 1, j + 1]) or (f[i - 1, j + 1] and f[i + 1, j - 1])

    for _ in range(50):
        if not (sweep(straight) | sweep(diagonal)):
            break
    for _ in range(50):
        if not sweep(lambda i, j: True):
            break
    i, j = np.mgrid[:25, :25]
    f[(i - 12) ** 2 + (j - 12) ** 2 > 144] = 0
    return f


@cache
def polynomials():
    """(n + 1)/M conj(Z_nm) on the pixels of the 400 x 400 enlargement that count: (M,) mask and (121, M)."""
    k = np.arange(400)
    x, y = np.meshgrid(k / 199 - 1, (399 - k) / 199 - 1)
    inside = (k[:, None] - 199.5) ** 2 + (k[None] - 199.5) ** 2 <= 199.5**2
    r, t = np.hypot(x, y)[inside], np.arctan2(y, x)[inside]
    out = []
    for n in range(21):
        for m in range(n % 2, n + 1, 2):
            radial = r**m * eval_jacobi((n - m) // 2, 0, m, 2 * r**2 - 1)
            out.append((n + 1) / inside.sum() * radial * np.exp(-1j * m * t))
    return inside, np.array(out)


def moduli(picture):
    """|c_nm| of an image, summed pixel by pixel over its 400 x 400 enlargement."""
    inside, z = polynomials()
    return np.abs(z @ np.kron(picture, np.ones((16, 16)))[inside])


def descriptor(points, normals, up=True, weights=None):
    """The 121 invariants of a patch given by its dots."""
    picture = image(points, normals, up, weights) if len(points) > 1 else None
    return np.zeros(121) if picture is None else moduli(fill(picture))


def robust_values(points, normals, centre, radius=6.0, up=True, weights=None):
    """Places x, y in the disc (radius 1), r less that of the plane, and weight of the dots of a patch."""
    w = np.ones(len(points)) if weights is None else weights / weights.mean()
    x = points - centre
    w = w * (np.maximum(0, 1 - (np.linalg.norm(x, axis=1) / radius) ** 4) ** 2 + 1e-3)
    turn = upright((w[:, None] * normals).sum(axis=0), up)
    x, n = x @ turn.T, normals @ turn.T * (1 if up else -1)
    rho, depth = np.hypot(x[:, 0], x[:, 1]), math.sqrt(2) * radius
    value = np.hypot(rho, x[:, 2] + depth) - np.hypot(rho, depth)
    return x[:, :2] / radius, value, w * (np.maximum(0, n[:, 2]) + 1e-3)


def robust_field(place, value, weight):
    """The field at 25 x 25 nodes, the disc's radius being 11 steps: every bump laid at every node by itself."""
    bump = BSpline.basis_element(np.arange(-4.0, 5.0), extrapolate=False)
    field = np.average(value, weights=weight) * np.ones((4, 4))
    for side, width in ((4, 8), (7, 4), (13, 2), (25, 1)):
        node = np.linspace(-12, 12, side)
        in_x, in_y = (np.nan_to_num(bump((11 * place[:, c, None] - node) / width)) for c in (0, 1))
        if side > 4:
            field = halved(halved(field).T).T
        field = (in_y.T @ (in_x * (weight * value)[:, None]) + 0.1 * field) / (
            in_y.T @ (in_x * weight[:, None]) + 0.1
        )
    return field


def halved(coarse):
    """Rows with one more between any two: the cubic of Keys at the middle, the outermost rows repeated."""
    wide = np.concatenate([coarse[:1], coarse, coarse[-1:]])
    middle = (9 * (wide[1:-2] + wide[2:-1]) - (wide[:-3] + wide[3:])) / 16
    out = np.empty((2 * len(coarse) - 1, coarse.shape[1]))
    out[::2], out[1::2] = coarse, middle
    return out


def rotation_robust(points, normals, centre, radius=6.0, up=True, weights=None):
    """The 121 invariants of the rotation-robust descriptor, integrated over a fine polar grid."""
    if len(points) == 0:
        return np.zeros(121)
    field = robust_field(*robust_values(points, normals, centre, radius, up, weights))
    (r, of_r), t = np.polynomial.legendre.leggauss(90), 2 * np.pi * np.arange(128) / 128
    r, of_r = (r + 1) / 2, of_r / 2
    x, y = 11 * r[:, None] * np.cos(t), 11 * r[:, None] * np.sin(t)
    node = np.arange(-12, 13)
    values = np.einsum(
        "rtj,ji,rti->rt", keys(y[..., None] - node), field, keys(x[..., None] - node), optimize=True
    )
    values = values + radius * np.hypot(r, math.sqrt(2))[:, None]
    out = []
    for n in range(21):
        for m in range(n % 2, n + 1, 2):
            radial = r**m * eval_jacobi((n - m) // 2, 0, m, 2 * r**2 - 1)
            around = (values * np.exp(-1j * m * t)).mean(axis=1)
            out.append(abs(2 * (n + 1) * (of_r * r * radial * around).sum()))
    return np.array(out)


def keys(t):
    """Cubic convolution of Keys with a = -1/2."""
    t = np.abs(t)
    return np.where(
        t < 1, 1.5 * t**3 - 2.5 * t**2 + 1, np.where(t < 2, -0.5 * t**3 + 2.5 * t**2 - 4 * t + 2, 0)
    )
