"""Find a site on other surfaces, place by place or as a whole."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.special import expit

from sparsurf import InputError
from sparsurf.sites.describing import FIELDS, LABELS, PERCENT, RADIUS, Sites
from sparsurf.sites.metric import to_metric_space
from sparsurf.sites.pose_search import DECIMALS, Pose, best_pose
from sparsurf.threads import parallel_map

MIN_HIT_DISTANCE = 3.0  # Å; of closer hits only the best is reported
N_BACKGROUND = 20_000  # places of the targets from which the distances of unrelated places are estimated
MAX_PLACES = 40  # places of a site that are superposed onto a target; more take longer and do not help
MIN_SCORE = 1.0  # of a match that supports a pose
# In the metric space, where unrelated places have distances of about 10; stored numbers have rounding errors of this size
MIN_DISTANCE = 1e-3
NEAR = 5.0  # standard deviations below the median; log distances of unrelated places are larger
CANCELLED = 1e-3  # relative to the norms; smaller squares are recomputed from differences
ROUNDING = 1e-9  # of distances; smaller differences are ignored
PAIRS_AT_ONCE = 65536
MIRROR = np.array([-1.0, 1.0, 1.0])  # factors that reflect a site
MIN_LEVEL = 0.1  # lower limit of the score of a mirror image in the width of p
BLOCK = 16384  # places that are searched at a time: 3 MB of distances for 50 queries
CALIBRATED = {  # settings of Sites for which p was calibrated
    "fields": list(FIELDS),
    "percent": float(PERCENT),
    "radius": RADIUS,
}
COLUMNS = ("query", "rank", "target", *LABELS, "x", "y", "z", "score")
_MATCHED = [f"{key}{end}" for end in ("", "_there") for key in (*LABELS, "x", "y", "z")]


class SiteHits(NamedTuple):
    """Hits of a whole site.

    table : DataFrame with COLUMNS, `query` being its name, `p` (see `chance`) and `places`, the number of places of the
        site that agree
    poses : list of pose_search.Pose, one for each row
    places : Sites, the places of the site that the poses superpose onto the targets
    mirrored : (T,) float64, scores of the mirror image of the site, one for each row
    """

    table: pd.DataFrame
    poses: list[Pose]
    places: Sites
    mirrored: np.ndarray


def find_places(
    query: Sites,
    targets: Sequence[Sites],
    n: int = 10,
    threads: int = 1,
    learned: dict[str, np.ndarray] | None = None,
) -> pd.DataFrame:
    """Find the best hits of each place of a query.

    Parameters
    ----------
    query : Sites
    targets : sequence of Sites with the same settings
    n : int, hits of each place
    threads : int
    learned : dict, see `metric.to_metric_space`

    Returns
    -------
    DataFrame with COLUMNS, by query and rank. `score` is the number of standard deviations by which the logarithm of the
    distance lies below that of unrelated places.
    """
    q, pooled = _in_metric_space(query, targets, learned)
    middle, scale = _background(q, pooled)
    sizes = [len(target) for target in targets]
    owner = np.repeat(np.arange(len(targets)), sizes)
    begin = np.concatenate([[0], np.cumsum(sizes)])
    hits: dict[int, list[tuple]] = {}
    open_queries, k = np.arange(len(q)), 8 * n
    while len(open_queries):
        k = min(k, len(pooled))
        distance, index = nearest_places(q[open_queries], pooled, k, threads)
        nearness = -np.log(np.maximum(distance, MIN_DISTANCE))
        score = (middle[open_queries, None] + nearness) / scale[open_queries, None]
        for i, near, scores in zip(open_queries.tolist(), index, score, strict=True):
            hits[i] = _separated_hits(i, n, targets, owner[near], near - begin[owner[near]], scores)
        if k == len(pooled):
            break
        open_queries = open_queries[[len(hits[i]) < n for i in open_queries.tolist()]]
        k *= 4
    return pd.DataFrame([row for i in range(len(q)) for row in hits[i]], columns=COLUMNS)


def _separated_hits(
    query: int,
    n: int,
    targets: Sequence[Sites],
    owners: np.ndarray,
    places: np.ndarray,
    scores: np.ndarray,
) -> list[tuple]:
    """Return the n best hits of a place that are not close to a better one, from places sorted by score."""
    taken: list[tuple[int, np.ndarray]] = []
    rows: list[tuple] = []
    for owner, index, score in zip(owners, places, scores, strict=True):
        at = targets[owner].points[index]
        near_better = any(owner == o and np.linalg.norm(at - x) < MIN_HIT_DISTANCE for o, x in taken)
        if len(rows) < n and not near_better:
            taken.append((owner, at))
            rows.append(_row(query, len(taken), targets[owner], index, score))
    return rows


def nearest_places(
    query: np.ndarray, targets: np.ndarray, k: int, threads: int = 1
) -> tuple[np.ndarray, np.ndarray]:
    """Find the k places nearest to each query, exactly.

    A matrix product in float32 preselects, in blocks, all places that can be among them. Their distances are then computed
    from differences in float64.

    Parameters
    ----------
    query : (Q, M) float64
    targets : (P, M) float64, P >= k
    k : int
    threads : int

    Returns
    -------
    distance : (Q, k) float64, ascending except for differences below ROUNDING
    index : (Q, k) int64; for equal distances in ascending order
    """
    double, lengths = (-2 * query).astype(np.float32), np.linalg.norm(query, axis=1)
    rounding = (query.shape[1] + 8) * np.finfo(np.float32).eps

    def near(a: int, b: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return query, place and distance of all pairs of one block that can be among the k nearest."""
        norms = np.einsum("ij,ij->i", targets[a:b], targets[a:b])
        square = double @ targets[a:b].astype(np.float32).T
        square += norms.astype(np.float32)
        bound = np.full(len(query), np.inf)
        if k < b - a:
            error = rounding * (lengths + np.sqrt(norms.max())) ** 2
            bound = np.partition(square, k - 1, axis=1)[:, k - 1] + 2 * error
        row, index = np.nonzero(square <= bound[:, None])
        distance = np.empty(len(row))
        for begin in range(0, len(row), PAIRS_AT_ONCE):
            part = slice(begin, begin + PAIRS_AT_ONCE)
            distance[part] = np.linalg.norm(query[row[part]] - targets[a + index[part]], axis=1)
        return row, index + a, distance

    blocks = parallel_map(near, len(targets), threads, BLOCK)
    row, index, distance = (np.concatenate([block[c] for block in blocks]) for c in range(3))
    order = np.lexsort((index, np.round(distance / ROUNDING), row))
    first = np.searchsorted(row[order], np.arange(len(query)))
    kept = order[first[:, None] + np.arange(k)]
    return distance[kept], index[kept]


