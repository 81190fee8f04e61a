"""Find the probe radius and the atomic radii of a surface from the votes of its dots.

A dot p of a solvent-excluded surface with outward normal n has its probe centre at p + probe n. If p is a contact dot of an
atom of radius r, any other probe centre c that touches this atom is r + probe away from p - r n, so that
r = (|p - c|^2 - probe^2) / (2 (probe + n . (p - c))). Each dot votes with the nearest probe centres. The right probe radius
gives sharp peaks at the few radii of the atoms, and any other radius, or a surface that is not made of spheres, gives none.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sparsurf.kernels import njit
from sparsurf.patches.index import build_grid, select_separated
from sparsurf.surfaces.radii import RADII

MIN_DOTS = 100  # fewer dots have peaks by chance
VOTERS = 2000  # dots, of those that there are: 500 give the same probe and radii, and more only take longer
# Nearest dots of a voter, and the nearest of their probe centres with which it votes
CANDIDATES, CENTRES_AND_RADII = 48, 16
CLOSE = 0.8  # Å; of dots closer than this one votes, since the probes of the others touch the same atoms
RADIUS_OF_ATOM = (0.9, 2.3)  # Å, of votes that count
MIN_SLOPE = 0.1  # Å, of |probe + n . (p - c)|, by which a vote is divided
WIDTH = 0.004  # Å, of a peak
PEAKS_OF_SCORE, MAX_PEAKS = 4, 8
TRIED_PROBES = np.arange(80, 201) / 100  # Å, probe radii that are tried; then every 0.001 Å around the best
NEIGHBOURHOOD = (0.025, 0.31)  # Å from the best probe radius, whose scores are compared with the best
# The score of the best probe radius over the median: exact dots 2.4 and more, with noise of 0.003 Å 1.6 to 1.9, surfaces of
# another kind at most 1.4. 150 dots of such a surface can reach 2, but then the score rises by at most 4 standard deviations
# over those of neighbouring probe radii.
MIN_RATIO, MIN_RISE = 1.6, 4.2
SIGMA_PER_MAD = 1.48
MIN_TOLERANCE, MAX_TOLERANCE = 5e-4, 0.015  # Å, of a touch; the former is that of files with four decimals
SHARE_IN_SIGMA, TOLERANCE_PER_SIGMA = 0.68, 2.5
NEAR_PEAK = 0.012  # Å, in which the width of the highest peak is measured
SAME_RADIUS = 0.006  # Å, between a peak and a radius of a table
MIN_EXPLAINED = 0.9  # share of the votes in peaks that the radii of a table explain
# Always among the radii, since rare ones such as sulphur have no peak; hydrogens, where there are any, are never rare.
COMMON_ELEMENTS = ("C", "N", "O", "S", "P")
OWN_RADII = "own"  # name of radii that are in no known table


class SphereModel(NamedTuple):
    """What the dots of a surface say of its spheres; `radii` is empty if they do not lie on spheres."""

    probe: float  # Å, radius
    radii: np.ndarray  # (K,) float64, Å, of atoms, ascending
    table: str  # name of the table of the radii, or 'own', or 'none'
    ratio: float  # score of the probe radius over the median of all
    tolerance: float  # Å, of the distance between a probe and an atom that touch


def model_of(
    points: np.ndarray,
    normals: np.ndarray,
    probe_radius: float | None = None,
    radii: str | Sequence[float] | np.ndarray | None = None,
) -> SphereModel:
    """Return the model of dots (n, 3): the probe radius and the radii, Å, that are given, or those that the dots vote for."""
    if probe_radius is None or radii is None or len(points) < MIN_DOTS:
        return vote(points, normals, probe_radius, radii)
    return known_model(points, normals, probe_radius, radii)


def vote(
    points: np.ndarray,
    normals: np.ndarray,
    probe_radius: float | None = None,
    radii: str | Sequence[float] | np.ndarray | None = None,
) -> SphereModel:
    """Let dots (n, 3) vote for the probe radius and the radii of the atoms, Å, where these are not given."""
    if len(points) < MIN_DOTS:
        return SphereModel(probe_radius or np.nan, np.empty(0), "none", 0.0, np.nan)
    booth = _Booth(points, normals)
    scores = np.array([booth.score(probe, WIDTH) for probe in TRIED_PROBES])
    best = TRIED_PROBES[scores.argmax()]
    distance = np.abs(TRIED_PROBES - best)
    near = scores[(distance > NEIGHBOURHOOD[0]) & (distance < NEIGHBOURHOOD[1])]
    deviation = SIGMA_PER_MAD * np.median(np.abs(scores - np.median(scores)))
    ratio = float(scores.max() / max(np.median(scores), 1))
    rise = (scores.max() - np.median(near)) / max(deviation, 1)
    if ratio < MIN_RATIO or rise < MIN_RISE:
        return SphereModel(probe_radius or float(best), np.empty(0), "none", ratio, np.nan)
    probe = booth.refined(float(best)) if probe_radius is None else probe_radius
    return _model(booth, probe, radii, ratio)


def known_model(
    points: np.ndarray, normals: np.ndarray, probe_radius: float, radii: str | Sequence[float] | np.ndarray
) -> SphereModel:
    """Return the model of dots (n, 3) whose probe radius and radii, Å, are known, so that no gate has to pass."""
    return _model(_Booth(points, normals), probe_radius, radii, np.nan)


def _model(
    booth: _Booth, probe: float, radii: str | Sequence[float] | np.ndarray | None, ratio: float
) -> SphereModel:
    """Return the model with a probe radius, Å: the radii that have peaks, and the tolerance of touches."""
    votes = booth.votes(probe)
    background = len(votes) / (RADIUS_OF_ATOM[1] - RADIUS_OF_ATOM[0])  # votes per Å
    peaks, counts = _peaks(votes.copy(), WIDTH, MAX_PEAKS)
    if len(peaks) == 0 and radii is None:
        return SphereModel(probe, np.empty(0), "none", ratio, np.nan)
    # A peak is clear with six times the votes that its width has by chance, 1 % of the highest, and a dozen
    clear = counts > max(6 * background * WIDTH, 0.01 * counts[0], 12) if len(peaks) else np.empty(0, bool)
    tolerance = _tolerance(votes, peaks[0], background) if clear.any() else MIN_TOLERANCE
    if isinstance(radii, str) or radii is None:
        own_radii, table = _radii_of_peaks(peaks[clear], counts[clear], radii)
    else:
        own_radii, table = np.unique(np.asarray(radii, float)), OWN_RADII
    return SphereModel(probe, own_radii, table, ratio, tolerance)


class _Booth:
    """The dots that vote, and the dots around each."""

    def __init__(self, points: np.ndarray, normals: np.ndarray) -> None:
        from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

        spread = select_separated(build_grid(points), np.arange(len(points)), CLOSE, len(points), 0)
        points, normals, n = points[spread], normals[spread], len(spread)
        self.points, self.normals = points, normals
        self.voters = np.arange(min(n, VOTERS)) * n // min(n, VOTERS)
        near = cKDTree(points).query(points[self.voters], k=min(n, CANDIDATES))[1]
        self.near = np.ascontiguousarray(near, np.int32)

    def votes(self, probe: float) -> np.ndarray:
        """Return all votes for a radius of atoms with one probe radius, Å, ascending."""
        out = np.empty(len(self.voters) * CENTRES_AND_RADII)
        return np.sort(out[: _write_votes(self.points, self.normals, self.voters, self.near, probe, out)])

    def score(self, probe: float, width: float) -> int:
        """Return the number of votes in the highest peaks."""
        return int(_peaks(self.votes(probe), width, PEAKS_OF_SCORE)[1].sum())

    def refined(self, best: float) -> float:
        """Return the mean of the best probe radii, Å, around the best of the coarse ones."""
        fine = np.round(best + np.arange(-10, 11) / 1000, 3)
        scores = np.array([self.score(probe, WIDTH / 2) for probe in fine])
        return round(float(fine[scores > 0.98 * scores.max()].mean()), 3)


@njit()
def _write_votes(
    points: np.ndarray,
    normals: np.ndarray,
    voters: np.ndarray,
    near: np.ndarray,
    probe: float,
    votes: np.ndarray,
) -> int:
    """Write the votes of each voter with the nearest probe centres of the dots near it; return their number."""
    n, nearest, distance2 = 0, np.empty(CENTRES_AND_RADII, np.int64), np.empty(CENTRES_AND_RADII)
    for v in range(len(voters)):
        i, m = voters[v], 0
        for e in range(near.shape[1]):
            j, d2 = near[v, e], 0.0
            for c in range(3):
                d2 += (points[i, c] - points[j, c] - probe * normals[j, c]) ** 2
            if m == CENTRES_AND_RADII and d2 >= distance2[m - 1]:
                continue
            m = min(m + 1, CENTRES_AND_RADII)
            a = m - 1
            while a > 0 and distance2[a - 1] > d2:
                nearest[a], distance2[a] = nearest[a - 1], distance2[a - 1]
                a -= 1
            nearest[a], distance2[a] = j, d2
        for a in range(m):
            j, slope = nearest[a], probe
            for c in range(3):
                slope += normals[i, c] * (points[i, c] - points[j, c] - probe * normals[j, c])
            if abs(slope) > MIN_SLOPE:
                radius = (distance2[a] - probe * probe) / (2.0 * slope)
                if RADIUS_OF_ATOM[0] < radius < RADIUS_OF_ATOM[1]:
                    votes[n] = radius
                    n += 1
    return n


@njit()
def _peaks(votes: np.ndarray, width: float, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Find the n windows of ascending votes that hold most of them, without their flanks; return medians and numbers."""
    middle, count, found, left = np.empty(n), np.empty(n, np.int64), 0, len(votes)
    while found < n and left > 0:
        first, largest, end = 0, 0, 0
        for i in range(left):
            while end < left and votes[end] < votes[i] + width:
                end += 1
            if end - i > largest:
                first, largest = i, end - i
        last = first + largest - 1
        middle[found] = 0.5 * (votes[first + (largest - 1) // 2] + votes[first + largest // 2])
        count[found] = largest
        found += 1
        low, high, kept = votes[first] - 3 * width, votes[last] + 3 * width, 0
        for i in range(left):
            if votes[i] < low or votes[i] > high:
                votes[kept] = votes[i]
                kept += 1
        left = kept
    return middle[:found], count[:found]


def _tolerance(votes: np.ndarray, peak: float, background: float) -> float:
    """Return the tolerance of touches, Å: it follows the width of the highest peak, which is the noise of the file."""
    distance = np.sort(np.abs(votes - peak))
    excess = np.maximum.accumulate(np.arange(1, len(distance) + 1) - 2 * distance * background)
    excess = excess[distance < NEAR_PEAK]
    sigma = distance[np.searchsorted(excess, SHARE_IN_SIGMA * excess[-1])]
    return float(np.clip(TOLERANCE_PER_SIGMA * sigma, MIN_TOLERANCE, MAX_TOLERANCE))


def _radii_of_peaks(peaks: np.ndarray, counts: np.ndarray, table: str | None) -> tuple[np.ndarray, str]:
    """Return the radii of atoms and the name of their table: the given one, the one that explains the peaks, or their own."""
    radii, name, explained = np.sort(peaks), OWN_RADII, MIN_EXPLAINED
    for candidate in RADII if table is None else (table,):
        by_element = RADII[candidate]
        # the common elements alone, since those of a whole table explain any peak
        radii_of_table = np.unique([by_element[element] for element in (*COMMON_ELEMENTS, "H")])
        fits = np.abs(peaks[:, None] - radii_of_table) < SAME_RADIUS
        share = counts[fits.any(axis=1)].sum() / max(counts.sum(), 1)
        if share > explained or table is not None:
            explained, name = share, candidate
            common = [by_element[element] for element in COMMON_ELEMENTS]
            radii = np.unique([*common, *radii_of_table[fits.any(axis=0)]])
    return radii, name
