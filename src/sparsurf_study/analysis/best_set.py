"""The confidence set of the best: a set of combinations that contains the truly best one with 95 % confidence.

Every combination is compared with all others at once (multiple comparisons with the best: Hsu, Ann. Stat. 12:1136, 1984),
which accounts for choosing the winner from the data. The joint scatter is simulated. Combinations share their test dots, but
not their draws, whose scatter is pooled over the combinations near the best. Combinations also share random subsets, which
reduces the scatter of their differences and is neglected, so that the sets are slightly too large.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from sparsurf.evaluation.statistics import CONFIDENCE_LEVEL
from sparsurf.orientation import NEGLIGIBLE
from sparsurf.streams import stream

# In standard errors behind the first; combinations farther behind are excluded beforehand.
MAX_ERRORS_BEHIND = 4.0
SIMULATED_OUTCOMES = 1000  # outcomes from which a critical value is computed
SIMULATED_AT_ONCE = 50  # their differences between 120 combinations take 6 MB
MAX_SIMULATED_TOGETHER = 120  # combinations, the best ones


class Scatter(NamedTuple):
    """Means of K combinations and the parts of their joint variance."""

    mean: np.ndarray  # (K,) float64
    by_test: np.ndarray  # (K, T) float64, deviations; by_test @ by_test.T is the covariance over test dots
    of_draws: np.ndarray  # (K,) float64, variance of the mean due to the draws; unbiased, it can be negative


def scatter(x: ArrayLike) -> Scatter:
    """Compute the scatter of d of K combinations at shared test dots, (K, D, T)."""
    x = np.asarray(x, np.float64)
    _, d, t = x.shape
    mean, of_test = x.mean(axis=(1, 2)), x.mean(axis=1)
    by_test = (of_test - mean[:, None]) / np.sqrt(max(t - 1, 1) * t)
    if d == 1:
        return Scatter(mean, by_test, np.zeros(len(x)))
    of_draw = x.mean(axis=2)
    residual = ((x - of_test[:, None, :] - of_draw[:, :, None] + mean[:, None, None]) ** 2).sum(axis=(1, 2))
    residual /= max((d - 1) * (t - 1), 1)
    of_draws = (t * of_draw.var(axis=1, ddof=1) - residual) / (d * t)
    return Scatter(mean, by_test, of_draws)


def best_set(x: np.ndarray) -> np.ndarray:
    """Find the combinations that contain the best one with 95 % confidence, (K,) bool, by d at the same test dots, (K, D, T)."""
    parts, draws = scatter(x), x.shape[1]
    first = int(np.argmax(parts.mean))
    deviation = parts.by_test - parts.by_test[first]
    # an unbiased estimate of a variance may be negative
    of_draws = np.maximum(parts.of_draws, 0)
    error = np.sqrt((deviation**2).sum(axis=1) + of_draws + of_draws[first])
    near = np.flatnonzero(parts.mean[first] - parts.mean <= MAX_ERRORS_BEHIND * error)
    near = near[np.argsort(-parts.mean[near], kind="stable")][:MAX_SIMULATED_TOGETHER]
    # each combination has few draws, so one variance is pooled over all that are near
    pooled = np.full(len(near), max(parts.of_draws[near].mean(), 0))
    candidates = Scatter(parts.mean[near], parts.by_test[near], pooled)
    covariance = candidates.by_test @ candidates.by_test.T
    variance = np.diag(covariance)
    of_tests = np.maximum(variance[:, None] + variance - 2 * covariance, 0)
    error = np.sqrt(of_tests + candidates.of_draws[:, None] + candidates.of_draws)
    lead = _studentised(candidates.mean[:, None] - candidates.mean, error).max(axis=0)
    critical = _critical_values(candidates, covariance, of_tests, draws)
    out = np.zeros(len(parts.mean), bool)
    out[near[lead <= critical]] = True
    return out


def _studentised(difference: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Return differences in standard errors; a difference without error is infinite."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(difference == 0, 0.0, difference / error)


def _critical_values(
    candidates: Scatter, covariance: np.ndarray, of_tests: np.ndarray, draws: int
) -> np.ndarray:
    """Return the 95 % quantile of the largest lead over each combination, (n,), if all were equally good."""
    # One stream for all surfaces: the set follows from the distances alone, not from the seed of the study
    n, rng = len(candidates.mean), stream(0, "confidence set of the best")
    values, vectors = np.linalg.eigh(covariance)
    # with more combinations than test dots, some eigenvalues are 0 except for rounding, and their vectors arbitrary
    values[values < NEGLIGIBLE * values[-1]] = 0
    root, df = vectors * np.sqrt(np.maximum(values, 0)), max(n * (draws - 1), 1)
    leads = []
    for _ in range(0, SIMULATED_OUTCOMES, SIMULATED_AT_ONCE):
        outcome = rng.standard_normal((SIMULATED_AT_ONCE, n)) @ root.T
        outcome += np.sqrt(candidates.of_draws) * rng.standard_normal((SIMULATED_AT_ONCE, n))
        estimated = candidates.of_draws[0] * rng.chisquare(df, SIMULATED_AT_ONCE) / df
        error = np.sqrt(of_tests + 2 * estimated[:, None, None])
        leads.append(_studentised(outcome[:, :, None] - outcome[:, None, :], error).max(axis=1))
    return np.quantile(np.concatenate(leads), CONFIDENCE_LEVEL, axis=0)
