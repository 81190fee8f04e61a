"""Find a site of several places as a whole: the pose on a target in which most places agree.

Two places with their normals determine a pose. Poses are built from pairs of likely matches with similar distances and normals
on site and target. The score of a pose is the sum of the likelihoods of its matches.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from sparsurf import InputError
from sparsurf.orientation import MIN_DISTANCE_FROM_LINE, best_rotations

N_CANDIDATES = 12  # most likely matches of each place, from which poses are built
MAX_PAIRS = 4000  # pairs of matches that are tried, the most likely first
PAIR_DISTANCE = (4.0, 25.0)  # Å, smallest and largest distance between the two places of a pair
DISTANCE_TOLERANCE = 1.5  # Å, by which the distances of a pair may differ between site and target
COSINE_TOLERANCE = 0.35  # by which the cosines between the normals of a pair may differ
MATCH_DISTANCE = 2.5  # Å, largest distance between matching places of site and target
MIN_NORMAL_COSINE = 0.3  # between the normals of matching places
DECIMALS = 9  # to which scores are rounded, so that rounding errors do not decide between equal ones
N_REFINED = 20  # best poses that are refined
MIN_LIKELIHOOD_WEIGHT = 0.05  # of a match in the fit of a refined pose


class Pose(NamedTuple):
    """The rigid motion x -> x @ rotation + shift that superposes the site onto the target.

    score : float, sum of the likelihoods of the matches
    rotation, shift : (3, 3) and (3,) float64, Å
    match : (Q,) int64, matching place of the target for each place of the site; -1 for none
    """

    score: float
    rotation: np.ndarray
    shift: np.ndarray
    match: np.ndarray


class _Search(NamedTuple):
    """Data of a search: the site, the target with its tree, and the likelihoods (Q, T)."""

    points: np.ndarray
    normals: np.ndarray
    target_points: np.ndarray
    target_normals: np.ndarray
    tree: cKDTree
    likelihood: np.ndarray


def best_pose(
    points: np.ndarray,
    normals: np.ndarray,
    target_points: np.ndarray,
    target_normals: np.ndarray,
    likelihood: np.ndarray,
) -> Pose:
    """Find the pose with the highest score.

    Parameters
    ----------
    points, normals : (Q, 3) float64, of the site, Å and unit vectors
    target_points, target_normals : (T, 3) float64
    likelihood : (Q, T) float
        How likely each place of the site corresponds to each place of the target; 0 excludes a match.

    Returns
    -------
    Pose; its score is 0, without matches, if no pair of matches agrees
    """
    candidates = _likeliest(likelihood, min(N_CANDIDATES, likelihood.shape[1]))
    search = _Search(points, normals, target_points, target_normals, cKDTree(target_points), likelihood)
    first, second = _matching_pairs(search, candidates)
    if len(first[0]) == 0:
        return Pose(0.0, np.eye(3), np.zeros(3), np.full(len(points), -1))
    rotations, shifts = _poses_of_pairs(search, first, second)
    scores = _scores(search, rotations, shifts)[0]
    best = np.argsort(-scores, kind="stable")[:N_REFINED]
    return max((_refine(search, rotations[k], shifts[k]) for k in best), key=lambda pose: pose.score)


def _likeliest(likelihood: np.ndarray, n: int) -> np.ndarray:
    """Return the n most likely places of each row (Q, n); ties go to the first, unlike in a partition."""
    last = -np.partition(-likelihood, n - 1, axis=1)[:, n - 1 : n]
    better, equal = likelihood > last, likelihood == last
    free = n - better.sum(axis=1, keepdims=True)
    taken = better | (equal & (np.cumsum(equal, axis=1) <= free))
    return np.nonzero(taken)[1].reshape(len(likelihood), n)


def _matching_pairs(
    search: _Search, candidates: np.ndarray
) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """Return pairs of matches (i, a), (j, b) that agree, the most likely first, as int arrays."""
    points, normals, target_points, target_normals, _, likelihood = search
    n, k = candidates.shape
    i, a = np.repeat(np.arange(n), k), candidates.ravel()
    likely = likelihood[i, a]
    strong = np.argsort(-likely, kind="stable")[: max(2, int(np.sqrt(40 * MAX_PAIRS)))]
    i, a, likely = i[strong], a[strong], likely[strong]
    p, q = np.triu_indices(len(i), 1)
    distance = np.linalg.norm(points[i[p]] - points[i[q]], axis=1)
    target_distance = np.linalg.norm(target_points[a[p]] - target_points[a[q]], axis=1)
    low, high = PAIR_DISTANCE
    agree = (distance > low) & (distance < high) & (np.abs(distance - target_distance) < DISTANCE_TOLERANCE)
    p, q = p[agree], q[agree]
    cosine = np.einsum("ij,ij->i", normals[i[p]], normals[i[q]])
    target_cosine = np.einsum("ij,ij->i", target_normals[a[p]], target_normals[a[q]])
    agree = np.abs(cosine - target_cosine) < COSINE_TOLERANCE
    p, q = p[agree], q[agree]
    order = np.argsort(-(likely[p] + likely[q]).round(DECIMALS), kind="stable")[:MAX_PAIRS]
    return (i[p[order]], a[p[order]]), (i[q[order]], a[q[order]])


def _poses_of_pairs(
    search: _Search, first: tuple[np.ndarray, np.ndarray], second: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return rotations (H, 3, 3) and shifts (H, 3) that superpose the frames of pairs."""
    points, normals, target_points, target_normals, *_ = search
    (i, a), (j, b) = first, second
    frames = _frames(points[i], points[j], normals[i] + normals[j])
    target_frames = _frames(target_points[a], target_points[b], target_normals[a] + target_normals[b])
    rotations = np.swapaxes(frames, 1, 2) @ target_frames
    middle = (points[i] + points[j]) / 2
    shifts = (target_points[a] + target_points[b]) / 2 - np.einsum("hi,hij->hj", middle, rotations)
    return rotations, shifts


