"""How often intervals contain the truth, and confidence sets the best combination: replicates drawn from a large pool.

The pool, many draws of the combinations that may be the best at many test dots, stands for the population: its means are
the truth. A replicate draws test dots and draws from it, with replacement, and is analysed by the functions of the study. All
combinations share them, as in a study: in a draw, they share their random subsets.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.stats import norm

from sparsurf_study.workflow.jobs import Job
from measures.over_proteins import median_interval, spearman
from measures.tables import read_tables, write_tables
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import cross_validated, estimate, mean_interval, winners_outside
from sparsurf.patches.readings import GRID_READINGS
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.streams import Streams, stream
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf_study.analysis import grid
from sparsurf_study.analysis.best_set import best_set
from sparsurf_study.analysis.relation import rho_interval
from sparsurf_study.analysis.tables import d_values, range_index, range_limits

CONTENDERS = 20  # combinations of the highest d of each range and reading that enter the pool
N_RANGES = 10
CORRELATIONS = (0.0, 0.5)  # Spearman's, of normal values
NUMBERS = ["fixed_t", "fixed_normal", "winner", "cv", "cv_winner", "best_in_set"]
NUMBERS += ["selected_bias", "cv_bias", "half_width", "set_size"]
DESIGN = ["reading", "draws", "test_dots"]


def pool(
    prepared: PreparedSurface,
    table: pd.DataFrame,
    readings: Sequence[str],
    draws: int = 24,
    n_tests: int = 1000,
) -> tuple[np.ndarray, np.ndarray]:
    """Compute the pool of one surface.

    Parameters
    ----------
    prepared : PreparedSurface
    table : DataFrame
        grid.csv of the surface, which says who the contenders are.
    readings : sequence of str
    draws, n_tests : int
        Of the pool.

    Returns
    -------
    d : (readings, K, draws, test dots) float32, and member : (K,) int, the range of each combination
    """
    percent = table["n_S_percent"].to_numpy()
    member, chosen = range_index(percent, range_limits(percent, N_RANGES)), set()
    for reading in readings:
        d = table[f"d_{reading}"].to_numpy()
        for k in range(N_RANGES):
            inside = np.flatnonzero(member == k)
            chosen |= set(inside[np.argsort(-d[inside])[:CONTENDERS]].tolist())
    chosen = np.array(sorted(chosen))
    result = grid.evaluate_grid(
        prepared, table.loc[chosen, PARAMETERS].to_numpy(), n_tests, draws, tuple(readings)
    )
    d = np.stack([d_values(result, r) for r in range(len(readings))])
    return d.astype(np.float32), member[chosen]


def replicates(
    d: np.ndarray,
    member: np.ndarray,
    draws: int,
    tests: int,
    n: int,
    rng: np.random.Generator,
    sets: bool = True,
) -> pd.DataFrame:
    """Measure the coverage over replicates of one design under one reading.

    Parameters
    ----------
    d : (K, draws, test dots) float, the pool under one reading
    member : (K,) int
    draws, tests : int
        Of a replicate.
    n : int
        Number of replicates.
    rng : numpy.random.Generator
    sets : bool
        Whether to compute confidence sets, too, which takes most of the time.

    Returns
    -------
    DataFrame, one row per range: range, n_combinations; over the replicates the mean of fixed_t and fixed_normal
    (intervals of all combinations that hold their means), winner (interval of the winner as selected), selected_bias (its
    d above its mean), cv (intervals that hold the mean d of the combinations they measured), cv_winner (that
    hold the mean d of the winner shown), cv_bias, half_width (of the held-out interval), best_in_set, set_size
    """
    rows = []
    for k in np.unique(member):
        inside = np.flatnonzero(member == k)
        if len(inside) < 2:
            continue
        truth, seen = d[inside].mean(axis=(1, 2), dtype=np.float64), []
        for _ in range(n):
            at, drawn = rng.integers(0, d.shape[2], tests), rng.integers(0, d.shape[1], draws)
            x = d[np.ix_(inside, drawn, at)].astype(np.float64)
            seen.append(one_replicate(x, truth, sets))
        rows.append({"range": k + 1, "n_combinations": len(inside), **pd.DataFrame(seen).mean().to_dict()})
    return pd.DataFrame(rows)


def one_replicate(x: np.ndarray, truth: np.ndarray, sets: bool = True) -> dict[str, float | bool]:
    """Compare the estimates from one replicate (K, D, T) with the true means (K,)."""
    estimates, honest = estimate(x), cross_validated(x)
    winner, target = int(np.argmax(estimates.mean)), truth[winners_outside(x)].mean()
    out = {
        "fixed_t": np.mean((estimates.low <= truth) & (truth <= estimates.high)),
        "fixed_normal": np.mean(np.abs(estimates.mean - truth) <= norm.ppf(0.975) * estimates.error),
        "winner": bool(estimates.low[winner] <= truth[winner] <= estimates.high[winner]),
        "selected_bias": estimates.mean[winner] - truth[winner],
        "cv": bool(honest.low <= target <= honest.high),
        "cv_winner": bool(honest.low <= truth[winner] <= honest.high),
        "cv_bias": honest.mean - target,
        "half_width": honest.half,
    }
    if sets:
        among = best_set(x)
        out |= {"best_in_set": bool(among[np.argmax(truth)]), "set_size": int(among.sum())}
    return out


def of_means(numbers: Sequence[int], replicates: int, rng: np.random.Generator) -> pd.DataFrame:
    """Measure how often the intervals over proteins hold the truth: of a mean, a median, a rank correlation.

    Returns
    -------
    DataFrame: of (mean, median or rank correlation), values (their distribution), n, coverage
    """
    rows = []
    for n in numbers:
        draws = {"normal": (rng.standard_normal, 0.0, 0.0), "exponential": (rng.exponential, 1.0, np.log(2))}
        for values, (draw, mean, median) in draws.items():
            samples = [draw(size=n) for _ in range(replicates)]
            means = [mean_interval(x)[1:] for x in samples]
            rows.append(("mean", values, n, _share(means, mean)))
            rows.append(("median", values, n, _share([median_interval(x) for x in samples], median)))
        for rho in CORRELATIONS:
            rows.append(("rank correlation", f"normal, {rho:g}", n, _of_correlation(rho, n, replicates, rng)))
    return pd.DataFrame(rows, columns=["of", "values", "n", "coverage"])


def _share(intervals: ArrayLike, truth: float) -> float:
    """Return the share of intervals (n, 2) that hold a number."""
    low, high = np.asarray(intervals).T
    return float(((low <= truth) & (truth <= high)).mean())


def _of_correlation(rho: float, n: int, replicates: int, rng: np.random.Generator) -> float:
    """Return how often the interval of Spearman's correlation holds `rho`, with normal values."""
    pearson = 2 * np.sin(np.pi * rho / 6)
    x = rng.standard_normal((2, replicates, n))
    x[1] = pearson * x[0] + np.sqrt(1 - pearson**2) * x[1]
    return _share(np.transpose(rho_interval(spearman(*x), n)), rho)


