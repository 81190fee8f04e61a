"""The summary of a run, from made-up surfaces whose best parameters are known."""

import json
from dataclasses import replace
from itertools import permutations

import numpy as np
import pandas as pd
import pytest
from scipy.stats import spearmanr

from sparsurf.errors import InputError
from sparsurf.sampling import published
from sparsurf.sampling.combination import PARAMETERS, Combination
from sparsurf.surfaces.formats.npz import read_npz, write_npz
from sparsurf.surfaces.surface import Surface
from sparsurf_study.analysis import summary, tables
from sparsurf_study.analysis.grid import Grid
from sparsurf_study.analysis.relation import relate_to_roughness, rho_interval, roughness_correlations

COMBINATIONS = published.parameter_grid([0.5, 1], [0], [0, 1, 2, 3, 4, 5], [0])


def result(name, rough, gamma, seed=0, noise=0.3, combinations=COMBINATIONS):
    """A conformation on which `kept` likes one gamma best and `surface` is always below a uniform draw."""
    rng, k = np.random.default_rng(seed), len(combinations)
    percent = 15 * combinations[:, 0] + np.where(combinations[:, 0] == 1, 3, 0) + 0.1 * combinations[:, 2]
    d = np.stack([1 - 0.3 * (combinations[:, 2] - gamma) ** 2, np.full(k, -0.3)])
    z_ts = np.ones((2, k, 2, 60))
    z_tr = z_ts + d[:, :, None, None] + noise * rng.normal(size=z_ts.shape)
    n_s = np.tile(np.round(10 * percent).astype(int)[:, None], 2)
    z_tot, sizes = rng.normal(size=(60, 121)), np.full((2, 2, k), 7.0)
    grid = Grid(
        combinations, 1000, n_s, n_s[:, 0] * 1.0, np.arange(60), z_tot, z_ts, z_tr, sizes, ("kept", "full")
    )
    table = tables.grid_table(grid)
    protein, conformation = name.split("/")
    ranges, best = tables.ranges_table(table, grid, 3), tables.best_combinations(table, grid, 20)
    scaled = {f"{key}_kept_scaled": -0.5 for key in ("d", "d_low", "d_high")}
    ranges = ranges.assign(link_over_spacing=0.7, share_in_island=0.3, **scaled)
    return summary.Result(protein, conformation, 1000, 250.0, 0.37, rough, table, ranges, best)


def study(gamma, roughs, names=None):
    """Surfaces of these mean roughnesses, the best gamma being a function of it and of the surface's number."""
    names = names or [f"p{s + 1:02d}/c1" for s in range(len(roughs))]
    return [result(name, r, gamma(r, s), s) for s, (name, r) in enumerate(zip(names, roughs, strict=True))]


def run_of(results):
    """The tables of a run."""
    table = summary.summary_table(results)
    return {
        "summary": table,
        "relation": summary.relation_table(results, table, np.random.default_rng(0)),
        "surfaces": summary.surfaces_table(results),
    }


ROUGHS = [round(0.50 + 0.0125 * k + 0.0001 * k * k, 4) for k in range(12)]  # one protein each


@pytest.fixture(scope="module")
def related():
    """The best gamma goes from 0 to 5 with mean roughness."""
    return run_of(study(lambda r, s: (r - 0.5) / 0.1496 * 5, ROUGHS))


def test_tables_have_a_row_per_surface_and_per_range(related):
    surfaces, table = related["surfaces"], related["summary"]
    assert len(surfaces) == 12 and len(table) == 12 * 2 * 3
    assert surfaces["N"].tolist() == [1000] * 12 and surfaces["area"].tolist() == [250.0] * 12
    assert surfaces["best_kept"][0] == "(1, 0, 0, 0)" and surfaces["best_kept"][11] == "(1, 0, 5, 0)"
    assert table["range"].tolist() == [1, 2, 3] * 24
    assert (table[table["range"] == 2]["n_combinations"] == 0).all()  # nothing keeps 12 %
    own = table[(table["range"] == 3) & (table["reading"] == "kept")]
    assert own["gamma"].tolist() == sorted(own["gamma"])
    means = table.groupby(["reading", "range"], sort=False)["d_from_all"].mean()
    pooled = related["relation"].set_index(["reading", "range"])["d_from_all"]
    pd.testing.assert_series_equal(pooled, means)


