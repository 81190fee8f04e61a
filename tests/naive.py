"""The method written as plainly as it reads, one patch at a time: the reference of the fast kernels."""

import math
from functools import cache

import numpy as np
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


def image(points, normals, up=True, weights=None):
    """25 x 25 image of a patch before the gaps are filled; None where it has no extent."""
    w = np.ones(len(points)) if weights is None else weights
    x = points - (w[:, None] * points).sum(axis=0) / w.sum()
    mean = (w[:, None] * normals).sum(axis=0)
    a = math.atan2(mean[0], mean[1])
    about_z = np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])
    mean = about_z @ mean
    b = math.atan2(mean[1], mean[2]) + (0 if up else math.pi)
    about_x = np.array([[1, 0, 0], [0, math.cos(b), -math.sin(b)], [0, math.sin(b), math.cos(b)]])
    x = x @ (about_x @ about_z).T
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
            if inside.any():
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
