"""What of d the always-kept centres explain: a control of the paper's sampling for every combination of the grid.

The sampling always keeps the centres of its patches, which lie well apart. The control keeps them too and fills up uniformly
to the same n_S, so it knows no roughness. It depends on n_S alone, and is measured at some n_S and interpolated between.
"""

import numpy as np
import pandas as pd

from sparsurf.sampling.combination import PARAMETERS, Combination
from sparsurf.sampling.samplers import centres, uniform
from sparsurf.study.statistics import estimate
from sparsurf.study.tables import range_index

STEPS = 20  # n_S at which the control is measured, evenly in ln n_S


def control_curve(evaluator, n_s, readings, n_tests, draws):
    """d of the control at some n_S: Z of uniform subsets less that of the centres filled up.

    Parameters
    ----------
    evaluator : Evaluator
    n_s : (P,) int
    readings : sequence of str
    n_tests, draws : int

    Returns
    -------
    dict of reading -> (P, draws, tests) float64
    """
    tests, subsets = evaluator.draw_tests(n_tests), []
    for sampler in (uniform, centres):
        for draw in range(draws):
            every = sampler(
                evaluator, len(evaluator.points), evaluator.stream("control", sampler.__name__, draw)
            )
            subsets += [every[:n] for n in n_s]
    _, z = evaluator.distances_under(readings, subsets, tests)
    shape = (2, draws, len(n_s), -1)
    return {r: np.subtract(*values.reshape(shape)).transpose(1, 0, 2) for r, values in z.items()}


def centres_table(evaluator, grid, ranges, n_tests, draws, steps=STEPS):
    """How much of d the control has, in every range of n_S and under every reading of ranges.csv.

    Parameters
    ----------
    evaluator : Evaluator
    grid, ranges : DataFrame
        grid.csv and ranges.csv of the surface.
    n_tests, draws : int
    steps : int

    Returns
    -------
    DataFrame: reading, range (from 1), n_S_low_percent, n_S_high_percent, n_combinations; means over the combinations of d
    and of the control at their n_S (d_mean, d_centres_mean), and n_above and n_below, of how many d lies above or below
    the control by more than both 95 % intervals allow; of the winner its combination, n_S_percent, d (held out) with d_low
    and d_high, d_centres with d_centres_low and d_centres_high at its n_S, and explained, their ratio (NaN where d is not
    above 0 by its interval)
    """
    n_dots, readings = len(evaluator.points), list(ranges["reading"].unique())
    ends = grid["n_S_percent"].min(), grid["n_S_percent"].max()
    n_s = np.unique((np.geomspace(*ends, steps) / 100 * n_dots).round().astype(int)).clip(1, n_dots)
    curves = control_curve(evaluator, n_s, readings, n_tests, draws)
    rows = []
    for reading, own in ranges.groupby("reading", sort=False):
        control = estimate(_at(curves[reading], n_s, grid["n_S_percent"].to_numpy() * n_dots / 100))
        limits = [*own["n_S_low_percent"], own["n_S_high_percent"].iloc[-1]]
        member = range_index(grid["n_S_percent"].to_numpy(), limits)
        d, half = grid[f"d_{reading}"].to_numpy(), (grid[f"d_high_{reading}"] - grid[f"d_low_{reading}"]) / 2
        clear = np.hypot(half, control.half)
        for k, winner in enumerate(own.to_dict("records")):
            inside = member == k
            row = {"reading": reading, "range": k + 1}
            row |= {key: winner[key] for key in ("n_S_low_percent", "n_S_high_percent")}
            row["n_combinations"] = int(inside.sum())
            if inside.any():
                row |= {"d_mean": d[inside].mean(), "d_centres_mean": control.mean[inside].mean()}
                row["n_above"] = int((d - control.mean > clear)[inside].sum())
                row["n_below"] = int((control.mean - d > clear)[inside].sum())
                row |= _of_winner(winner, curves[reading], n_s, n_dots)
            rows.append(row)
    return pd.DataFrame(rows)


def _of_winner(winner, curve, n_s, n_dots):
    """The winner of a range beside the control at its n_S."""
    found = estimate(_at(curve, n_s, np.array([winner["n_S_percent"] * n_dots / 100])))
    d, low, high = (winner[f"d_held_out{end}"] for end in ("", "_low", "_high"))
    row = {"combination": str(Combination(*(winner[name] for name in PARAMETERS)))}
    row |= {"n_S_percent": winner["n_S_percent"], "d": d, "d_low": low, "d_high": high}
    row |= {"d_centres": found.mean[0], "d_centres_low": found.low[0], "d_centres_high": found.high[0]}
    return row | {"explained": found.mean[0] / d if low > 0 else np.nan}


def _at(curve, n_s, wanted):
    """Values (P, D, T) at `n_s` (P,), interpolated over ln n_S at other n_S (K,): (K, D, T)."""
    place = np.interp(np.log(wanted), np.log(n_s), np.arange(len(n_s)))
    first = np.minimum(place.astype(int), max(len(n_s) - 2, 0))
    share = (place - first)[:, None, None]
    return (1 - share) * curve[first] + share * curve[np.minimum(first + 1, len(n_s) - 1)]
