"""What holds over many proteins: by hand, by simulation, and from made-up studies."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binom
from test_summary import ROUGHS, run_of, study

from measures import over_proteins

PERCENTS = (1.0, 1.5, 2.5, 4.0, 6.0, 10.0, 15.0, 25.0, 40.0, 60.0)


def curve(protein="p", sampler="uniform", reading="full", factor=1.0):
    """Z that falls with the square root of n_S: `factor` times as many dots are needed for the same Z."""
    percents = np.array(PERCENTS)
    table = {"protein": protein, "sampler": sampler, "reading": reading, "percent": percents}
    return pd.DataFrame(table | {"n_S_percent": percents, "Z": np.sqrt(factor * 10 / percents)})


def floor(protein="p", **z):
    return pd.DataFrame(
        [(protein, name, value) for name, value in z.items()], columns=["protein", "floor", "Z"]
    )


@pytest.mark.parametrize("n", [6, 20, 65])
def test_interval_of_a_median_is_that_of_ranks(n):
    low, high = over_proteins.median_interval(np.random.default_rng(0).permutation(n).astype(float))
    # it misses the median where at most `low` values lie below it, or above
    assert high == n - 1 - low
    assert 1 - 2 * binom.cdf(low, n, 0.5) >= 0.95 > 1 - 2 * binom.cdf(low + 1, n, 0.5)


def test_times_fewer_dots_is_the_ratio_of_the_curves():
    curves = pd.concat([curve(), curve(sampler="farthest", reading="recovered", factor=0.25)])
    found = over_proteins.needed(curves)
    own = found[found["sampler"] == "farthest"].set_index("target")
    assert own["factor"].to_numpy() == pytest.approx([4, 4, 4]) and not own["bound"].any()
    far = over_proteins.needed(pd.concat([curve(), curve(sampler="paper", factor=4)]))
    far = far[far["sampler"] == "paper"].set_index("target")
    assert far["bound"].tolist() == [False, True, True] and far.loc[40.0, "n_S_percent"] == 60


def test_means_of_factors_are_geometric():
    tables = [
        pd.concat([curve(p), curve(p, "farthest", factor=1 / f)])
        for p, f in zip("abc", (2, 4, 8), strict=True)
    ]
    found = over_proteins.needed_means(over_proteins.needed(pd.concat(tables)))
    row = found[(found["sampler"] == "farthest") & (found["target"] == 25)].iloc[0]
    assert row["factor"] == pytest.approx(4) and row["n"] == 3
    # ln 2, ln 4, ln 8: sd ln 2, t(.975, 2) = 4.3027
    assert row["factor_high"] == pytest.approx(4 * 2 ** (4.3027 / np.sqrt(3)), rel=1e-4)


def test_z_over_the_floor_is_taken_protein_by_protein():
    curves = pd.concat([curve("a"), curve("b", factor=4)])
    floors = pd.concat([floor("a", **{"fresh dots": 0.5}), floor("b", **{"fresh dots": 2.0})])
    row = over_proteins.recovered_means(curves, floors).set_index("percent").loc[10.0]
    assert row["Z"] == pytest.approx(1.5) and row["over_floor"] == pytest.approx(1.5) and row["n"] == 2
    assert row["highest"] == pytest.approx(2.0) and row["highest_protein"] == "b"


@pytest.fixture(scope="module")
def made_up():
    """Twelve proteins that like one and the same combination best under `kept`."""
    results = study(lambda r, s: 2, ROUGHS)
    return results, run_of(results)


def test_d_of_two_proteins_by_hand():
    """Each counts once, with the mean of its ranges; an empty range does not count."""
    rows = [
        ("a", 1, 5, 10.0, 1.0, 0.5, 1.5, 0.75, 0.875),
        ("a", 2, 5, 30.0, 3.0, -0.5, 6.5, 2.0, 2.25),
        ("b", 1, 5, 20.0, -1.0, -1.5, -0.5, -1.0, -1.5),
        ("b", 2, 0, 99.0, 99.0, 99.0, 99.0, 99.0, 99.0),
    ]
    columns = ["protein", "range", "n_combinations", "n_S_percent", "d_cv", "d_cv_low"]
    columns += ["d_cv_high", "d_from_all", "d_from_near"]
    table = over_proteins.d_by_range(
        pd.DataFrame(rows, columns=columns).assign(
            reading="kept",
            Z_tS=[4.0, 1, 2, 9],
            Z_tR=[3.0, 4, 1, 9],
            Z_mean_descriptor=1.5,
            d_kept_scaled=[-2.0, -1, -3, 9],
            d_high_kept_scaled=[-1.0, 0.5, -2, 9],
        )
    )
    whole, first, second = table.to_dict("records")
    assert [each["range"] for each in (whole, first, second)] == [0, 1, 2]
    assert (first["n"], first["n_above"], first["n_below"], second["n"]) == (2, 1, 1, 1)
    assert (second["n_above"], second["n_below"]) == (0, 0)  # its interval holds 0
    assert (first["n_worse"], second["n_worse"]) == (
        1,
        0,
    )  # on b the random subset is better than the mean patch
    assert (first["n_S_percent"], whole["n_S_percent"], second["n_S_percent"]) == (15, 20, 30)
    assert (first["own"], whole["own"], second["own"]) == (0, 0.5, 3)  # a has 2 in the mean, b -1
    assert (first["from_all"], first["lost"], first["near"]) == (-0.125, 0.125, -0.1875)
    assert (second["lost"], second["near"]) == (1.0, 0.25)
    assert (first["scaled"], first["n_below_scaled"], second["n_below_scaled"]) == (-2.5, 2, 0)
    assert np.isnan(first["own_high"])  # two proteins have no interval yet


def test_one_combination_is_the_best_on_all(made_up):
    results, run = made_up
    table = over_proteins.plateaus(results, run["summary"]).set_index(["reading", "range"])
    row = table.loc[("kept", 3)]
    assert row["winner"] == row["best_set"] == "(1, 0, 2, 0)" and row["n_best_set"] == 1
    assert row["n_there"] == 12 and row["n_held"] >= 11
