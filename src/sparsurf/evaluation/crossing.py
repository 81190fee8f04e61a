"""Estimate the number of dots at which Z falls to a noise floor, with its interval, from a fitted curve."""

from typing import NamedTuple

import numpy as np

from sparsurf.evaluation.statistics import CONFIDENCE_LEVEL

BELOW, ABOVE = 2.2, 5.0  # the curve is fitted to n_S from the crossing / BELOW to the crossing * ABOVE
MIN_SIZES = 5  # of a fit with four coefficients
REPLICATES = 1000  # of the bootstrap
STEPS = 400  # at which a fitted curve is evaluated


class Crossing(NamedTuple):
    """The n_S at which a curve falls to its limit, and the ends of its 95 % interval; inf if the curve stays above."""

    n: float
    low: float
    high: float


def fitted_crossing(
    n: np.ndarray,
    distances: np.ndarray,
    floor: np.ndarray,
    limit: float,
    n_dots: int,
    rng: np.random.Generator,
) -> Crossing:
    """Find the n_S at which Z is `limit` times a noise floor, with its 95 % interval.

    Around the crossing, Z is fitted by a + b / n + c / n^2 + d ln n (least squares). The error of the recovered surface falls
    with a power of n; the rest falls slowly, as the share of kept dots grows. The interval comes from a bootstrap over the
    test dots, the same ones for curve and floor, and over the draws. Deviations of draws from their mean are scaled by sqrt(K
    / (K - 1)), since a few draws vary too little (Rao & Wu, J. Am. Stat. Assoc. 83:231, 1988).

    `n` is (P,), ascending; `distances` (P, K, T) are of K draws, `floor` is (F, T). The result is inf if no measured n_S is
    enough, 0 if the smallest is; then, and with fewer than `MIN_SIZES` n_S around the crossing, the interval is NaN.
    """
    z = distances.mean(axis=(1, 2)) / (limit * floor.mean())
    start = first_crossing(np.log(n), np.log(z))
    around = near(n, float(np.exp(start)))
    if around.sum() < MIN_SIZES:
        return Crossing(float(np.exp(start)), np.nan, np.nan)
    x = np.log(n[around]) - start
    steps = np.linspace(x[0], np.log(n_dots) - start, STEPS)
    fitted = _basis(steps) @ np.linalg.pinv(_basis(x))  # values of the fitted curve from those at the n_S
    answer = _descents(steps, fitted @ z[around][:, None])[0]
    answer = answer if np.isfinite(answer) else 0.0
    replicates = _descents(steps, fitted @ _replicates(distances[around], floor, rng) / limit)
    tail = (1 - CONFIDENCE_LEVEL) / 2
    low = np.quantile(replicates, tail, method="lower")
    high = np.quantile(replicates, 1 - tail, method="higher")
    ends = np.array([answer, min(low, answer), max(high, answer)])
    return Crossing(*np.minimum(np.exp(start + ends), n_dots).tolist())


def near(n: np.ndarray, crossing: float, margin: float = 1.0) -> np.ndarray:
    """Select the n_S that take part in the fit around a crossing, (P,) bool; `margin` widens the range."""
    slack = margin * (1 + 1e-9)
    return (n >= crossing / BELOW / slack) & (n <= crossing * ABOVE * slack)


def first_crossing(x: np.ndarray, y: np.ndarray) -> float:
    """Return the x at which straight lines between the points (x, y) first fall to 0; -inf or inf beyond the points."""
    below = y <= 0
    if not below.any():
        return np.inf
    k = int(np.argmax(below))
    if k == 0:
        return -np.inf if y[0] < 0 else float(x[0])
    return float(x[k - 1] + (x[k] - x[k - 1]) * y[k - 1] / (y[k - 1] - y[k]))


def _basis(x: np.ndarray) -> np.ndarray:
    """Return 1, 1 / n, 1 / n^2 and ln n at x = ln n, (P, 4)."""
    return np.stack([np.ones_like(x), np.exp(-x), np.exp(-2 * x), x], axis=1)


def _descents(x: np.ndarray, curves: np.ndarray) -> np.ndarray:
    """Return the x at which curves, (len(x), B), first fall to 1, (B,); inf if they do not."""
    below = curves <= 1
    k = np.maximum(below.argmax(axis=0), 1)
    columns = np.arange(curves.shape[1])
    before, there = curves[k - 1, columns], curves[k, columns]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.clip((before - 1) / (before - there), 0, 1)
    return np.where(below[0], x[0], np.where(below.any(axis=0), x[k - 1] + share * (x[k] - x[k - 1]), np.inf))


def _replicates(distances: np.ndarray, floor: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return Z / floor of bootstrap replicates, (P, B)."""
    sizes, draws, tests = distances.shape
    of_tests = rng.multinomial(tests, np.full(tests, 1 / tests), REPLICATES) / tests
    of_draws = _draw_weights(draws, (sizes, REPLICATES), rng)
    z = np.einsum("pkb,pbk->pb", distances @ of_tests.T, of_draws)
    return z / np.einsum("fb,bf->b", floor @ of_tests.T, _draw_weights(len(floor), (REPLICATES,), rng))


def _draw_weights(draws: int, shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """Return bootstrap weights of the draws with rescaled deviations, (*shape, draws); 1 for a single draw."""
    mean = np.full(draws, 1 / draws)
    if draws == 1:
        return np.broadcast_to(mean, (*shape, 1))
    return mean + np.sqrt(draws / (draws - 1)) * (rng.multinomial(draws, mean, shape) / draws - mean)
