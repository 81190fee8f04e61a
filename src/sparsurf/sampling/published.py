"""The paper's roughness-dependent sampling, and the random subset it is compared with.

The surface is covered with patches once (`build_cover`), since the cover depends neither on the parameters nor on chance.
Each combination and draw is then one pass over the (centre, dot) pairs.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from sparsurf.kernels import njit
from sparsurf.patches.index import R_PATCH, PatchIndex, ball_bound
from sparsurf.patches.islands import patch_of
from sparsurf.surfaces.vectors import point, slots, squared_distance

BITS = 64  # of a word
PAIRS_PER_BLOCK = 1 << 16  # pairs drawn at a time, so that their random numbers stay in a core's cache


class Cover(NamedTuple):
    """The centres of a surface and the dots that each of them may keep; see `build_cover`."""

    centre: np.ndarray  # (C,) int32, dot that represents each patch and is always kept
    origin: np.ndarray  # (C,) int32, dot from which r_ij is measured
    roughness: np.ndarray  # (C,) float64, R_i of each patch
    start: np.ndarray  # (C + 1,) int64, pairs of patch c are start[c]:start[c + 1]
    dot: np.ndarray  # (P,) int32, dot of each pair
    log_ratio: np.ndarray  # (P,) float64, -ln(r_ij / r_patch); +inf at the centre itself
    n_dots: int  # N


class SampledSurface(Protocol):
    """A surface from which dots are chosen; `evaluation.prepared_surface.PreparedSurface` is one.

    Attributes
    ----------
    points, normals : (N, 3) float64, Å and unit vectors
    index : PatchIndex
    roughness : (N,) float64, R_i of every dot
    cover, corrected_cover : Cover
        Patches of the published sampling, and those without its two defects.
    """

    @property
    def points(self) -> np.ndarray:
        """Positions of the dots."""

    @property
    def normals(self) -> np.ndarray:
        """Outward unit normals of the dots."""

    @property
    def index(self) -> PatchIndex:
        """Index of the neighbours of each dot."""

    @property
    def roughness(self) -> np.ndarray:
        """R_i of every dot."""

    @property
    def cover(self) -> Cover:
        """Patches of the published sampling."""

    @property
    def corrected_cover(self) -> Cover:
        """Patches of the sampling without the two defects of the published one."""


def build_cover(
    index: PatchIndex,
    roughness: np.ndarray,
    radius: float = R_PATCH,
    distance_from_moved_centre: bool = True,
    chance_in_every_patch: bool = True,
) -> Cover:
    """Cover the surface with patches until every dot lies in one.

    Dots are visited in index order; a dot that lies in no earlier patch starts a new one. If the island of that patch does not
    contain the dot itself, the centre moves to the dot of the patch that is nearest to it.

    `roughness` is R_i by dot, `radius` r_patch in Å. As in the authors' code, `distance_from_moved_centre` measures r_ij from
    the patch's centre, which may have moved, so that it can exceed r_patch and p can exceed 1; otherwise from the dot that
    started the patch. As there, `chance_in_every_patch` gives a dot a chance in every patch that contains it; otherwise only
    in the first.
    """
    radius = float(radius)  # an int would compile the kernels again
    max_dots = ball_bound(index, index.xyz, radius) + 1
    starter, centre, start, dot, log_ratio = _sweep(
        index, radius, distance_from_moved_centre, chance_in_every_patch, max_dots
    )
    origin = centre if distance_from_moved_centre else starter
    return Cover(centre, origin, roughness[starter], start, dot, log_ratio, len(roughness))


@njit()
def _sweep(
    index: PatchIndex,
    radius: float,
    distance_from_moved_centre: bool,
    chance_in_every_patch: bool,
    max_dots: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return starter, centre and start of every patch, and dot and -ln(r / r_patch) of every pair."""
    n = len(index.dot)
    nearby, queue = np.empty(max_dots, np.int32), np.empty(max_dots, np.int32)
    mark, covered = np.zeros(n + 1, np.uint8), np.zeros(n, np.bool_)
    starter, centre, start = np.empty(n, np.int32), np.empty(n, np.int32), np.zeros(n + 1, np.int64)
    dot, log_ratio = np.empty(4 * n + max_dots, np.int32), np.empty(4 * n + max_dots)
    patches = pairs = 0
    # The order of the file, as in the authors' code: another order gives other patches (docs/method.md)
    for i in range(n):
        p = np.intp(index.position[i])
        if covered[p]:
            continue
        begin, end = patch_of(index, p, radius, nearby, mark, queue)
        c = _nearest_of_patch(index, p, queue, begin, end)
        origin = point(index.xyz, c if distance_from_moved_centre else p)
        if pairs + end - begin > len(dot):
            dot = np.concatenate((dot, np.empty(len(dot) + max_dots, np.int32)))
            log_ratio = np.concatenate((log_ratio, np.empty(len(log_ratio) + max_dots)))
        for k in range(begin, end):
            j = queue[k]
            if chance_in_every_patch or not covered[j]:
                r = math.sqrt(squared_distance(point(index.xyz, j), origin))
                dot[pairs] = index.dot[j]
                # As logarithms, p of a pair is a product: a draw then needs no power, which would take most of its time
                log_ratio[pairs] = -math.log(r / radius) if r > 0 else np.inf
                pairs += 1
            covered[j] = True
        starter[patches], centre[patches] = i, index.dot[c]
        patches += 1
        start[patches] = pairs
    return (
        starter[:patches].copy(),
        centre[:patches].copy(),
        start[: patches + 1].copy(),
        dot[:pairs].copy(),
        log_ratio[:pairs].copy(),
    )


