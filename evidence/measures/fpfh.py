"""Fast point feature histograms (Rusu, Blodow & Beetz, ICRA 2009): angles between the normals around each dot."""

import numpy as np
from scipy.sparse import coo_array
from scipy.spatial import cKDTree

BINS = 11  # of each of the three angles


def fpfh(points: np.ndarray, normals: np.ndarray, radius: float) -> np.ndarray:
    """Compute the histograms of all dots.

    Parameters
    ----------
    points, normals : (N, 3) float, Å and unit vectors; no two dots in one place
    radius : float, Å

    Returns
    -------
    (N, 33) float64; each third sums to 200, to 100 for a dot whose neighbours have no others and to 0 for one without
    neighbours
    """
    n = len(points)
    first, second = cKDTree(points).query_pairs(radius, output_type="ndarray").T
    bins = _bins(points, normals, first, second)
    at = np.concatenate([first, second])
    counts = np.zeros((n, 3 * BINS))
    for column in bins:
        counts += np.bincount(at * 3 * BINS + np.tile(column, 2), minlength=3 * BINS * n).reshape(n, -1)
    own = _percent(counts)
    square = ((points[first] - points[second]) ** 2).sum(axis=1)
    weight = coo_array((np.tile(1 / square, 2), (at, np.concatenate([second, first]))), (n, n)).tocsr()
    return own + _percent(weight @ own)


def _bins(points: np.ndarray, normals: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return bins (3, pairs) of the angles of pairs, in the frame of the dot whose normal is closer to the line between them."""
    line = points[second] - points[first]
    line /= np.linalg.norm(line, axis=1, keepdims=True)
    cosines = [np.sum(normals[own] * line, axis=1) for own in (first, second)]
    swap = np.abs(cosines[0]) < np.abs(cosines[1])
    u = np.where(swap[:, None], normals[second], normals[first])
    other = np.where(swap[:, None], normals[first], normals[second])
    line[swap] *= -1
    v = np.cross(line, u)
    v /= np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-12)
    w = np.cross(u, v)
    turn = np.arctan2(np.sum(w * other, axis=1), np.sum(u * other, axis=1)) / np.pi
    along = np.where(swap, -cosines[1], cosines[0])
    values = np.stack([turn, np.sum(v * other, axis=1), along])
    return np.clip((BINS * (values + 1) / 2).astype(int), 0, BINS - 1) + BINS * np.arange(3)[:, None]


def _percent(histograms: np.ndarray) -> np.ndarray:
    """Scale each third of the rows to a sum of 100; zeros stay."""
    thirds = histograms.reshape(len(histograms), 3, BINS)
    total = thirds.sum(axis=2, keepdims=True)
    return (100 * thirds / np.where(total > 0, total, 1)).reshape(histograms.shape)
