"""Subsets whose density goes with (1 - R)^k: denser where the surface is rough for k > 0, where it is flat for k < 0."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from sparsurf.recovery.readings import RECOVERED
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.study.relation import with_interval

MIN_FLATNESS = 0.02  # lower bound of 1 - R, so that no probability is 0 or infinite
READINGS = ("as_written", RECOVERED)


def density(roughness: np.ndarray, k: float) -> np.ndarray:
    """Return the density of each dot, (N,), without a unit."""
    return np.maximum(1 - roughness, MIN_FLATNESS) ** k


def random_dots(prepared: PreparedSurface, n: int, k: float, rng: np.random.Generator) -> np.ndarray:
    """Draw without replacement, each dot with a probability proportional to the density (Efraimidis & Spirakis 2006)."""
    keys = rng.standard_exponential(len(prepared.points)) / density(prepared.roughness, k)
    return np.argsort(keys, kind="stable")[:n]


def spaced_dots(prepared: PreparedSurface, n: int, k: float, rng: np.random.Generator) -> np.ndarray:
    """Choose farthest-point dots, with distances in units of the spacing that corresponds to the density at each dot."""
    points, scale = prepared.points, density(prepared.roughness, k)
    chosen, gap = np.empty(n, np.int64), np.full(len(points), np.inf)
    chosen[0] = rng.integers(len(points))
    for j in range(1, n):
        gap = np.minimum(gap, ((points - points[chosen[j - 1]]) ** 2).sum(axis=1) * scale)
        chosen[j] = np.argmax(gap)
    return chosen


SAMPLERS = {"random": random_dots, "blue noise": spaced_dots}


def measure(
    prepared: PreparedSurface,
    exponents: Sequence[float],
    percents: Sequence[float],
    n_tests: int,
    draws: int,
) -> pd.DataFrame:
    """Return Z of both samplers for every exponent and n_S: sampler, percent, k, reading, Z (mean of the draws)."""
    tests, rows = prepared.draw_tests(n_tests), []
    z_tot, _ = prepared.describe(tests)
    for name, choose in SAMPLERS.items():
        for percent in percents:
            n = max(4, round(percent / 100 * len(prepared.points)))
            for k in exponents:
                subsets = [
                    choose(prepared, n, k, prepared.stream("exponent", name, n, d)) for d in range(draws)
                ]
                for reading in READINGS:
                    z = prepared.distances(list(map(np.sort, subsets)), tests, z_tot, reading)[0].mean()
                    rows.append((name, percent, k, reading, z))
    return pd.DataFrame(rows, columns=["sampler", "percent", "k", "reading", "Z"])


def ratios(table: pd.DataFrame) -> pd.DataFrame:
    """Return Z over that at k = 0, protein by protein; means with 95 % intervals: sampler, percent, reading, k, n, ratio."""
    keys = ["protein", "sampler", "percent", "reading"]
    flat = table[table["k"] == 0].set_index(keys)["Z"].rename("flat")
    table = table.join(flat, on=keys)
    rows = [
        dict(zip((*keys[1:], "k"), group, strict=True)) | {"n": len(part)}
        | with_interval("ratio", part["Z"] / part["flat"]) | with_interval("Z", part["Z"])
        for group, part in table.groupby([*keys[1:], "k"], sort=False)
    ]  # fmt: skip
    return pd.DataFrame(rows)


def best(table: pd.DataFrame) -> pd.DataFrame:
    """Return the gain (%) of the best exponent, chosen on all other proteins; `k` is the exponent that was chosen most often."""
    rows = []
    for group, part in table.groupby(["sampler", "percent", "reading"], sort=False):
        z = part.pivot(index="protein", columns="k", values="Z")
        relative = z.div(z[0], axis=0)
        others = [relative.drop(index=protein).mean().idxmin() for protein in z.index]
        gain = [100 * (1 - relative.loc[p, k]) for p, k in zip(z.index, others, strict=True)]
        row = dict(zip(("sampler", "percent", "reading"), group, strict=True))
        rows.append(row | {"k": pd.Series(others).mode()[0], "n": len(z)} | with_interval("gain", gain))
    return pd.DataFrame(rows)