def test_choices_of_others_equal_the_plain_way():
    names = [f"{'ab' if s < 4 else 'cd'}{s % 2}/c{s}" for s in range(8)]
    results = study(lambda r, s: (s * 3) % 5, ROUGHS[:8], names)
    guesses, local = summary.chosen_nearby(results, "kept")
    for s, one in enumerate(results):
        others = [o for o in results if o.protein != one.protein]
        others.sort(key=lambda o: abs(o.mean_roughness - one.mean_roughness))
        inside = one.grid[one.grid["alpha"] == 1].index  # the last range
        for g, group in enumerate((others[:3], others[-3:], others)):
            score = sum(o.grid["d_kept"] for o in group)[inside]
            assert guesses[s, 2, g] == one.grid["d_kept"][score.idxmax()]
        score = (one.grid["d_kept"] + others[0].grid["d_kept"] + others[1].grid["d_kept"])[inside]
        assert local[s, 2] == str(Combination.from_row(one.grid.loc[score.idxmax()]))


def test_what_too_few_surfaces_cannot_tell():
    one = run_of(study(lambda r, s: 2, [0.6]))
    assert one["summary"][summary.GUESSES].isna().all().all()
    two = run_of(study(lambda r, s: 2, [0.6, 0.61]))["summary"]
    assert two[["d_from_near", "d_from_far"]].isna().all().all()
    assert two[two["n_combinations"] > 0]["d_from_all"].notna().all()


def test_conformations_of_other_grids_are_refused():
    results = [result("p/c1", 0.6, 2), result("p/c2", 0.6, 2, combinations=COMBINATIONS[:-1])]
    with pytest.raises(InputError, match="p/c2 was not evaluated as p/c1 was"):
        summary.summary_table(results)


def test_p_of_five_surfaces_counts_all_orders():
    rough = np.array([0.5, 0.52, 0.55, 0.58, 0.6])
    values = np.column_stack([[1, 2, 3, 5, 4], [0, 0, 1, 0, 1], np.ones(5), np.ones(5)]).astype(float)
    found = roughness_correlations(rough, values, np.random.default_rng(0))
    seen = max(abs(spearmanr(rough, values[:, k]).statistic) for k in (0, 1))
    as_large = [
        max(abs(spearmanr(rough[list(order)], values[:, k]).statistic) for k in (0, 1)) >= seen - 1e-12
        for order in permutations(range(5))
    ]
    assert found["p"] == pytest.approx(np.mean(as_large))
    assert np.isnan(found["rho_gamma"])  # a parameter that does not vary


def test_p_is_below_five_percent_five_times_in_a_hundred():
    # of unrelated numbers; binomial, 400 trials: 0.05 +- 0.011, three of these allowed
    rng = np.random.default_rng(2)
    p = [roughness_correlations(rng.random(7), rng.random((7, 4)), rng)["p"] for _ in range(400)]
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.05, abs=0.033)


def test_interval_of_rho_covers_the_truth():
    # normal pairs of correlation 0.6 have rho = 6/pi asin(0.3) = 0.58; 95 % of 1000 intervals of 20, +- 3 sd of
    # the count and 1 % for the formula being asymptotic
    rng = np.random.default_rng(3)
    x = rng.normal(size=(1000, 20, 2))
    x[..., 1] = 0.6 * x[..., 0] + 0.8 * x[..., 1]
    rho = np.array([spearmanr(one).statistic for one in x])
    low, high = rho_interval(rho, 20)
    truth = 6 / np.pi * np.arcsin(0.3)
    assert np.mean((low < truth) & (truth < high)) == pytest.approx(0.95, abs=0.031)