@njit()
def _nearest_of_patch(index: PatchIndex, p: int | np.integer, queue: np.ndarray, begin: int, end: int) -> int:
    """Return the position in the patch that is nearest to p (p itself if it is in the patch); on a tie the lower dot."""
    best, best_d2 = queue[begin], np.inf
    for k in range(begin, end):
        d2 = squared_distance(point(index.xyz, queue[k]), point(index.xyz, p))
        if d2 < best_d2 or (d2 == best_d2 and index.dot[queue[k]] < index.dot[best]):
            best, best_d2 = queue[k], d2
    return best


def expected_n_s(cover: Cover, combinations: ArrayLike) -> np.ndarray:
    """Compute the expected number of kept dots of combinations (K, 4), sum_j [1 - prod_i (1 - p_ij)], (K,)."""
    combinations = np.ascontiguousarray(combinations, np.float64)
    out = np.empty(len(combinations))
    # Equal gamma and delta in a row, since the kernel computes their powers once
    by_power = np.lexsort((combinations[:, 3], combinations[:, 2]))
    out[by_power] = _expected_n_s(cover, combinations[by_power])
    return out


@njit()
def _expected_n_s(cover: Cover, combinations: np.ndarray) -> np.ndarray:
    """Compute the expected numbers; (r / r_patch)^power is reused while gamma and delta are those of the previous row."""
    out = np.empty(len(combinations))
    decay, not_kept = np.empty(len(cover.dot)), np.empty(cover.n_dots)
    for k in range(len(combinations)):
        alpha, beta, gamma, delta = combinations[k]
        if k == 0 or gamma != combinations[k - 1, 2] or delta != combinations[k - 1, 3]:
            for c in range(len(cover.centre)):
                power = gamma * (1.0 + cover.roughness[c]) + delta
                for q in slots(cover.start, c):
                    decay[q] = math.exp(-power * cover.log_ratio[q]) if power > 0 else 1.0
        not_kept[:] = 1.0
        for c in range(len(cover.centre)):
            p_at_edge = alpha * (1.0 - cover.roughness[c]) ** beta
            for q in slots(cover.start, c):
                # p exceeds 1 beyond r_patch of a centre that moved, and the authors' code keeps such a dot for certain
                not_kept[np.uintp(cover.dot[q])] *= 1.0 - min(p_at_edge * decay[q], 1.0)
        for c in range(len(cover.centre)):
            not_kept[cover.centre[c]] = 0.0
        out[k] = cover.n_dots - not_kept.sum()
    return out


@njit()
def _log_p(alpha: float, beta: float, gamma: float, delta: float, r: float) -> tuple[float, float]:
    """Return log_a and power: ln p of a pair is log_a - power * log_ratio (paper, eq. 2), with 0^0 = 1."""
    flat = 1.0 - r
    log_a = math.log(alpha)
    if beta > 0:
        log_a += beta * math.log(flat) if flat > 0 else -np.inf
    return log_a, gamma * (1.0 + r) + delta


def sample_cover(cover: Cover, combination: Sequence[float], rng: np.random.Generator) -> np.ndarray:
    """Draw one subset by the roughness-dependent sampling (paper, eq. 2); return its dots, ascending.

    A pair is kept when a uniform random number lies below p; its -ln is exponentially distributed, so no power is needed.
    """
    alpha, beta, gamma, delta = map(float, combination)
    keep = np.zeros(cover.n_dots, np.bool_)
    # Blocks end with a patch; each pair gets the same number wherever they end
    block = np.unique(np.searchsorted(cover.start, np.arange(0, cover.start[-1], PAIRS_PER_BLOCK)))
    random = np.empty(PAIRS_PER_BLOCK + np.diff(cover.start).max())
    for first, last in zip(block, [*block[1:], len(cover.centre)], strict=True):
        rng.standard_exponential(out=random[: cover.start[last] - cover.start[first]])
        _sample(cover, first, last, alpha, beta, gamma, delta, random, keep)
    return np.flatnonzero(keep)


@njit()
def _sample(
    cover: Cover,
    first: int,
    last: int,
    alpha: float,
    beta: float,
    gamma: float,
    delta: float,
    random: np.ndarray,
    keep: np.ndarray,
) -> None:
    """Mark the dots that the patches of centres first:last keep, with one exponential number per pair."""
    dot, log_ratio, before = cover.dot, cover.log_ratio, cover.start[first]
    for c in range(first, last):
        log_a, power = _log_p(alpha, beta, gamma, delta, cover.roughness[c])
        for q in slots(cover.start, c):
            pair = np.uintp(q)
            minus_log_p = power * log_ratio[pair] - log_a if power > 0 else -log_a
            keep[np.uintp(dot[pair])] |= random[np.uintp(q - before)] > minus_log_p
        keep[cover.centre[c]] = True