def _frames(first: np.ndarray, second: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Return right-handed frames, as rows: along the pair, across it, and the component of `up` perpendicular to both."""
    along = second - first
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    up = up - np.einsum("ij,ij->i", up, along)[:, None] * along
    up = up / np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-9)
    return np.stack([along, np.cross(up, along), up], axis=1)


def _scores(search: _Search, rotations: np.ndarray, shifts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the scores (H,) of poses, and the match of each place (H, Q)."""
    posed = search.points @ rotations + shifts[:, None]
    distance, nearest = search.tree.query(posed, distance_upper_bound=MATCH_DISTANCE)
    index = np.where(np.isfinite(distance), nearest, 0)
    cosine = np.einsum("hij,hij->hi", search.normals @ rotations, search.target_normals[index])
    met = np.isfinite(distance) & (cosine > MIN_NORMAL_COSINE)
    likely = np.where(met, search.likelihood[np.arange(len(search.points)), index], 0)
    return likely.sum(axis=1).round(DECIMALS), np.where(met, index, -1)


def _score(search: _Search, rotation: np.ndarray, shift: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the score of one pose and the match of each place."""
    scores, match = _scores(search, rotation[None], shift[None])
    return float(scores[0]), match[0]


def _refine(search: _Search, rotation: np.ndarray, shift: np.ndarray, rounds: int = 3) -> Pose:
    """Fit the matches of a pose onto each other as long as the score increases."""
    score, match = _score(search, rotation, shift)
    for _ in range(rounds):
        met = match >= 0
        if met.sum() < 3:
            break
        weight = np.maximum(search.likelihood[met, match[met]], MIN_LIKELIHOOD_WEIGHT)
        try:
            fitted = rigid_fit(search.points[met], search.tree.data[match[met]], weight)
        except InputError:  # matches on a line do not determine a pose
            break
        better, changed = _score(search, *fitted)
        if better <= score:
            break
        (rotation, shift), score, match = fitted, better, changed
    return Pose(score, rotation, shift, match)


def rigid_fit(a: np.ndarray, b: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fit one set of points onto another by weighted least squares [1]_.

    Parameters
    ----------
    a, b : (n, 3) float64, Å
    weight : (n,) float64

    Returns
    -------
    rotation, shift : (3, 3) and (3,) float64, so that a @ rotation + shift is nearest to b

    Raises
    ------
    InputError : several rotations fit equally well, since the points lie on a line

    References
    ----------
    .. [1] Kabsch, Acta Cryst. A 32:922 (1976).
    """
    weight = weight / weight.sum()
    middle_a, middle_b = weight @ a, weight @ b
    rotation, distance = best_rotations(((a - middle_a) * weight[:, None]).T @ (b - middle_b))
    if distance < MIN_DISTANCE_FROM_LINE:
        raise InputError(
            "the points to fit lie on a line, or are a mirror image, so that several rotations fit equally well: use more points."
        )
    return rotation, middle_b - middle_a @ rotation