def test_conformations_of_one_protein_count_once():
    names = [f"{p}/c{c}" for p in "abc" for c in (1, 2, 3)]
    roughs = [0.5, 0.501, 0.502, 0.55, 0.551, 0.552, 0.6, 0.601, 0.602]
    table = run_of(study(lambda r, s: (r - 0.5) * 50, roughs, names))["summary"]
    rows = table[(table["reading"] == "kept") & (table["range"] == 3)]
    found = relate_to_roughness(rows, np.random.default_rng(0))
    assert found["n_surfaces"] == 9 and found["n_proteins"] == 3
    assert found["p"] == pytest.approx(2 / 6)  # two of the six orders of three proteins
    alone = relate_to_roughness(rows.assign(protein="a"), np.random.default_rng(0))
    assert alone["n_proteins"] == 1  # nine frames of one protein give neither a p nor an interval
    assert np.isnan(
        [alone[key] for key in ("p", "rho_gamma", "rho_gamma_low", "gain_low", "gain_high")]
    ).all()


def write_run(folder, results):
    """Files of conformations as the chain leaves them."""
    rng = np.random.default_rng(0)
    for one in results:
        own = folder / one.protein / one.conformation
        own.mkdir(parents=True)
        normals = rng.normal(size=(one.n_dots, 3))
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        area = np.full(one.n_dots, one.area / one.n_dots)
        radius = np.sqrt(one.area / (4 * np.pi))  # as the areas ask for
        write_npz(own / "surface.npz", Surface(radius * normals, normals, area))
        pd.DataFrame({"roughness": np.full(one.n_dots, one.mean_roughness)}).to_csv(own / "roughness.csv")
        one.grid.to_csv(own / "grid.csv", index=False)
        one.ranges.to_csv(own / "ranges.csv", index=False)
        (own / "best.json").write_text(json.dumps(one.best))


def test_the_row_of_a_surface_is_what_its_files_hold(tmp_path):
    write_run(tmp_path, study(lambda r, s: 2, [0.6]))
    folder = tmp_path / "p01" / "c1"
    rough = np.where(np.arange(1000) < 600, 0.2, 0.7)  # mean 0.4, median 0.2
    pd.DataFrame({"roughness": rough}).to_csv(folder / "roughness.csv")
    one = summary.read_result(folder)
    row = summary.surfaces_table([one]).iloc[0]
    assert row[["N", "area", "mean_roughness"]].tolist() == pytest.approx([1000, 250, 0.4])
    assert row["best_full"] == str(Combination.from_row(one.best["full"]["unrestricted"]))
    assert "cavities" not in row
    surface = read_npz(folder / "surface.npz")
    write_npz(folder / "surface.npz", replace(surface, fields={"component": np.arange(1000) >= 900}))
    row = summary.surfaces_table([summary.read_result(folder)]).iloc[0]
    assert row["components"] == 2 and row["volume"] != 0


def test_d_of_the_best_on_average_is_a_mean_over_surfaces():
    results = study(lambda r, s: 2 + s, ROUGHS[:2])
    table = summary.relation_table(results, summary.summary_table(results), np.random.default_rng(0))
    for row in table[table["reading"] == "kept"].dropna(subset="d").itertuples():
        of_best = results[0].grid[PARAMETERS].eq([getattr(row, name) for name in PARAMETERS]).all(axis=1)
        d = [one.grid.loc[of_best, "d_kept"].item() for one in results]
        assert row.d == pytest.approx(np.mean(d)) and row.d_sd == pytest.approx(np.std(d, ddof=1))


def test_damaged_results_are_named(tmp_path):
    write_run(tmp_path, study(lambda r, s: 2, [0.6]))
    (tmp_path / "p01" / "c1" / "best.json").write_text("{")
    with pytest.raises(InputError, match="c1 lacks results"):
        summary.read_result(tmp_path / "p01" / "c1")
