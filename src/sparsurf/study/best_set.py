"""The confidence set of the best: combinations among which the truly best one lies with 95 % confidence.

Every combination is tested for being the best against all others at once (multiple comparisons with the best: Hsu,
Ann. Stat. 12:1136, 1984), so that the choice of a winner from the data is allowed for. The joint scatter is simulated:
combinations share their test dots, and each has draws of its own, whose scatter is pooled over those near the first.
"""

from typing import NamedTuple

import numpy as np

from sparsurf.streams import stream
from sparsurf.study.statistics import CONFIDENCE_LEVEL

FAR = 4.0  # standard errors behind the first: such a combination neither is the best nor decides who is
SIMULATED = 1000  # joint outcomes from which a critical value is taken
AT_ONCE = 50  # of them
MOST = 120  # combinations that are simulated together; those behind them would have no chance


class Scatter(NamedTuple):
    """Means of K combinations and the parts of their joint variance.

    mean : (K,) float64
    by_test : (K, T) float64, deviations of each test dot's mean, such that by_test @ by_test.T is the covariance of the
        means over test dots
    of_draws : (K,) float64, variance of the mean by the draws, estimated without bias, so that it can be negative
    """

    mean: np.ndarray
    by_test: np.ndarray
    of_draws: np.ndarray


def scatter(x):
    """Scatter of d of K combinations at shared test dots, (K, D, T)."""
    x = np.asarray(x, np.float64)
    _, d, t = x.shape
    mean, of_test = x.mean(axis=(1, 2)), x.mean(axis=1)
    by_test = (of_test - mean[:, None]) / np.sqrt(max(t - 1, 1) * t)
    if d == 1:
        return Scatter(mean, by_test, np.zeros(len(x)))
    of_draw = x.mean(axis=2)
    rest = ((x - of_test[:, None, :] - of_draw[:, :, None] + mean[:, None, None]) ** 2).sum(axis=(1, 2))
    rest /= max((d - 1) * (t - 1), 1)
    of_draws = (t * of_draw.var(axis=1, ddof=1) - rest) / (d * t)
    return Scatter(mean, by_test, of_draws)


def best_set(x):
    """Which combinations the best one is among.

    Parameters
    ----------
    x : (K, D, T)
        d of K combinations at the same test dots.

    Returns
    -------
    (K,) bool; the one with the highest mean is always in it
    """
    parts, draws = scatter(x), x.shape[1]
    first = int(np.argmax(parts.mean))
    apart = parts.by_test - parts.by_test[first]
    each = np.maximum(parts.of_draws, 0)
    error = np.sqrt((apart**2).sum(axis=1) + each + each[first])
    near = np.flatnonzero(parts.mean[first] - parts.mean <= FAR * error)
    near = near[np.argsort(-parts.mean[near], kind="stable")][:MOST]
    # of few draws each: one for all that are near
    shared = np.full(len(near), max(parts.of_draws[near].mean(), 0))
    own = Scatter(parts.mean[near], parts.by_test[near], shared)
    covariance = own.by_test @ own.by_test.T
    variance = np.diag(covariance)
    of_tests = np.maximum(variance[:, None] + variance - 2 * covariance, 0)
    error = np.sqrt(of_tests + own.of_draws[:, None] + own.of_draws)
    lead = _studentised(own.mean[:, None] - own.mean, error).max(axis=0)
    critical = _critical(own, covariance, of_tests, draws)
    out = np.zeros(len(parts.mean), bool)
    out[near[lead <= critical]] = True
    return out


def _studentised(gap, error):
    """Gaps in standard errors; a gap without any error is certain."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(gap == 0, 0.0, gap / error)


def _critical(own, covariance, of_tests, draws):
    """The 95 % quantile of how far any other runs ahead of each combination if all were equally good, (n,)."""
    n, rng = len(own.mean), stream(0, "confidence set of the best")
    values, vectors = np.linalg.eigh(covariance)
    root, freedom = vectors * np.sqrt(np.maximum(values, 0)), max(n * (draws - 1), 1)
    ahead = []
    for _ in range(0, SIMULATED, AT_ONCE):
        outcome = rng.standard_normal((AT_ONCE, n)) @ root.T
        outcome += np.sqrt(own.of_draws) * rng.standard_normal((AT_ONCE, n))
        seen = own.of_draws[0] * rng.chisquare(freedom, AT_ONCE) / freedom
        error = np.sqrt(of_tests + 2 * seen[:, None, None])
        ahead.append(_studentised(outcome[:, :, None] - outcome[:, None, :], error).max(axis=1))
    return np.quantile(np.concatenate(ahead), CONFIDENCE_LEVEL, axis=0)