def find_site(
    query: Sites,
    targets: Sequence[Sites],
    n: int = 10,
    learned: dict[str, np.ndarray] | None = None,
) -> SiteHits:
    """Find a query as a whole, all its places in one arrangement, with one hit per target.

    Parameters
    ----------
    query, targets, n, learned : as for `find_places`; the query has at least three places

    Returns
    -------
    SiteHits; `score` is the sum of the scores of the places that agree, divided by the number of all places

    Raises
    ------
    InputError : the query has fewer than three places
    """
    site, query = query, superposed_places(query)
    hits, mirrored = _best_poses(query, targets, learned)
    scores = np.array([pose.score for pose in hits]) / len(query)
    by_chance = np.array(mirrored) / len(query)
    p = chance(scores, by_chance, len(site), null())
    if any(site.settings[key] != value for key, value in CALIBRATED.items()):
        p[:] = np.nan
    order = sorted(range(len(targets)), key=lambda k: -round(hits[k].score, DECIMALS))[:n]
    rows = []
    for rank, k in enumerate(order, 1):
        pose, target = hits[k], targets[k]
        centre = query.points.mean(axis=0) @ pose.rotation + pose.shift
        nearest = int(np.argmin(np.linalg.norm(target.points - centre, axis=1)))
        row = _row(site.name, rank, target, nearest, scores[k])
        rows.append((*row[:6], *centre, *row[9:], p[k], int((pose.match >= 0).sum())))
    table = pd.DataFrame(rows, columns=(*COLUMNS, "p", "places"))
    return SiteHits(table, [hits[k] for k in order], query, by_chance[order])