def pool_coverage(job: Job) -> None:
    """Compute many draws of the combinations of one surface that may be the best: the population that intervals are tested on."""
    prepared = PreparedSurface(
        read_npz(job.input.surface),
        roughness=pd.read_csv(job.input.roughness)["roughness"].to_numpy(),
        streams=Streams(1, f"coverage of {job.wildcards.protein}"),
        threads=job.threads,
    )
    table, params = pd.read_csv(job.input.grid), job.params
    d, member = pool(prepared, table, GRID_READINGS, params.draws, params.test_dots)
    np.savez(job.output.pool, d=d, member=member)


def measure_coverage(job: Job) -> None:
    """Measure how often the intervals of a study contain the truth on one surface, over replicates of several designs."""
    protein, n_replicates = job.wildcards.protein, job.params.replicates
    with np.load(job.input.pool) as arrays:
        d, member = arrays["d"], arrays["member"]
    tables = []
    for r, reading in enumerate(GRID_READINGS):
        for draws, test_dots in job.params.designs:
            rng = stream(0, "coverage", protein, r, draws)
            with_sets = [draws, test_dots] == job.params.default  # they take long
            shares = replicates(d[r], member, draws, test_dots, n_replicates, rng, with_sets)
            keys = {"surface": protein, "reading": reading, "draws": draws, "test_dots": test_dots}
            tables.append(pd.DataFrame(keys | {"replicates": n_replicates} | shares.to_dict("series")))
    pd.concat(tables).to_csv(job.output.table, index=False)


def tabulate_coverage(job: Job) -> None:
    """Tabulate how often intervals contain the truth, over several surfaces: all rows, and means over the ranges of n_S."""
    rows = read_tables(job.input.tables).round(4)
    params = job.params
    means = of_means(params.numbers, params.replicates, stream(params.seed, "coverage of means"))
    by_surface = rows.groupby(["surface", *DESIGN], sort=False)
    write_tables(
        {
            job.output.coverage: rows,
            job.output.coverage_surfaces: by_surface[NUMBERS].mean().reset_index(),
            job.output.coverage_designs: rows.groupby(DESIGN, sort=False)[NUMBERS].mean().reset_index(),
            job.output.coverage_means: means,
        }
    )
