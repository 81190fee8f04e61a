"""Z_tS(j) and Z_tR(j) of one combination by the roughness of the patch, as in Figure 4 of the paper.

The paper uses patches around the dots that the sampling kept. These are a biased sample, as a kept dot is surrounded by other
kept dots. Patches around any dots are therefore reported too.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import Estimate, estimate
from sparsurf.sampling import published
from sparsurf_study.analysis.tables import bin_index, range_limits

MAX_TEST_DOTS = 8_000
# There are so many for each test dot of the grid, of which a quick study has few.
TEST_DOTS_PER_TEST_DOT = 10
DRAWS_OF_WINNER = 6  # The combination is drawn so often.
N_BINS = 10  # The bins have equal width, as in Fig. 4.
MIN_TEST_DOTS = 10  # A bin with fewer is not evaluated.
AROUND = {"kept dots": True, "any dots": False}  # centres of the patches; kept dots as in the paper


class ByRoughness(NamedTuple):
    """Distances of patches of known roughness, per draw."""

    dots: np.ndarray  # (D, T) int64, test dots; the same in every draw unless they are kept dots
    roughness: np.ndarray  # (D, T) float64, R_i
    z: dict[str, np.ndarray]  # by reading, (2, D, T) float64, Z_tS(j) and Z_tR(j)


def by_roughness(
    prepared: PreparedSurface,
    combination: Sequence[float],
    readings: Sequence[str],
    n_tests: int,
    draws: int,
    kept: bool,
) -> ByRoughness:
    """Measure the distances of the patches around at most `n_tests` test dots of each draw, among the kept dots or among all."""
    pairs = [prepared.pair(combination, draw) for draw in range(draws)]
    if kept:
        n = min([n_tests, *(len(sampled) for sampled, _ in pairs)])
        tests = [sampled[_draw(prepared, len(sampled), n, k)] for k, (sampled, _) in enumerate(pairs)]
        by_draw = [prepared.compare(pair, dots, readings)[1] for pair, dots in zip(pairs, tests, strict=True)]
    else:
        # The same test dots in every draw, so that the scatter of dots and of draws can be told apart (`estimate_inside`)
        shared = _draw(prepared, len(prepared.points), min(n_tests, len(prepared.points)))
        tests = [shared] * draws
        subsets = [subset for pair in pairs for subset in pair]
        together = prepared.compare(subsets, shared, readings)[1]
        by_draw = [together[:, 2 * k : 2 * k + 2] for k in range(draws)]
    dots = np.array(tests)
    z = {reading: np.stack([z[r] for z in by_draw], axis=1) for r, reading in enumerate(readings)}
    return ByRoughness(dots, prepared.roughness[dots], z)


def kept_and_any(
    prepared: PreparedSurface, combination: Sequence[float], readings: Sequence[str], test_dots: int | str
) -> dict[str, ByRoughness]:
    """Measure the distances around kept dots and around any dots, by the names in `AROUND`; `test_dots` are those of the grid."""
    n_tests = MAX_TEST_DOTS
    if isinstance(test_dots, int):
        n_tests = min(MAX_TEST_DOTS, TEST_DOTS_PER_TEST_DOT * test_dots)
    return {
        around: by_roughness(prepared, combination, readings, n_tests, DRAWS_OF_WINNER, kept)
        for around, kept in AROUND.items()
    }


def table_of_bins(measured: Mapping[str, ByRoughness]) -> pd.DataFrame:
    """Tabulate the distances of `kept_and_any` in bins of roughness: the rows of rough_and_flat.csv."""
    tables = [bins_table(measured[around], kept).assign(around=around) for around, kept in AROUND.items()]
    return pd.concat(tables, ignore_index=True)


def _draw(prepared: PreparedSurface, n_dots: int, n: int, *keys: int) -> np.ndarray:
    """Draw n of n_dots test dots."""
    return published.uniform_subset(n_dots, n, prepared.stream("rough and flat", *keys))


def bins_table(distances: ByRoughness, kept: bool, bins: int = N_BINS) -> pd.DataFrame:
    """Average distances and d by roughness in bins of equal width, from rough to flat: the rows of rough_and_flat.csv.

    `kept` says that the test dots were drawn among the kept dots, separately for every draw. Two more rows contain the test dots
    of the lower and upper half of the bins.
    """
    edges = range_limits(distances.roughness, bins)
    bin_of = bin_index(distances.roughness, edges)
    groups = [(str(k + 1), k, k + 1) for k in range(bins)]
    groups += [("rougher half", 0, bins // 2), ("flatter half", bins // 2, bins)]
    rows = []
    for name, a, b in groups:
        inside = (bin_of >= a) & (bin_of < b)
        row: dict[str, Any] = {
            "bin": name,
            "roughness_low": edges[a],
            "roughness_high": edges[b],
            "n": inside.sum(axis=1).mean(),
        }
        for reading, z in distances.z.items():
            d = estimate_inside(z[1] - z[0], inside, kept)
            for measure, x in zip(("Z_tS", "Z_tR"), z, strict=True):
                row[f"{measure}_{reading}"] = _mean_inside(x, inside, kept)
            row |= {f"d_{reading}": float(d.mean), f"d_low_{reading}": float(d.low)}
            row[f"d_high_{reading}"] = float(d.high)
        rows.append(row)
    return pd.DataFrame(rows)


def estimate_inside(d: np.ndarray, inside: np.ndarray, kept: bool) -> Estimate:
    """Estimate the mean of d over the test dots `inside`, (D, T) each, which are nested in the draws if `kept`, else crossed."""
    if not inside.any(axis=1).all():
        nan = np.asarray(np.nan)
        return Estimate(nan, nan, nan)
    if not kept:
        return estimate(d[:, inside[0]])
    by_draw = _means_of_draws(d, inside)
    if len(by_draw) == 1:
        return estimate(d[:, inside[0]])
    error = by_draw.std(ddof=1) / np.sqrt(len(by_draw))
    return Estimate(by_draw.mean(), error, np.asarray(len(by_draw) - 1.0))


def _mean_inside(z: np.ndarray, inside: np.ndarray, kept: bool) -> float:
    """Average over the test dots `inside` like `estimate_inside`, so that d is Z_tR - Z_tS."""
    if not inside.any(axis=1).all():
        return np.nan
    return float(_means_of_draws(z, inside).mean() if kept else z[inside].mean())


def _means_of_draws(x: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Return the means of the draws, (D,), over their own test dots `inside`."""
    return np.array([row[mask].mean() for row, mask in zip(x, inside, strict=True)])
