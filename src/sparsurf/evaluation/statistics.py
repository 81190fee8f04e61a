"""Means over draws and test dots with intervals, cross-validated selection, and the reference values of Z."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

CONFIDENCE_LEVEL = 0.95  # Every interval has this level.
MAX_SKEW = 0.75  # of skewness times t / sqrt(n): near 1 the cube root is so steep that intervals are unstable
FOLDS = (3, 5)  # of draws and of test dots; winners are chosen on all folds but one and measured on that one


class Estimate(NamedTuple):
    """A mean over draws and test dots, its standard error, and the degrees of freedom of that error."""

    mean: np.ndarray
    error: np.ndarray
    df: np.ndarray

    @property
    def half(self) -> np.ndarray:
        """Half the width of the 95 % interval, by Student's t."""
        return _t_quantile(self.df) * self.error

    @property
    def low(self) -> np.ndarray:
        """Lower end of the 95 % interval."""
        return self.mean - self.half

    @property
    def high(self) -> np.ndarray:
        """Upper end of the 95 % interval."""
        return self.mean + self.half


def _t_quantile(df: np.ndarray | int) -> np.ndarray:
    """Return the quantile of Student's t with `df` degrees of freedom at the end of a confidence interval."""
    from scipy.special import stdtrit  # here: it takes long to load; scipy.stats takes longer

    return np.asarray(stdtrit(df, (1 + CONFIDENCE_LEVEL) / 2))


def mean_interval(values: ArrayLike, fewest: int = 2) -> tuple[float, float, float]:
    """Compute the mean of independent values, such as those of proteins, and the ends of its 95 % interval.

    Student's t is corrected for skewness by Hall's cubic transformation (J. R. Stat. Soc. B 54:221, 1992), with the skewness
    bounded by `MAX_SKEW`. For exponentially distributed values the interval covers the true mean in 92 % (6 values) and 94 %
    (17) of all cases. The mean is NaN without values, and the ends are NaN for fewer than `fewest` values.
    """
    values = np.asarray(values, np.float64)
    n, mean = len(values), float(values.mean()) if len(values) else np.nan
    if n < fewest:
        return mean, np.nan, np.nan
    sd, quantile = values.std(ddof=1), float(_t_quantile(n - 1))
    below, above = (_unskewed(t, values, sd) for t in (quantile, -quantile))
    return mean, float(mean - sd * below), float(mean - sd * above)


def _unskewed(t: float, values: np.ndarray, sd: float) -> float:
    """Return the (mean - true mean) / sd that Hall's transformation maps to t / sqrt(n)."""
    n, steps = len(values), t / np.sqrt(len(values))
    if n < 3 or sd == 0:
        return steps
    skewness = n / ((n - 1) * (n - 2)) * np.sum(((values - values.mean()) / sd) ** 3)
    skewness = float(np.clip(skewness, -MAX_SKEW / abs(steps), MAX_SKEW / abs(steps)))
    if abs(skewness) < 1e-6:  # the limit
        return steps
    return 3 / skewness * (np.cbrt(1 + skewness * (steps - skewness / (6 * n))) - 1)


class MeanSquares(NamedTuple):
    """Mean squares of a two-way table of draws and test dots, and their degrees of freedom."""

    tests: np.ndarray
    draws: np.ndarray
    residual: np.ndarray
    df: tuple[int, int, int]


def mean_squares(x: np.ndarray) -> MeanSquares:
    """Compute mean squares between test dots, between draws, and of the residuals, for x (..., D, T) with D > 1."""
    d, t = x.shape[-2:]
    by_test, by_draw, mean = x.mean(axis=-2), x.mean(axis=-1), x.mean(axis=(-2, -1))
    df = (t - 1, d - 1, (d - 1) * (t - 1))
    residuals = x - by_test[..., None, :] - by_draw[..., :, None] + mean[..., None, None]
    residual = (residuals**2).sum(axis=(-2, -1)) / df[2]
    return MeanSquares(d * by_test.var(axis=-1, ddof=1), t * by_draw.var(axis=-1, ddof=1), residual, df)