def superposed_places(site: Sites) -> Sites:
    """Return at most MAX_PLACES places of a site, as far from one another as possible, which are superposed onto targets.

    Raises
    ------
    InputError : the site has fewer than three places
    """
    if len(site) < 3:
        raise InputError(
            f"the site has {len(site)} places, but an arrangement needs 3; select more residues."
        )
    return site if len(site) <= MAX_PLACES else site.take(_farthest_points(site.points, MAX_PLACES))


def _best_poses(
    query: Sites, targets: Sequence[Sites], learned: dict[str, np.ndarray] | None
) -> tuple[list[Pose], list[float]]:
    """Return the best pose of a site on each target, and the scores of its mirror image there."""
    q, pooled = _in_metric_space(query, targets, learned)
    middle, scale = _background(q, pooled)
    points, normals = query.points.astype(float), query.normals.astype(float)
    begin, poses, mirrored = 0, [], []
    for target in targets:
        numbers = pooled[begin : begin + len(target)]
        begin += len(target)
        likelihood = likelihoods(log_distances(q, numbers), middle, scale)
        of_target = target.points.astype(float), target.normals.astype(float)
        poses.append(best_pose(points, normals, *of_target, likelihood))
        mirrored.append(best_pose(points * MIRROR, normals * MIRROR, *of_target, likelihood).score)
    return poses, mirrored


def matched(hits: SiteHits, targets: Sequence[Sites]) -> pd.DataFrame:
    """Tabulate the matching places of a site and each target.

    Parameters
    ----------
    hits : SiteHits
    targets : sequence of Sites that were searched

    Returns
    -------
    DataFrame, one row per matching place: rank, target; LABELS, x, y, z of the site's place; the same for the target's place,
    with the suffix `_there`
    """
    rows, by_name = [], {target.name: target for target in targets}
    for row, pose in zip(hits.table.to_dict("records"), hits.poses, strict=True):
        indices = np.flatnonzero(pose.match >= 0)
        here, there = hits.places.take(indices), by_name[row["target"]].take(pose.match[indices])
        parts = [part for sites in (here, there) for part in (sites.labels, pd.DataFrame(sites.points))]
        table = pd.concat(parts, axis=1).set_axis(_MATCHED, axis=1)
        rows.append(table.assign(rank=row["rank"], target=row["target"]))
    return pd.concat(rows)[["rank", "target", *_MATCHED]]


@cache
def null() -> np.ndarray:
    """Read the constants (3,) of `chance`, fitted by evidence/calibrate_sites.py."""
    return np.loadtxt(Path(__file__).with_name("null.csv"), delimiter=",", skiprows=1)


def chance(scores: np.ndarray, mirrored: np.ndarray, n_places: int, constants: np.ndarray) -> np.ndarray:
    """Compute the probability that an unrelated protein scores as high.

    The mirror image of a site has the same numbers at its places, but matches a protein only by chance. Its score is therefore
    the score of this site on this target that chance explains. On unrelated targets the difference has a logistic
    distribution, whose width depends on the number of places and on the score of the mirror image.

    Parameters
    ----------
    scores, mirrored : (T,) float64
        Scores of the site and of its mirror image.
    n_places : int
    constants : (3,) float64
        Logarithm of the width for MAX_PLACES places and a score of 1, and the powers of both.

    Returns
    -------
    p : (T,) float64, above 0; 1 where no place of the site matches
    """
    log_width, of_places, of_score = constants
    level = np.maximum(mirrored, MIN_LEVEL)
    width = np.exp(log_width) * (n_places / MAX_PLACES) ** of_places * level**of_score
    p = np.maximum(expit((mirrored - scores) / width), np.finfo(float).tiny)
    return np.where(scores > 0, p, 1.0)


