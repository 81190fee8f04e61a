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
    return summary.SurfaceResult(protein, conformation, 1000, 250.0, 0.37, rough, table, ranges, best)


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


@pytest.mark.parametrize("other", ["fewer", "another order", "another reading"])
def test_conformations_of_other_grids_are_refused(other):
    of_other = {"fewer": COMBINATIONS[:-1], "another order": COMBINATIONS[::-1]}
    results = [
        result("p/c1", 0.6, 2),
        result("p/c2", 0.6, 2, combinations=of_other.get(other, COMBINATIONS)),
    ]
    if other == "another reading":
        results[1] = replace(results[1], grid=results[1].grid.drop(columns="d_full"))
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
    assert found["n_pairs"] == 9  # three of the conformations of each
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
    parts = {
        "component": [0, 1],
        "dots": [900, 100],
        "area": [200.0, 50.0],
        "volume": [500.0, 20.0],
        "cavity": [False, True],
    }
    parts |= {"handles": [2, None], "narrowest_handle": [0.5, None]}
    pd.DataFrame(parts).astype({"handles": "Int64"}).to_csv(folder / "components.csv", index=False)
    row = summary.surfaces_table([summary.read_result(folder)]).iloc[0]
    assert row["components"] == 2 and row["volume"] == 480
    assert row["area"] == pytest.approx(250)  # of all components


def test_d_of_the_best_on_average_is_a_mean_over_surfaces():
    results = study(lambda r, s: 2 + s, ROUGHS[:2])
    table = summary.relation_table(results, summary.summary_table(results), np.random.default_rng(0))
    rows = table[table["reading"] == "kept"].dropna(subset="d")
    assert len(rows)
    for row in rows.itertuples():
        of_best = results[0].grid[PARAMETERS].eq([getattr(row, name) for name in PARAMETERS]).all(axis=1)
        d = [one.grid.loc[of_best, "d_kept"].item() for one in results]
        assert row.d == pytest.approx(np.mean(d)) and row.d_sd == pytest.approx(np.std(d, ddof=1))


@pytest.mark.parametrize("damage", ["{", "{}"])
def test_damaged_results_are_named(tmp_path, damage):
    write_run(tmp_path, study(lambda r, s: 2, [0.6]))
    (tmp_path / "p01" / "c1" / "best.json").write_text(damage)
    with pytest.raises(InputError, match="c1 lacks results"):
        summary.read_result(tmp_path / "p01" / "c1")


def test_the_row_of_a_surface_has_its_subset_its_errors_and_its_floor():
    """Of two surfaces the first lacks what is optional; columns keep the order of the longest row."""
    plain = summary.SurfaceResult("p", "c1", 1000, 250.0, 0.37, 0.6)
    recovered = pd.DataFrame(
        {
            "where": ["everywhere", "flats"],
            "n_S_percent_low": [3.5, np.nan],
            "n_S_percent_high": [4.5, np.nan],
        }
        | {
            "density": [0.6, np.nan],
            "mean": [0.02, 9.0],
            "high_99": [0.1, 9.0],
            "back_99": [0.2, np.nan],
            "largest": [0.3, 9.0],
        }
        | {"n_S_percent": [4.0, np.nan], "Z_published": [0.5, np.nan], "Z_rotation_robust": [0.25, np.nan]}
    )
    components = {
        "dots": [900, 100],
        "volume": [500.0, 20.0],
        "cavity": [False, True],
        "handles": 0,
        "narrowest_handle": 0.5,
    }
    components = pd.DataFrame(components)
    whole = result("q/c1", 0.5, 2)
    whole = replace(
        whole, n_dots=800, minimal=pd.DataFrame({"dot": range(32)}), recovered=recovered, components=components,
        best=whole.best | {"references": {"floors": {"fresh dots": 0.75}}},
    )  # fmt: skip
    table = summary.surfaces_table([plain, whole])
    assert table.iloc[1].to_dict() == {
        "protein": "q", "conformation": "c1", "N": 800, "area": 250.0, "volume": 480.0, "components": 2, "cavities": 1,
        "spacing": 0.37, "mean_roughness": 0.5, "minimal_n_S": 32, "minimal_n_S_percent": 4.0,
        "minimal_n_S_percent_low": 3.5, "minimal_n_S_percent_high": 4.5, "minimal_density": 0.6, "recovered_mean": 0.02,
        "recovered_high_99": 0.1, "recovered_back_99": 0.2, "recovered_largest": 0.3, "recovered_Z_published": 0.5,
        "recovered_Z_rotation_robust": 0.25, "best_kept": "(1, 0, 2, 0)",
        "best_full": str(Combination.from_row(whole.best["full"]["unrestricted"])), "Z_resampled": 0.75,
    }  # fmt: skip
    assert list(table) == [
        "protein", "conformation", "N", "area", "volume", "components", "cavities", "spacing", "mean_roughness",
        "minimal_n_S", "minimal_n_S_percent", "minimal_n_S_percent_low", "minimal_n_S_percent_high", "minimal_density",
        "recovered_mean", "recovered_high_99", "recovered_back_99", "recovered_largest", "recovered_Z_published",
        "recovered_Z_rotation_robust", "best_kept", "best_full", "Z_resampled",
    ]  # fmt: skip
    assert table.iloc[0].dropna().to_dict() == {
        "protein": "p", "conformation": "c1", "N": 1000, "area": 250.0, "spacing": 0.37, "mean_roughness": 0.6
    }  # fmt: skip