class SubsetsOfDraw(NamedTuple):
    """Subsets of K combinations that were drawn from the same random numbers; see `sample_together`."""

    levels: np.ndarray  # (G, N) unsigned, by group of equal beta, gamma and delta, and by dot
    group: np.ndarray  # (K,) int64, group of each combination
    level: np.ndarray  # (K,) int64, its alpha in its group: its subset holds the dots of at most this level

    def subset(self, k: int) -> np.ndarray:
        """Return the dots of combination k, ascending."""
        return np.flatnonzero(self.levels[self.group[k]] <= self.level[k])

    def sizes(self) -> np.ndarray:
        """Return n_S of each combination, (K,) int64."""
        return np.array(
            [np.count_nonzero(self.levels[g] <= s) for g, s in zip(self.group, self.level, strict=True)]
        )

    def words(self, dots: np.ndarray, k: Sequence[int] | np.ndarray) -> np.ndarray:
        """Return the subsets of combinations `k` as bits, (len(k) / 64, len(dots)) uint64, dot by dot of `dots`."""
        bits = np.zeros((-(-len(k) // BITS), len(dots)), np.uint64)
        for bit, combination in enumerate(k):
            _set_bits(
                self.levels[self.group[combination]],
                self.level[combination],
                dots,
                np.uint64(1 << bit % BITS),
                bits[bit // BITS],
            )
        return bits


def sample_together(cover: Cover, combinations: ArrayLike, random: np.ndarray) -> SubsetsOfDraw:
    """Draw a subset of each of many combinations (K, 4) from the same random numbers (paper, eq. 2).

    `random`, (P,), is an exponential random number for each pair (centre, dot). Combinations then differ by what they are, and
    less by chance; those of equal beta, gamma and delta are nested in alpha, and share one pass over the pairs.
    """
    combinations = np.asarray(combinations, float).reshape(-1, 4)
    groups, group, of_group = np.unique(combinations[:, 1:], axis=0, return_inverse=True, return_counts=True)
    group, level = group.reshape(-1), np.empty(len(combinations), int)
    levels = np.empty((len(groups), cover.n_dots), np.min_scalar_type(of_group.max(initial=0)))
    for k, (beta, gamma, delta) in enumerate(groups.tolist()):
        alphas, level[group == k] = np.unique(combinations[group == k, 0], return_inverse=True)
        _enter(cover, beta, gamma, delta, np.log(alphas), random, levels[k])
    return SubsetsOfDraw(levels, group, level)


@njit()
def _set_bits(level: np.ndarray, highest: int, dots: np.ndarray, bit: np.uint64, word: np.ndarray) -> None:
    """Set a bit in the words of the dots whose level is at most `highest`."""
    for k in range(len(dots)):
        if level[dots[k]] <= highest:
            word[k] |= bit


@njit()
def _enter(
    cover: Cover,
    beta: float,
    gamma: float,
    delta: float,
    log_alphas: np.ndarray,
    random: np.ndarray,
    level: np.ndarray,
) -> None:
    """Write the level of each dot: that of the smallest alpha with which one of its pairs keeps it; 0 for a centre."""
    least = np.full(cover.n_dots, np.inf)  # ln alpha above which the dot is kept
    for c in range(len(cover.centre)):
        log_a, power = _log_p(1.0, beta, gamma, delta, cover.roughness[c])
        for q in slots(cover.start, c):
            pair = np.uintp(q)
            minus_log_p = power * cover.log_ratio[pair] - log_a if power > 0 else -log_a
            dot = np.uintp(cover.dot[pair])
            least[dot] = min(least[dot], minus_log_p - random[pair])
    for k in range(cover.n_dots):
        s = 0
        while s < len(log_alphas) and not least[k] < log_alphas[s]:
            s += 1
        level[k] = s
    for c in range(len(cover.centre)):
        level[cover.centre[c]] = 0


def uniform_subset(n_dots: int, n_s: int, rng: np.random.Generator) -> np.ndarray:
    """Draw a uniform random subset of exactly `n_s` of `n_dots` dots; (n_s,) int64, ascending."""
    keep = np.zeros(n_dots, np.bool_)
    keep[rng.choice(n_dots, n_s, replace=False, shuffle=False)] = True
    return np.flatnonzero(keep)  # ascending, and faster than sorting


def parameter_grid(
    alpha: Sequence[float], beta: Sequence[float], gamma: Sequence[float], delta: Sequence[float], **_: object
) -> np.ndarray:
    """Return all combinations of the lists in a config's `sampling`, (K, 4) float64; the last parameter varies fastest."""
    return np.array(np.meshgrid(alpha, beta, gamma, delta, indexing="ij"), np.float64).reshape(4, -1).T
