"""A site of several places found as a whole: the pose that lays it on a target so that most places agree.

Two places with their normals fix a pose. Poses come from pairs of likely matches whose distance and normals agree on both
sides; each is scored by what the numbers say of the target's place that every place of the site then meets.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

CANDIDATES = 12  # likeliest matches of each place, from which poses come
PAIRS = 4000  # of them that are tried, the likeliest first
APART = (4.0, 25.0)  # Å, between the two places of a pair
AGREE = 1.5  # Å, by which their distances may differ
ALIKE = 0.35  # by which cosines between their normals may differ
REACH = 2.5  # Å; a place of the site meets places of the target within this
SAME_SIDE = 0.3  # least cosine between their normals
BEST = 20  # poses that are refined


class Pose(NamedTuple):
    """x -> x @ turn + shift lays the site on the target.

    score : float, sum of the likelihoods of the matches
    turn, shift : (3, 3) and (3,) float64, Å
    match : (Q,) int64, place of the target that each place of the site meets; -1 for none
    """

    score: float
    turn: np.ndarray
    shift: np.ndarray
    match: np.ndarray


def best_pose(points, normals, target_points, target_normals, likelihood):
    """The pose of highest score.

    Parameters
    ----------
    points, normals : (Q, 3), of the site, Å
    target_points, target_normals : (T, 3)
    likelihood : (Q, T) float, how likely each place of the target is the same as that of the site, above 0 if at all

    Returns
    -------
    Pose; one of score 0 without matches where no two of them agree
    """
    few = min(CANDIDATES, likelihood.shape[1])
    place = np.argpartition(-likelihood, few - 1, axis=1)[:, :few]
    first, second = _pairs(points, normals, target_points, target_normals, likelihood, place)
    if len(first[0]) == 0:
        return Pose(0.0, np.eye(3), np.zeros(3), np.full(len(points), -1))
    tree = cKDTree(target_points)
    turns, shifts = _poses(points, normals, target_points, target_normals, first, second)
    scores = _scores(points, normals, tree, target_normals, likelihood, turns, shifts)[0]
    refined = [
        _refined(points, normals, tree, target_normals, likelihood, turns[k], shifts[k])
        for k in np.argsort(-scores, kind="stable")[:BEST]
    ]
    return max(refined, key=lambda pose: pose.score)


def _pairs(points, normals, target_points, target_normals, likelihood, place):
    """Pairs of matches (i, a), (j, b) that agree, the likeliest first: two tuples of int arrays."""
    n, k = place.shape
    i, a = np.repeat(np.arange(n), k), place.ravel()
    own = likelihood[i, a]
    strong = np.argsort(-own, kind="stable")[: max(2, int(np.sqrt(40 * PAIRS)))]
    i, a, own = i[strong], a[strong], own[strong]
    p, q = np.triu_indices(len(i), 1)
    gap = np.linalg.norm(points[i[p]] - points[i[q]], axis=1)
    there = np.linalg.norm(target_points[a[p]] - target_points[a[q]], axis=1)
    fine = (gap > APART[0]) & (gap < APART[1]) & (np.abs(gap - there) < AGREE)
    p, q = p[fine], q[fine]
    cosine = np.einsum("ij,ij->i", normals[i[p]], normals[i[q]])
    cosine_there = np.einsum("ij,ij->i", target_normals[a[p]], target_normals[a[q]])
    fine = np.abs(cosine - cosine_there) < ALIKE
    p, q = p[fine], q[fine]
    order = np.argsort(-(own[p] + own[q]), kind="stable")[:PAIRS]
    return (i[p[order]], a[p[order]]), (i[q[order]], a[q[order]])


def _poses(points, normals, target_points, target_normals, first, second):
    """Turns (H, 3, 3) and shifts (H, 3) that lay the frames of pairs on each other."""
    (i, a), (j, b) = first, second
    own = _frames(points[i], points[j], normals[i] + normals[j])
    there = _frames(target_points[a], target_points[b], target_normals[a] + target_normals[b])
    turns = np.swapaxes(own, 1, 2) @ there
    middle = (points[i] + points[j]) / 2
    shifts = (target_points[a] + target_points[b]) / 2 - np.einsum("hi,hij->hj", middle, turns)
    return turns, shifts


def _frames(first, second, up):
    """Rows of right-handed frames: along the pair, across it, and up as far as that allows."""
    along = second - first
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    up = up - np.einsum("ij,ij->i", up, along)[:, None] * along
    up = up / np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-9)
    return np.stack([along, np.cross(up, along), up], axis=1)


def _scores(points, normals, tree, target_normals, likelihood, turns, shifts):
    """Scores (H,) of poses, and the match of each place (H, Q)."""
    gap, match = tree.query(points @ turns + shifts[:, None], distance_upper_bound=REACH)
    place = np.where(np.isfinite(gap), match, 0)
    cosine = np.einsum("hij,hij->hi", normals @ turns, target_normals[place])
    met = np.isfinite(gap) & (cosine > SAME_SIDE)
    own = np.where(met, likelihood[np.arange(len(points)), place], 0)
    return own.sum(axis=1), np.where(met, place, -1)


def _score(points, normals, tree, target_normals, likelihood, turn, shift):
    """Score of one pose and the match of each place."""
    scores, match = _scores(points, normals, tree, target_normals, likelihood, turn[None], shift[None])
    return float(scores[0]), match[0]


def _refined(points, normals, tree, target_normals, likelihood, turn, shift, rounds=3):
    """The pose after fitting its matches on each other, as long as the score grows."""
    score, match = _score(points, normals, tree, target_normals, likelihood, turn, shift)
    for _ in range(rounds):
        met = match >= 0
        if met.sum() < 3:
            break
        new = rigid_fit(points[met], tree.data[match[met]], np.maximum(likelihood[met, match[met]], 0.05))
        better, changed = _score(points, normals, tree, target_normals, likelihood, *new)
        if better <= score:
            break
        (turn, shift), score, match = new, better, changed
    return Pose(score, turn, shift, match)


def rigid_fit(a, b, weight):
    """Turn and shift with a @ turn + shift nearest to b, weighted (Kabsch, Acta Cryst. A 32:922, 1976)."""
    weight = weight / weight.sum()
    middle_a, middle_b = weight @ a, weight @ b
    u, _, vt = np.linalg.svd(((a - middle_a) * weight[:, None]).T @ (b - middle_b))
    turn = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ vt))]) @ vt
    return turn, middle_b - middle_a @ turn