def estimate(x: ArrayLike) -> Estimate:
    """Estimate the mean over draws and test dots of (..., D, T), with its standard error.

    Test dots and draws are both random effects (two-way): the variance of the mean is
    (MS_tests + MS_draws - MS_residual) / (D T), at least MS_residual / (D T), with degrees of freedom by
    Satterthwaite (Biometrics Bulletin 2:110, 1946), at least 1. With a single draw, only the scatter of the test dots is known.
    """
    x = np.asarray(x, np.float64)
    d, t = x.shape[-2:]
    mean = x.mean(axis=(-2, -1))
    unknown = np.full_like(mean, np.nan)
    if t < 2:
        return Estimate(mean, unknown, unknown)
    if d < 2:
        return Estimate(mean, x[..., 0, :].std(axis=-1, ddof=1) / np.sqrt(t), np.full_like(mean, t - 1))
    ms = mean_squares(x)
    total = np.maximum(ms.tests + ms.draws - ms.residual, ms.residual)
    return _estimate(mean, total, list(zip(ms[:3], ms.df, strict=True)), d * t)


def _estimate(
    mean: np.ndarray, total: np.ndarray, parts: Sequence[tuple[np.ndarray, int]], n: int
) -> Estimate:
    """Return the estimate whose variance is total / n, a sum of mean squares with their degrees of freedom."""
    denominator = np.sum([square**2 / df for square, df in parts], axis=0)
    max_df = np.full_like(mean, sum(df for _, df in parts))
    df = np.divide(total**2, denominator, out=max_df, where=denominator > 0)
    return Estimate(mean, np.sqrt(total / n), np.maximum(df, 1))


def mean_and_error(x: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and standard error of `estimate`."""
    return estimate(x)[:2]


def cross_validated(x: ArrayLike, folds: tuple[int, int] = FOLDS) -> Estimate:
    """Estimate d of winners on test dots and draws that were not used to choose them; `x` is (K, D, T).

    For every pair of a fold of draws (unless there is one) and a fold of test dots, the winner is chosen outside of both and
    measured inside. The variance of the mean is (MS_tests + MS_draws) / (D T) of the winners, which exceeds that of a fixed
    combination by MS_residual / (D T): the folds are not independent. docs/proteins.md tests this.
    """
    x = np.asarray(x, np.float64)
    _, d, t = x.shape
    chosen = winners_outside(x, folds)
    value = np.take_along_axis(x, chosen[None], axis=0)[0].mean()
    share = np.bincount(chosen.ravel(), minlength=len(x)) / (d * t)
    used = np.flatnonzero(share)
    if min(d, t) < 2:
        single = estimate(x[used])
        return Estimate(value, np.sqrt(share[used] @ single.error**2), np.asarray(max(t - 1.0, 1.0)))
    ms = mean_squares(x[used])
    tests, draws = share[used] @ ms.tests, share[used] @ ms.draws
    return _estimate(value, tests + draws, [(tests, ms.df[0]), (draws, ms.df[1])], d * t)


def winners_outside(x: np.ndarray, folds: tuple[int, int] = FOLDS) -> np.ndarray:
    """Return the combination that wins outside of the folds of every draw and test dot, (D, T) int."""
    _, d, t = x.shape
    n_draws, n_tests = min(folds[0], d), min(folds[1], t)
    of_draw, of_test = np.arange(d) % n_draws, np.arange(t) % n_tests
    inside = np.einsum("kdt,di,tj->kij", x, np.eye(n_draws)[of_draw], np.eye(n_tests)[of_test], optimize=True)
    outside = inside.sum(axis=(1, 2), keepdims=True)
    if n_tests > 1:
        outside = outside - inside.sum(axis=1, keepdims=True)
    if n_draws > 1:
        outside = outside - inside.sum(axis=2, keepdims=True)
    if n_draws > 1 and n_tests > 1:
        outside = outside + inside
    chosen = np.broadcast_to(outside, (len(x), n_draws, n_tests)).argmax(axis=0)
    return chosen[of_draw][:, of_test]


def reference_values(z_tot: np.ndarray) -> dict[str, float]:
    """Compute the values with which every Z is compared, from the descriptors of the full surface, (T, 121).

    `Z_empty` is Z for patches of one dot, `Z_mean_descriptor` if every patch has the mean descriptor, and `Z_two_patches` the
    mean distance between two different patches.
    """
    rows = len(z_tot) - 1
    total = sum(np.linalg.norm(z_tot[i + 1 :] - z_tot[i], axis=1).sum() for i in range(rows))
    return {
        "Z_empty": float(np.linalg.norm(z_tot, axis=1).mean()),
        "Z_mean_descriptor": float(np.linalg.norm(z_tot - z_tot.mean(axis=0), axis=1).mean()),
        "Z_two_patches": float(total / (rows * (rows + 1) / 2)) if rows else float("nan"),
    }