def made(name, percent, d):
    """A conformation of four combinations, alpha 0.1 to 0.4, with these n_S and d under one reading."""
    alpha = 0.1 * np.arange(1, 5)
    grid = pd.DataFrame({"alpha": alpha, "beta": 0.0, "gamma": 2.0, "delta": 1.0, "n_S_percent": percent})
    ranges = pd.DataFrame({"reading": ["kept"] * 2, "n_combinations": [2, 1]})
    return summary.SurfaceResult(*name.split("/"), 1000, 250.0, 0.4, 0.6, grid.assign(d_kept=d), ranges)


def test_the_ranges_of_a_surface_are_those_of_its_own_sizes():
    """The second combination lies in the lower half of p, and in the upper of q: what q does best there is of no use to p."""
    results = [made("p/c1", [10, 20, 36, 50], [1, 3, 2, 0]), made("q/c1", [10, 40, 45, 50], [5, 6, 7, 9])]
    guesses, local = summary.chosen_nearby(results, "kept")
    assert np.isnan(guesses[:, :, :2]).all()  # one other surface is neither near nor far
    assert guesses[:, :, 2].tolist() == [[3, 2], [5, 6]]
    # d of both on average: 3, 4.5 and 4.5
    assert local.tolist() == [["(0.2, 0, 2, 1)", "(0.3, 0, 2, 1)"], ["(0.1, 0, 2, 1)", "(0.2, 0, 2, 1)"]]


def test_the_best_on_average_by_hand():
    """Mean n_S of 12, 22, 32, 42 %: two combinations lie in the first range, one in the second, and the largest in none."""
    results = [made("p/c1", [10, 20, 30, 40], [1, 3, 2, 0]), made("q/c1", [14, 24, 34, 44], [2, 0.5, 4, 9])]
    rows = [
        {"protein": p, "reading": "kept", "range": k, "mean_roughness": r, "alpha": 0.1, "beta": 0, "gamma": 2, "delta": 1}
        | {"best_set": "(0.1, 0, 2, 1)", "n_combinations": n, "d": 1.0, "d_cv": 1.0, "d_from_near": near}
        | {"d_from_far": 1.0, "d_from_all": k + r}
        for p, r, near in (("p", 0.5, 2.0), ("q", 0.7, 3.0))
        for k, n in ((2, 1), (1, 2))
    ]  # fmt: skip
    # a third surface has no combinations there
    rows += [rows[k] | {"protein": "r", "n_combinations": 0, "best_set": np.nan} | dict.fromkeys(
        ["d_from_all", *PARAMETERS], np.nan
    ) for k in (0, 1)]  # fmt: skip
    table = summary.relation_table(results, pd.DataFrame(rows), np.random.default_rng(0))
    first = [
        "reading",
        "range",
        "n_S_low_percent",
        "n_S_high_percent",
        *PARAMETERS,
        "n_S_percent",
        "d",
        "d_sd",
    ]
    assert list(table)[: len(first)] == first
    assert table["range"].tolist() == [1, 2] and table["reading"].eq("kept").all()
    found = table[[*first[2:], "d_from_all"]].to_numpy(float).tolist()
    assert found == [
        pytest.approx([12, 27, 0.2, 0, 2, 1, 22, 1.75, 2.5 / 2**0.5, 1.6]),
        pytest.approx([27, 42, 0.3, 0, 2, 1, 32, 3.0, 2**0.5, 2.6]),
    ]
    assert table["n_surfaces"].tolist() == [2, 2] and table["gain"].tolist() == [1.5, 1.5]
    single = summary.relation_table(results[:1], pd.DataFrame(rows[:2]), np.random.default_rng(0))
    assert single["d"].tolist() == [3, 2] and single["d_sd"].isna().all()


