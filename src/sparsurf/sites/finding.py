"""Where the places of a site are found again on other surfaces, place by place or as a whole."""

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.sites.arrangement import best_pose
from sparsurf.sites.describing import FIELDS, LABELS, PERCENT, RADIUS, Sites
from sparsurf.sites.weighing import weighed
from sparsurf.threads import parallel_map

SAME = 3.0  # Å; of hits that lie nearer to each other only the best counts
SAMPLE = 20_000  # places of the targets that tell how far apart unrelated places are
MOST = 40  # places of a site that are laid on a target; more make it slower, not surer
LIKELY = 1.0  # score of a match from which on it speaks for a pose
BLOCK = 16384  # places that are searched at once: with 50 queries 3 MB of distances
CALIBRATED = {
    "fields": list(FIELDS),
    "percent": float(PERCENT),
    "radius": RADIUS,
}  # settings of Sites for which p is known
COLUMNS = ("query", "rank", "target", *LABELS, "x", "y", "z", "score")


class Found(NamedTuple):
    """Hits of a whole site.

    table : DataFrame with COLUMNS, `p` (see `chance`) and `places`, the number of places of the site that agree
    poses : list of arrangement.Pose, one for each row
    places : Sites, the places of the site that the poses lay on the targets
    """

    table: pd.DataFrame
    poses: list
    places: Sites


def find_places(query, targets, n=10, threads=1, learned=None):
    """The best hits of each place of a query by itself.

    Parameters
    ----------
    query : Sites, of the places that are sought
    targets : list of Sites with the same settings
    n : int, hits of each place
    threads : int
    learned : dict, see `weighing.weighed`

    Returns
    -------
    DataFrame with COLUMNS, by query and rank. `score`: standard deviations by which the logarithm of the distance lies below
    that of unrelated places.
    """
    q, every = _weighed(query, targets, learned)
    middle, spread = _background(q, every)
    sizes = [len(target) for target in targets]
    owner = np.repeat(np.arange(len(targets)), sizes)
    begin = np.concatenate([[0], np.cumsum(sizes)])
    rows, left, many = {}, np.arange(len(q)), 8 * n
    while len(left):
        many = min(many, len(every))
        distance, place = nearest_places(q[left], every, many, threads)
        score = (middle[left, None] - np.log(np.maximum(distance, 1e-6))) / spread[left, None]
        for i, near, own in zip(left, place, score, strict=True):
            rows[i] = _hits(i, n, targets, owner[near], near - begin[owner[near]], own)
        left = left[[len(rows[i]) < n for i in left]] if many < len(every) else []
        many *= 4
    rows = [row for i in range(len(q)) for row in rows[i]]
    return pd.DataFrame(rows, columns=COLUMNS)


def _hits(query, n, targets, owners, places, scores):
    """Rows of the n best hits of a place, from places that come best first: no two side by side on one target."""
    taken, rows = [], []
    for owner, place, score in zip(owners, places, scores, strict=True):
        at = targets[owner].points[place]
        if len(rows) < n and not any(owner == o and np.linalg.norm(at - x) < SAME for o, x in taken):
            taken.append((owner, at))
            rows.append(_row(query, len(taken), targets[owner], place, score))
    return rows


def nearest_places(query, targets, k, threads=1):
    """The k places nearest to each query, exactly, in blocks of one matrix product each.

    Parameters
    ----------
    query : (Q, M) float32
    targets : (P, M) float32, P >= k
    k : int
    threads : int

    Returns
    -------
    distance : (Q, k) float32, ascending
    place : (Q, k) int64; of equal distances the lower place first
    """
    norms = np.einsum("ij,ij->i", targets, targets)
    double = -2 * query

    def best(a, b):
        square = double @ targets[a:b].T
        square += norms[a:b]
        few = min(k, b - a)
        place = (
            np.argpartition(square, few - 1, axis=1)[:, :few]
            if few < b - a
            else np.tile(np.arange(b - a), (len(query), 1))
        )
        return np.take_along_axis(square, place, axis=1), place + a

    found = parallel_map(best, len(targets), threads, BLOCK)
    square, place = (np.concatenate([part[c] for part in found], axis=1) for c in (0, 1))
    order = np.lexsort((place, square), axis=1)[:, :k]
    square, place = np.take_along_axis(square, order, axis=1), np.take_along_axis(place, order, axis=1)
    own = np.einsum("ij,ij->i", query, query)[:, None]
    return np.sqrt(np.maximum(square + own, 0)), place


