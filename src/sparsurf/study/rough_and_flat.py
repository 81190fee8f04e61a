"""Z_tS(j) and Z_tR(j) of one combination by the roughness of the patch: the numbers behind Figure 4 and its claims.

The paper takes its patches around the dots that the sampling kept. They are no fair sample: a kept dot has kept dots
around it. Beside them stand patches around any dot.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd

from sparsurf.sampling import published
from sparsurf.study.statistics import Estimate, estimate
from sparsurf.study.tables import range_index, range_limits

N_BINS = 10  # of equal width, as in Fig. 4
MIN_TEST_DOTS = 10  # test dots of a bin that counts
AROUND = {"kept dots": True, "any dots": False}  # where the patches lie; kept dots as in the paper


class ByRoughness(NamedTuple):
    """Distances of patches of known roughness, per draw.

    dots : (D, T) int64, test dots; the same in every draw where they are any dots
    roughness : (D, T) float64, R_i
    z : dict of reading -> (2, D, T) float64, Z_tS(j) and Z_tR(j)
    """

    dots: np.ndarray
    roughness: np.ndarray
    z: dict


def by_roughness(evaluator, combination, readings, n_tests, draws, kept):
    """Distances of the patches around many test dots.

    Parameters
    ----------
    evaluator : Evaluator
    combination : Combination
    readings : sequence of str
    n_tests : int
        Most test dots of each draw.
    draws : int
    kept : bool
        Whether the test dots are drawn among the dots that the sampling kept; else among all.

    Returns
    -------
    ByRoughness
    """
    pairs = [evaluator.pair(combination, draw) for draw in range(draws)]
    n = (
        min([n_tests, *(len(sampled) for sampled, _ in pairs)])
        if kept
        else min(n_tests, len(evaluator.points))
    )
    if kept:
        dots = [sampled[_drawn(evaluator, len(sampled), n, draw)] for draw, (sampled, _) in enumerate(pairs)]
        found = [
            evaluator.distances_under(readings, pair, tests)[1]
            for pair, tests in zip(pairs, dots, strict=True)
        ]
    else:
        tests = _drawn(evaluator, len(evaluator.points), n)
        dots = [tests] * draws
        together = evaluator.distances_under(readings, [subset for pair in pairs for subset in pair], tests)[
            1
        ]
        found = [{r: z[2 * draw : 2 * draw + 2] for r, z in together.items()} for draw in range(draws)]
    dots = np.array(dots)
    z = {reading: np.stack([of_draw[reading] for of_draw in found], axis=1) for reading in readings}
    return ByRoughness(dots, evaluator.roughness[dots], z)


def _drawn(evaluator, n_dots, n, *keys):
    """Places of n test dots among n_dots."""
    return published.uniform_subset(n_dots, n, evaluator.stream("rough and flat", *keys))


def bins_table(found, kept, bins=N_BINS):
    """Mean distances and d by roughness.

    Parameters
    ----------
    found : ByRoughness
    kept : bool
        Whether its test dots were drawn among the kept dots, anew for every draw.

    Returns
    -------
    DataFrame, one row per bin, from rough to flat: roughness_low, roughness_high, n (test dots, mean of the draws), then
    Z_tS, Z_tR, d and the 95 % interval of d for each reading; NaN where a draw has no test dot in the bin. Two more rows,
    'rougher half' and 'flatter half' in the column `bin`, hold the test dots of the lower and upper half of the bins.
    """
    edges = range_limits(found.roughness, bins)
    place = range_index(found.roughness, edges)
    groups = [(str(k + 1), k, k + 1) for k in range(bins)]
    groups += [("rougher half", 0, bins // 2), ("flatter half", bins // 2, bins)]
    rows = []
    for name, a, b in groups:
        inside = (place >= a) & (place < b)
        row = {
            "bin": name,
            "roughness_low": edges[a],
            "roughness_high": edges[b],
            "n": inside.sum(axis=1).mean(),
        }
        for reading, z in found.z.items():
            of_bin = difference(z[1] - z[0], inside, kept)
            for name, x in zip(("Z_tS", "Z_tR"), z, strict=True):
                row[f"{name}_{reading}"] = _mean(x, inside, kept)
            row |= {f"d_{reading}": float(of_bin.mean), f"d_low_{reading}": float(of_bin.low)}
            row[f"d_high_{reading}"] = float(of_bin.high)
        rows.append(row)
    return pd.DataFrame(rows)


def difference(d, inside, kept):
    """Estimate of the mean of d, (D, T), over the test dots `inside`, (D, T) bool.

    Test dots that every draw shares are crossed with the draws; those drawn anew for every draw belong to it, so that
    the means of the draws are all that is known of their scatter.
    """
    if not inside.any(axis=1).all():
        return Estimate(*(np.float64(np.nan),) * 3)
    if not kept:
        return estimate(d[:, inside[0]])
    by_draw = _by_draw(d, inside)
    if len(by_draw) == 1:
        return estimate(d[:, inside[0]])
    error = by_draw.std(ddof=1) / np.sqrt(len(by_draw))
    return Estimate(by_draw.mean(), error, np.float64(len(by_draw) - 1))


def _mean(z, inside, kept):
    """Mean over the test dots `inside` as `difference` takes it, so that d is Z_tR - Z_tS."""
    if not inside.any(axis=1).all():
        return np.nan
    return float(_by_draw(z, inside).mean() if kept else z[inside].mean())


def _by_draw(x, inside):
    """Means of the draws, (D,), over their own test dots `inside`."""
    return np.array([row[own].mean() for row, own in zip(x, inside, strict=True)])