def test_winners_of_all_surfaces_stand_in_one_table():
    results = study(lambda r, s: 2, ROUGHS[:3], ["a/c1", "a/c2", "b/c1"])
    table = summary.summary_table(results)
    assert list(table)[:5] == ["protein", "conformation", "mean_roughness", "reading", "range"]
    assert list(table)[-6:] == ["local", "d_from_near", "d_from_far", "d_from_all", "n_best_set", "best_set"]
    assert table["protein"].tolist() == ["a"] * 12 + ["b"] * 6
    assert table["conformation"].tolist() == (["c1"] * 6 + ["c2"] * 6 + ["c1"] * 6)
    assert table["mean_roughness"].tolist() == [r for r in ROUGHS[:3] for _ in range(6)]
    assert table["reading"].tolist() == (["kept"] * 3 + ["full"] * 3) * 3
    for reading in ("kept", "full"):
        guesses, local = summary.chosen_nearby(results, reading)
        of_reading = table[table["reading"] == reading]
        assert np.array_equal(of_reading[summary.GUESSES], guesses.reshape(-1, 3), equal_nan=True)
        assert of_reading["local"].dropna().tolist() == [x for x in local.ravel() if isinstance(x, str)]


def test_the_nearest_are_of_other_proteins_if_there_are_any():
    results = [
        summary.SurfaceResult(p, "c", 1, 1.0, 1.0, r)
        for p, r in zip("aabac", (0.5, 0.51, 0.6, 0.49, 0.4), strict=True)
    ]
    assert summary.nearest_first(results, 0).tolist() == [2, 4]
    assert summary.nearest_first(results, 4).tolist() == [3, 0, 1, 2]
    assert summary.nearest_first(results[:2], 0).tolist() == [1]
    assert summary.nearest_first(results[:1], 0).tolist() == []


def test_a_folder_holds_what_was_made_of_its_conformation(tmp_path):
    one = study(lambda r, s: 2, [0.6])[0]
    write_run(tmp_path, [one])
    folder = tmp_path / "p01" / "c1"
    kept = {key: [1, 2] for key in ["dot", "x", "y", "z", "nx", "ny", "nz", "weight", "spacing", "reach"]}
    pd.DataFrame(kept).to_csv(folder / "minimal.csv", index=False)
    names = [
        "dots",
        "dots_percent",
        "mean",
        "high_99",
        "back_99",
        "largest",
        "n_S_percent",
        "n_S_percent_low",
        "density",
    ]
    names += ["n_S_percent_high", "Z_published", "Z_rotation_robust"]
    texts = {
        "where": "everywhere",
        "measured_on": "independent dots",
        "sampler": "cover",
        "reconstruction": "spheres",
    }
    texts |= {"decided_by": "mean"}
    pd.DataFrame({key: [value] for key, value in texts.items()} | {key: [3.5] for key in names}).to_csv(
        folder / "recovered.csv", index=False
    )
    found = summary.read_result(str(folder))
    assert (found.protein, found.conformation, found.n_dots) == ("p01", "c1", 1000)
    assert found.area == pytest.approx(250) and found.components is None
    surface = read_npz(folder / "surface.npz")
    gaps = np.linalg.norm(surface.points[:, None] - surface.points, axis=2) + 9 * np.eye(1000)
    assert found.spacing == pytest.approx(np.median(gaps.min(axis=1)), rel=1e-5)
    assert found.minimal["dot"].tolist() == [1, 2] and found.recovered["mean"].tolist() == [3.5]
    assert len(found.grid) == 12 and len(found.ranges) == 6 and found.best["combinations"] == 12
    few = summary.read_result(folder, sampled=False)
    assert few.grid.empty and few.ranges.empty and not few.best and len(few.minimal) == 2
    without = summary.read_result(folder, minimal=False)
    assert without.minimal is None and without.recovered is None and len(without.grid) == 12
    one.grid[:-1].to_csv(folder / "grid.csv", index=False)
    with pytest.raises(InputError, match=r"grid\.csv has 11 rows for 12 combinations"):
        summary.read_result(folder)
    (folder / "best.json").unlink()
    with pytest.raises(InputError, match="c1 lacks results"):
        summary.read_result(folder)