def find_site(query, targets, n=10, learned=None):
    """The best hits of a query as a whole: its places in one arrangement, at most one hit on each target.

    Parameters
    ----------
    query, targets, n, learned : as for `find_places`; a query of at least three places

    Returns
    -------
    Found; `score`: sum of the scores of places that agree over the number of all places

    Raises
    ------
    InputError : fewer than three places
    """
    if len(query) < 3:
        raise InputError(f"the site has {len(query)} places, and an arrangement needs 3; name more residues.")
    site = query
    if len(query) > MOST:
        query = query.take(_spread(query.points, MOST))
    q, every = _weighed(query, targets, learned)
    middle, spread = _background(q, every)
    begin, hits = 0, []
    for target in targets:
        own = every[begin : begin + len(target)]
        begin += len(target)
        score = (middle[:, None] - _log_distances(q, own, 1e-12)) / spread[:, None]
        arrays = (each.astype(float) for each in (query.points, query.normals, target.points, target.normals))
        hits.append(best_pose(*arrays, np.maximum(score - LIKELY, 0)))
    order = sorted(range(len(targets)), key=lambda k: -hits[k].score)[:n]
    scores = np.array([pose.score / len(query) for pose in hits])
    p = chance(scores, null_terms(site.points, [len(target) for target in targets]), null())
    if any(site.settings[key] != value for key, value in CALIBRATED.items()):
        p[:] = np.nan
    rows = []
    for rank, k in enumerate(order, 1):
        pose, target = hits[k], targets[k]
        centre = query.points.mean(axis=0) @ pose.turn + pose.shift
        nearest = int(np.argmin(np.linalg.norm(target.points - centre, axis=1)))
        row = _row(0, rank, target, nearest, scores[k])
        rows.append((*row[:6], *centre, *row[9:], p[k], int((pose.match >= 0).sum())))
    return Found(pd.DataFrame(rows, columns=(*COLUMNS, "p", "places")), [hits[k] for k in order], query)


def matched(hits, targets):
    """Which place of a site meets which place of each target.

    Parameters
    ----------
    hits : Found
    targets : list of Sites, those that were searched

    Returns
    -------
    DataFrame, a row per place that agrees: rank, target; LABELS, x, y, z of the site's place; the same of the target's place,
    with `_there` behind the name
    """
    rows, by_name = [], {target.name: target for target in targets}
    for row, pose in zip(hits.table.itertuples(), hits.poses, strict=True):
        own = np.flatnonzero(pose.match >= 0)
        here, there = hits.places.take(own), by_name[row.target].take(pose.match[own])
        parts = (each for one in (here, there) for each in (one.labels, pd.DataFrame(one.points)))
        table = pd.concat(parts, axis=1).set_axis(_MATCHED, axis=1)
        rows.append(table.assign(rank=row.rank, target=row.target))
    return pd.concat(rows)[["rank", "target", *_MATCHED]]


_MATCHED = [f"{key}{end}" for end in ("", "_there") for key in (*LABELS, "x", "y", "z")]


@cache
def null():
    """Constants (6,) of the scores of unrelated proteins, fitted by evidence/calibrate_sites.py."""
    return np.loadtxt(Path(__file__).with_name("null.csv"), delimiter=",", skiprows=1)


def null_terms(points, sizes):
    """Terms (T, 4) that the scores of unrelated targets follow.

    Parameters
    ----------
    points : (Q, 3), places of the site, Å
    sizes : (T,) int, places of the targets
    """
    spread = np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean())
    own = [1.0, np.log(spread / 8.0), np.log(min(len(points), MOST) / MOST)]
    return np.column_stack([np.tile(own, (len(sizes), 1)), np.log(np.asarray(sizes) / 3000.0)])


def chance(scores, terms, constants):
    """How often an unrelated protein scores as high or higher: p, (T,) float64, by Gumbel's distribution of largest values.

    Parameters
    ----------
    scores : (T,) float64
    terms : (T, 4) float64, see `null_terms`
    constants : (6,) float64: of the distribution's location, then of the logarithm of its width
    """
    width = np.exp(terms[:, :2] @ constants[4:])
    return -np.expm1(-np.exp(-(scores - terms @ constants[:4]) / width))


def check_alike(query, targets):
    """Raise InputError where Sites were not described alike."""
    for target in targets:
        lacking = [name for name in query.fields if name not in target.fields]
        if lacking:
            raise InputError(
                f"{target.name} has no {', '.join(lacking)}, which the query has; describe it with it."
            )
        for key in ("fields", "percent", "radius", "order"):
            if target.settings[key] != query.settings[key]:
                raise InputError(
                    f"{target.name} was described with {key} {target.settings[key]}, and the query with "
                    f"{query.settings[key]}; describe both alike."
                )


def _weighed(query, targets, learned):
    check_alike(query, targets)
    if not targets:
        raise InputError("targets: there are none; give one at least.")
    return (
        weighed(query.numbers, query.fields, learned),
        np.concatenate([weighed(target.numbers, target.fields, learned) for target in targets]),
    )


def _background(q, every):
    """Mean and standard deviation of the logarithm of the distance from each query to unrelated places, (Q,) each."""
    some = every[:: max(1, len(every) // SAMPLE)]
    logarithm = _log_distances(q, some, 1e-6)
    return np.median(logarithm, axis=1), np.maximum(logarithm.std(axis=1), 1e-6)


def _log_distances(q, places, least):
    """Logarithm of the distances (Q, P) between numbers, of squares of `least` at least."""
    square = (places**2).sum(axis=1) - 2 * q @ places.T + (q**2).sum(axis=1)[:, None]
    return 0.5 * np.log(np.maximum(square, least))


def _row(query, rank, target, place, score):
    labels = target.labels.iloc[place]
    return (query, rank, target.name, *labels[list(LABELS)], *target.points[place].tolist(), float(score))


def _spread(points, n):
    """Indices of n points that lie far from each other (farthest-point sampling, from the first)."""
    chosen, gap = [0], np.linalg.norm(points - points[0], axis=1)
    while len(chosen) < n:
        chosen.append(int(np.argmax(gap)))
        gap = np.minimum(gap, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.array(chosen)
