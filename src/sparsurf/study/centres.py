"""How much of d the always-kept centres explain: a control of the paper's sampling for every combination of the grid.

The sampling always keeps the centres of its patches, which are well separated. The control keeps them too and adds random
dots up to the same n_S, so it ignores roughness. It depends only on n_S, and is measured at some n_S and interpolated.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from sparsurf.sampling.combination import Combination
from sparsurf.sampling.samplers import centres, uniform
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.study.statistics import estimate
from sparsurf.study.tables import range_index

N_CURVE_SIZES = 20  # n_S at which the control is measured, evenly spaced in ln n_S


def control_curve(
    prepared: PreparedSurface, n_s: np.ndarray, readings: Sequence[str], n_tests: int, draws: int
) -> dict[str, np.ndarray]:
    """Measure d of the control at some n_S: Z of uniform subsets minus Z of the centres with random dots.

    Parameters
    ----------
    prepared : PreparedSurface
    n_s : (P,) int
    readings : sequence of str
    n_tests, draws : int

    Returns
    -------
    dict of reading -> (P, draws, tests) float64
    """
    tests, subsets = prepared.draw_tests(n_tests), []
    for sampler in (uniform, centres):
        for draw in range(draws):
            rng = prepared.stream("control", sampler.__name__, draw)
            order = sampler(prepared, len(prepared.points), rng)
            subsets += [order[:n] for n in n_s]
    _, z = prepared.distances_under(readings, subsets, tests)
    curves = {}
    for reading, values in z.items():
        of_uniform, of_centres = values.reshape(2, draws, len(n_s), -1)
        curves[reading] = (of_uniform - of_centres).transpose(1, 0, 2)
    return curves


def centres_table(
    prepared: PreparedSurface,
    grid: pd.DataFrame,
    ranges: pd.DataFrame,
    n_tests: int,
    draws: int,
    steps: int = N_CURVE_SIZES,
) -> pd.DataFrame:
    """Compare d with that of the control, in every range of n_S and under every reading of ranges.csv.

    Parameters
    ----------
    prepared : PreparedSurface
    grid, ranges : DataFrame
        grid.csv and ranges.csv of the surface.
    n_tests, draws : int
    steps : int

    Returns
    -------
    DataFrame: reading, range (from 1), n_S_low_percent, n_S_high_percent, n_combinations; means over the combinations of d
    and of the control at their n_S (d_mean, d_centres_mean); n_above and n_below, the numbers of combinations whose d is
    significantly above or below the control; for the winner its combination, n_S_percent, d (cross-validated) with d_low and
    d_high, d_centres with d_centres_low and d_centres_high at its n_S, and explained, the ratio d_centres / d (NaN unless the
    interval of d is above 0)
    """
    n_dots, readings = len(prepared.points), list(ranges["reading"].unique())
    ends = grid["n_S_percent"].min(), grid["n_S_percent"].max()
    n_s = np.unique((np.geomspace(*ends, steps) / 100 * n_dots).round().astype(int)).clip(1, n_dots)
    curves = control_curve(prepared, n_s, readings, n_tests, draws)
    rows = []
    for reading in readings:
        winners = ranges[ranges["reading"] == reading]
        control = estimate(_interpolate(curves[reading], n_s, grid["n_S_percent"].to_numpy() * n_dots / 100))
        limits = [*winners["n_S_low_percent"], winners["n_S_high_percent"].iloc[-1]]
        member = range_index(grid["n_S_percent"].to_numpy(), limits)
        d = grid[f"d_{reading}"].to_numpy()
        half = ((grid[f"d_high_{reading}"] - grid[f"d_low_{reading}"]) / 2).to_numpy()
        significant = np.hypot(half, control.half)
        for k, winner in enumerate(winners.to_dict("records")):
            inside = member == k
            row = {"reading": reading, "range": k + 1}
            row |= {key: winner[key] for key in ("n_S_low_percent", "n_S_high_percent")}
            row["n_combinations"] = int(inside.sum())
            if inside.any():
                row |= {"d_mean": d[inside].mean(), "d_centres_mean": control.mean[inside].mean()}
                row["n_above"] = int((d - control.mean > significant)[inside].sum())
                row["n_below"] = int((control.mean - d > significant)[inside].sum())
                row |= _compare_winner(winner, curves[reading], n_s, n_dots)
            rows.append(row)
    return pd.DataFrame(rows)


def _compare_winner(
    winner: Mapping[Any, Any], curve: np.ndarray, n_s: np.ndarray, n_dots: int
) -> dict[str, Any]:
    """Return the columns that compare the winner of a range with the control at its n_S."""
    control = estimate(_interpolate(curve, n_s, np.array([winner["n_S_percent"] * n_dots / 100])))
    d, low, high = (winner[f"d_cv{end}"] for end in ("", "_low", "_high"))
    return {
        "combination": str(Combination.from_row(winner)),
        "n_S_percent": winner["n_S_percent"],
        "d": d,
        "d_low": low,
        "d_high": high,
        "d_centres": control.mean[0],
        "d_centres_low": control.low[0],
        "d_centres_high": control.high[0],
        "explained": control.mean[0] / d if low > 0 else np.nan,
    }


def _interpolate(curve: np.ndarray, n_s: np.ndarray, requested: np.ndarray) -> np.ndarray:
    """Interpolate values (P, D, T) at `n_s` (P,) over ln n_S at requested n_S (K,): (K, D, T)."""
    position = np.interp(np.log(requested), np.log(n_s), np.arange(len(n_s)))
    first = np.minimum(position.astype(int), max(len(n_s) - 2, 0))
    share = (position - first)[:, None, None]
    return (1 - share) * curve[first] + share * curve[np.minimum(first + 1, len(n_s) - 1)]