def check_alike(query: Sites, targets: Sequence[Sites]) -> None:
    """Check that all Sites were described with the same settings.

    Raises
    ------
    InputError : a target lacks a field of the query, or differs in a setting
    """
    for target in targets:
        lacking = [name for name in query.fields if name not in target.fields]
        if lacking:
            raise InputError(
                f"{target.name} has no {', '.join(lacking)}, which the query has; describe both with the same fields."
            )
        for key in ("fields", "percent", "radius", "order"):
            if target.settings[key] != query.settings[key]:
                raise InputError(
                    f"{target.name} was described with {key} {target.settings[key]}, and the query with "
                    f"{query.settings[key]}; use the same settings for both."
                )


def _in_metric_space(
    query: Sites, targets: Sequence[Sites], learned: dict[str, np.ndarray] | None
) -> tuple[np.ndarray, np.ndarray]:
    """Transform the numbers of the query (Q, M) and of all targets, one after the other (P, M)."""
    check_alike(query, targets)
    if not targets:
        raise InputError("targets: there are none; give at least one.")
    return (
        to_metric_space(query.numbers, query.fields, learned),
        np.concatenate([to_metric_space(target.numbers, target.fields, learned) for target in targets]),
    )


def _background(q: np.ndarray, pooled: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the `background` (Q,), (Q,) of a query among the places of all targets."""
    return background(log_distances(q, pooled[:: background_stride(len(pooled))]))


def background_stride(n: int) -> int:
    """Return the stride by which about N_BACKGROUND of n places are taken."""
    return max(1, n // N_BACKGROUND)


def background(log_distance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return median and standard deviation (Q,) of log distances (Q, P) from each query to places that are mostly unrelated.

    Places as near as those of the same site are excluded from the standard deviation, which would otherwise depend on whether
    the protein of the query is among the targets.
    """
    middle = np.median(log_distance, axis=1)
    deviation = log_distance - middle[:, None]
    upper = np.sqrt(np.mean(deviation**2, axis=1, where=deviation >= 0))
    unrelated = deviation >= -NEAR * upper[:, None]
    return middle, np.maximum(log_distance.std(axis=1, where=unrelated), 1e-6)


def likelihoods(log_distance: np.ndarray, middle: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Return the likelihoods (Q, P) that `best_pose` takes, from log distances and their background (Q,), (Q,)."""
    score = (middle[:, None] - log_distance) / scale[:, None]
    return np.maximum(score - MIN_SCORE, 0).round(DECIMALS)


def log_distances(q: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the logarithm of the distances (Q, P), of at least MIN_DISTANCE; small ones are computed from differences."""
    norms, of_q = (places**2).sum(axis=1), (q**2).sum(axis=1)[:, None]
    square = norms - 2 * q @ places.T + of_q
    row, column = np.nonzero(square < CANCELLED * (norms + of_q))
    square[row, column] = ((q[row] - places[column]) ** 2).sum(axis=1)
    return np.log(np.maximum(np.sqrt(square), MIN_DISTANCE))


def _row(query: int | str, rank: int, target: Sites, index: int, score: float) -> tuple:
    """Return a row of COLUMNS."""
    labels = target.labels.iloc[index]
    return (query, rank, target.name, *labels[list(LABELS)], *target.points[index].tolist(), float(score))


def _farthest_points(points: np.ndarray, n: int) -> np.ndarray:
    """Return indices of n points by farthest-point sampling from the first point."""
    chosen, distance = [0], np.linalg.norm(points - points[0], axis=1)
    while len(chosen) < n:
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.array(chosen)
