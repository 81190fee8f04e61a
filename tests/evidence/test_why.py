"""Why the sampling gains, what roughness contributes, and the law of the error, against plain references."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import naive
from measures import centres, clumps, curve, denser, full_weight, holes, law, null_result
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.recovery.errors import DENSITY_FOR_ERRORS, distance_to_surface
from sparsurf.recovery.interpolated_surface import interpolate_surface
from sparsurf.sampling.combination import PUBLISHED_ROWS
from sparsurf.sampling.farthest_point import farthest_after, farthest_point_sampling
from sparsurf.sampling.samplers import farthest
from sparsurf.settings import Settings
from sparsurf.streams import Streams

LINKS = [0.6, 1.1]  # Å
PATCHES = {"d_link": 0.8, "r_patch": 4.0, "r_zernike": 6.0}


@pytest.fixture(scope="module")
def surface(blob):
    kind = np.digitize(blob[0][:, 2], [-2, 2]).astype(np.int8)  # the parts of the test are caps and a belt
    return SimpleNamespace(points=blob[0], normals=blob[1], area=np.full(len(blob[0]), 0.3), kind=kind)


@pytest.fixture(scope="module")
def prepared(surface):
    return PreparedSurface(surface, Settings(patches=PATCHES), streams=Streams(1, "blob"))


def test_shares_and_spacings_of_the_curve_are_those_of_single_patches(prepared):
    table = curve.curve_table(prepared, LINKS, 12, 1)
    points, tests = prepared.points, prepared.draw_tests(12)
    for row in (2, 6):
        subsets = dict(zip(("tS", "tR"), prepared.pair(PUBLISHED_ROWS[row - 1], 0), strict=True))
        for link in LINKS:
            found = table[(table["row"] == row) & (table["d_link"] == link)].iloc[0]
            for name, kept in subsets.items():
                shares = []
                for i in tests:
                    whole = np.intersect1d(naive.patch(points, i, 6.0, link), kept)
                    near = kept[np.linalg.norm(points[kept] - points[i], axis=1) <= 6.0]
                    shares.append(len(naive.island(points, near, link)) / len(whole))
                assert found[f"share_{name}_percent"] == pytest.approx(100 * np.median(shares))
            n_kept = len(subsets["tS"])
            assert found["spacing"] == pytest.approx(1 / np.sqrt(n_kept / (0.3 * len(points))))
            assert found["ratio"] == pytest.approx(link / found["spacing"])
            assert found["n_S_percent"] == pytest.approx(100 * n_kept / len(points))


def test_d_of_the_curve_is_the_mean_difference(prepared):
    table = curve.curve_table(prepared, LINKS, 12, 2)
    assert np.allclose(table["d"], table["Z_tR"] - table["Z_tS"])
    assert len(table) == len(LINKS) * len(PUBLISHED_ROWS)
    assert (table["d_low"] <= table["d"]).all() and (table["d"] <= table["d_high"]).all()


def test_random_discs_percolate_at_the_ratio_of_their_filling_factor():
    assert pytest.approx(1.198, abs=5e-4) == curve.PERCOLATION


def test_a_curve_crosses_zero_between_two_points():
    x = np.array([0.0, 1.0, 2.0, 3.0])
    assert curve.crossing(x, np.array([1.0, 3.0, -1.0, -2.0])) == pytest.approx(1.75)
    assert curve.crossing(x, np.array([-1.0, 1.0, 1.0, -1.0])) == pytest.approx(2.5)  # the last one
    assert np.isnan(curve.crossing(x, np.ones(4)))


def test_the_residual_is_the_scatter_that_a_variable_does_not_explain():
    rng = np.random.default_rng(3)
    x = rng.uniform(0, 1, 4000)
    y = 3 * x + rng.normal(0, 0.2, 4000)
    assert curve.residual(x, y, 40) == pytest.approx(np.hypot(0.2, 3 / 40 / np.sqrt(12)), rel=0.05)
    assert curve.residual(rng.permutation(x), y, 40) == pytest.approx(y.std(), rel=0.05)
    table = pd.DataFrame({"row": np.arange(4000) % 2, "surface": np.arange(4000) // 2 % 4, "ratio": x})
    table["d"] = y + 5 * table["row"]  # two curves, which are one apart from the other
    assert curve.residual_in_rows(table) == pytest.approx(0.2, rel=0.05)
    assert curve.residual(x, table["d"].to_numpy(), 40) == pytest.approx(2.5, rel=0.05)
    few = np.repeat([1.0, 2.0], 50)  # equal x form one group, whatever their number
    values = few + np.tile([-1, 1], 50)
    assert curve.residual(few, values, 2) == pytest.approx(np.sqrt(100 / 98))


def test_signs_are_counted_by_the_share_of_random_patches():
    table = pd.DataFrame({"d_link": [0.5, 0.5, 0.5, 1.0], "share_tR_percent": [20, 60, 90, 10]})
    table = table.assign(d_low=[0.1, -0.1, -0.5, -2.0], d_high=[0.3, 0.1, -0.1, -1.0])
    found = curve.signs(table)[["n", "n_above", "n_below"]].to_numpy().tolist()
    assert found == [[1, 1, 0], [1, 0, 0], [1, 0, 1], [2, 1, 1], [1, 0, 0], [1, 0, 1]]


def test_values_equal_to_the_roughness_change_nothing(surface, monkeypatch):
    """Everything else is the same, so that only the values in the place of R_i can make a difference."""
    monkeypatch.setitem(null_result.IN_PLACE, "R permuted", lambda rough, rng: rough.copy())
    measured = null_result.differences(
        surface, Settings(patches=PATCHES), Streams(1, "blob"), ["kept", "full"], 20, 2, 1
    )
    keyed = measured.set_index(["values", "reading", "row"]).sort_index()
    assert (keyed.loc["R permuted", "change"] == 0).all() and (keyed.loc["R", "change"] == 0).all()
    other = keyed.loc["mean of R"]
    assert np.allclose(other["change"], keyed.loc["R", "d"] - other["d"], atol=1e-12)
    assert (other["change"] != 0).any()
    row_9 = other.xs(9, level="row")  # (1, 0, 0, 2): neither beta nor gamma, so R plays no part
    assert (row_9["change"] == 0).all()


def test_changes_are_averaged_over_proteins_and_the_paper_stands_apart():
    rows = [
        {"protein": protein, "reading": "kept", "row": row, "values": values, "n_S_percent": 10.0 * row + (values != "R"),
         "d": 2.0 + row, "change": 0.0 if values == "R" else change * row, "change_se": 0.1}
        for protein, change in (("A1", 5.0), ("a", 0.1), ("b", 0.2), ("c", 0.3))
        for row in (1, 2, 9)
        for values in ("R", "mean of R")
    ]  # fmt: skip
    found = null_result.means(pd.DataFrame(rows), "A1").set_index(["surfaces", "rows"])
    assert found.loc[("paper", "2"), "change"] == 10 and found.loc[("proteins", "2"), "n"] == 3
    assert found.loc[("proteins", "2"), "change"] == pytest.approx(0.4)
    assert found.loc[("proteins", "1 to 7"), "change"] == pytest.approx(
        0.3
    )  # rows 1 and 2 of each protein, not 9
    assert found.loc[("proteins", "9"), "change_highest"] == pytest.approx(2.7)
    assert found.loc[("proteins", "largest"), ["row", "change"]].tolist() == pytest.approx([9, 1.8])
    assert found.loc[("proteins", "largest"), ["any_lowest", "any_highest"]].tolist() == pytest.approx(
        [0.1, 2.7]
    )
    assert found.loc[("proteins", "1"), "n_S_change"] == pytest.approx(1)


def test_a_weight_of_roughness_of_0_leaves_farthest_points_and_others_keep_the_heaviest_gap(
    surface, prepared
):
    points, first = surface.points, 17
    even = denser.farthest_by_weight(points, np.ones(len(points)), first, 60)
    assert np.array_equal(even, farthest_after(prepared.index, np.array([first]), 60))
    weights = np.random.default_rng(2).uniform(0.2, 1, len(points))
    kept = denser.farthest_by_weight(points, weights, first, 40)
    for k in range(1, 40):
        gaps = np.linalg.norm(points[:, None] - points[kept[:k]], axis=2).min(axis=1)
        assert kept[k] == np.argmax(gaps * weights)


def test_changes_by_roughness_are_those_against_even_dots_of_the_same_protein_and_density():
    table = pd.DataFrame(
        [
            {"protein": name, "power": power, "requested": 0.6} | dict.fromkeys(denser.ERRORS, error * factor)
            for name, error in (("a", 0.01), ("b", 0.03), ("c", 0.05))
            for power, factor in ((0.0, 1.0), (1.0, {"a": 1.2, "b": 0.9, "c": 1.3}[name]))
        ]
    )
    even, rough = denser.means(table).to_dict("records")
    assert even["mean"] == pytest.approx(0.03) and even["change_mean"] == 0
    assert rough["change_mean"] == pytest.approx(100 * (0.2 - 0.1 + 0.3) / 3)
    assert (rough["n_above_mean"], rough["n_below_mean"]) == (2, 1)
    assert rough["change_largest_low"] < rough["change_largest"] < rough["change_largest_high"]


def test_shares_at_full_weight_are_those_of_the_mean_over_proteins():
    assert (full_weight.with_full_weight()[:, 1] == 1).all() and PUBLISHED_ROWS[4, 1] == 0
    assert np.array_equal(np.delete(full_weight.with_full_weight(), 1, 1), np.delete(PUBLISHED_ROWS, 1, 1))
    rows = [
        {"protein": protein, "reading": "full", "row": row, "values": values, "n_S_percent": 10.0 * row, "d": d * row,
         "change": change * (values != "R"), "change_se": 0.1}
        for protein, d, change in (("a", -1.0, -0.3), ("b", -2.0, -0.1), ("c", -3.0, 0.4))
        for row in (1, 2)
        for values in ("R", "mean of R")
    ]  # fmt: skip
    found = full_weight.means(pd.DataFrame(rows)).set_index("rows")
    assert found.loc["1", ["n", "d", "change", "share_percent"]].tolist() == pytest.approx(
        [3, -2, 0, 0], abs=1e-9
    )
    assert found.loc["all", ["n_cases", "n_lower", "n_higher"]].tolist() == [
        6,
        2,
        2,
    ]  # b lies within its error
    assert found.loc["all", "d"] == pytest.approx(-3)


def test_the_law_is_found_on_one_half_and_predicts_the_other():
    density = np.tile([0.2, 0.4, 0.8], 6)
    names = np.repeat([f"s{k}" for k in range(6)], 3)
    table = pd.DataFrame({"group": "chains", "structure": names, "density": density, "requested": density})
    table["mean"] = 0.02 / density**1.5
    table["high_99"] = 5 * table["mean"] * np.where(names == "s1", 1.2, 1.0)  # s1 is predicted, not fitted
    free, one, tail, _ = law.fits(table).to_dict("records")
    assert (free["C"], free["exponent"]) == pytest.approx((0.02, 1.5))
    assert free["residual_percent"] == pytest.approx(0, abs=1e-9) and free["within_percent"] == 100
    assert one["exponent"] == 1 and one["residual_percent"] > 10
    assert tail["highest_percent"] == pytest.approx(20) and tail["within_percent"] == pytest.approx(
        100 * 2 / 3
    )
    assert (free["n_fitted"], free["n_predicted"], free["n_errors"]) == (3, 3, 9)
    products = law.by_density(table)
    assert products["product"].to_numpy() == pytest.approx(0.02 / np.sqrt([0.2, 0.4, 0.8]))


def test_errors_are_those_of_dots_that_are_not_kept(prepared):
    table, parts = law.errors_by_density(prepared, [0.3, 0.6])
    n = round(0.6 * prepared.area)
    kept = farthest_point_sampling(prepared.index, n, prepared.stream("law"))
    dense = interpolate_surface(prepared.points[kept], prepared.normals[kept], DENSITY_FOR_ERRORS)
    others = np.setdiff1d(np.arange(len(prepared)), kept)
    found = distance_to_surface(prepared.points[others], *dense)
    assert table["density"][1] == pytest.approx(n / prepared.area)
    assert table.loc[1, ["mean", "largest"]].to_numpy(float) == pytest.approx([found.mean(), found.max()])
    assert table["high_99"][1] == pytest.approx(np.quantile(found, 0.99))
    assert table["mean"][0] > table["mean"][1] > 0
    kind, large = prepared.surface.kind[others], found > np.quantile(found, 0.99)
    for k, part in enumerate(["contact", "saddle", "concave"]):
        row = parts[(parts["requested"] == 0.6) & (parts["part"] == part)].iloc[0]
        assert row["dots_percent"] == pytest.approx(100 * np.mean(kind == k))
        assert row["ratio"] == pytest.approx(found[kind == k].mean() / found.mean())
        assert row["largest_percent"] == pytest.approx(100 * np.mean(kind[large] == k))


def test_the_density_that_an_error_needs_lies_where_the_measured_line_passes_it():
    table = pd.DataFrame(
        {"group": "chains", "structure": np.repeat(["a", "b"], 2), "density": [0.2, 0.8] * 2}
    )
    table["mean"] = [0.1, 0.025, 0.12, 0.03]  # C is 0.02 and 0.024 Å
    table["high_99"] = 5 * table["mean"]
    found = law.required(table, law.fits(table)).iloc[-1]
    assert found["error"] == 0.05 and found["n"] == 2
    assert found["law"] == pytest.approx(0.02 / 0.05)  # fitted on a
    assert found[["lowest", "density", "highest"]].to_numpy(float) == pytest.approx([0.4, 0.44, 0.48])


@pytest.mark.parametrize("radius", [1.5, 4.0])
def test_clumps_are_whole_but_for_the_last(prepared, radius):
    points, n = prepared.points, 500
    kept = clumps.clumps(points, n, radius, np.random.default_rng(3))
    distance = np.linalg.norm(points[:, None] - points[None], axis=2)
    order = np.random.default_rng(3).permutation(len(points))
    whole = np.cumsum(distance[order] <= radius, axis=0) > 0  # [m]: in one of the first m + 1 clumps
    last = int(np.argmax(whole.sum(axis=1) >= n))
    before = set(np.flatnonzero(whole[last - 1]))
    assert len(set(kept)) == n and before < set(kept) <= set(np.flatnonzero(whole[last]))
    new, left = set(kept) - before, set(np.flatnonzero(whole[last])) - set(kept)
    from_centre = distance[order[last]]
    assert left and max(from_centre[list(new)]) <= min(from_centre[list(left)])


def naive_z(prepared, tests, kept):
    """Z on the full surface, patch by patch."""
    points, normals, found = prepared.points, prepared.normals, []
    for i in tests:
        whole = naive.patch(points, i, 6.0, 0.8)
        few = np.intersect1d(whole, kept)
        both = [naive.descriptor(points[dots], normals[dots]) for dots in (whole, few)]
        found.append(np.linalg.norm(both[0] - both[1]))
    return np.mean(found)


def test_z_of_clumps_is_that_of_subsets_with_as_many_dots_as_the_papers(prepared):
    table = clumps.clumps_table(prepared, [5], [2.0], 8, 1).set_index(["reading", "subset"])
    paper = prepared.pair(PUBLISHED_ROWS[4], 0)[0]
    rng = prepared.stream("clumps", "clumps of 2 Å", 5, 0)
    kept = clumps.clumps(prepared.points, len(paper), 2.0, rng)
    tests = prepared.draw_tests(8)
    for name, subset in (("paper", paper), ("clumps of 2 Å", kept)):
        assert table.loc[("full", name), "Z"] == pytest.approx(naive_z(prepared, tests, subset))
    assert table["n_S_percent"].to_numpy() == pytest.approx(100 * len(paper) / len(prepared))
    z = table.loc["kept", "Z"]
    assert table.loc["kept", "d"].to_numpy() == pytest.approx(z["uniform"] - z.to_numpy())


def test_surfaces_are_counted_by_d_and_against_the_papers_sampling():
    table = pd.DataFrame({"surface": list("abcd"), "Z": [1.0, 2.0, 3.0, 6.0], "d": [1.0, 0.1, -1.0, 0.3]})
    table = table.assign(row=5, reading="kept", n_S_percent=40.0, Z_se=0.1)
    table = table.assign(d_low=table["d"] - 0.2, d_high=table["d"] + 0.2)
    paper = table.iloc[::-1].assign(subset="paper", Z=[6.1, 2.9, 2.1, 0.9])  # of d, c, b and a
    found = clumps.means(pd.concat([paper, table.assign(subset="clumps")])).iloc[1]
    expected = [4, 3, 1, 6, 2, 1, 2]
    columns = ["n", "Z", "Z_lowest", "Z_highest", "n_above", "n_below", "n_below_paper"]
    assert found[columns].tolist() == expected
    assert found["d"] == pytest.approx(0.1) and found["Z_low"] < 3 < found["Z_high"]


def test_holes_are_the_distances_to_the_nearest_kept_dot(prepared):
    found = holes.holes_table(prepared, ["farthest", "clumps"], [5, 20], 8, 1).set_index(
        ["sampler", "percent"]
    )
    points, n = prepared.points, round(0.2 * len(prepared))
    far = farthest(prepared, n, prepared.stream("holes", "farthest", n, 0))
    cut = clumps.clumps(points, n, holes.CLUMP_RADIUS, prepared.stream("holes", "clumps", n, 0))
    for name, kept in (("farthest", far), ("clumps", cut)):
        distance = np.linalg.norm(points[:, None] - points[kept][None], axis=2).min(axis=1)
        row = found.loc[(name, 20)]
        expected = [distance.mean(), *np.percentile(distance, (75, 95)), distance.max()]
        assert row[list(holes.HOLES)].to_numpy(float) == pytest.approx(expected)
        assert row["Z"] == pytest.approx(naive_z(prepared, prepared.draw_tests(8), kept))
        assert row["dots_per_A2"] == pytest.approx(n / (0.3 * len(points)))


def test_the_measure_that_z_follows_has_the_smallest_residual():
    rng = np.random.default_rng(4)
    table = pd.DataFrame({name: rng.uniform(1, 9, 400) for name in holes.MEASURES})
    table["Z"] = 0.5 * table["percentile_95"] ** 0.7 * np.exp(rng.normal(0, 0.08, 400))
    table["surface"] = np.repeat(["a", "b"], 200)
    table["sampler"], table["Z_se"] = np.tile(["clumps", "uniform"], 200), 0.02 * table["Z"]
    found = holes.fits(table).set_index(["samplers", "measure"])
    assert (
        found.loc["all", "n"].tolist() == [400] * 6 and found.loc["without clumps", "n"].tolist() == [200] * 6
    )
    best = found.loc[("all", "percentile_95")]
    assert best["slope"] == pytest.approx(0.7, abs=0.03)
    assert best["residual_percent"] == pytest.approx(8, rel=0.1)
    assert best["Z_se_percent"] == pytest.approx(2)
    assert (found.loc["all"].drop("percentile_95")["residual_percent"] > 30).all()


def test_the_patch_of_a_dot_is_compared_with_that_of_the_nearest_centre(prepared):
    found = centres.centres_table(prepared, ["uniform", "farthest"], [5], 8, 1).set_index("sampler")
    points, normals, n = prepared.points, prepared.normals, round(0.05 * len(prepared))
    kept = farthest(prepared, n, prepared.stream("centres", "farthest", n, 0))
    tests = prepared.draw_tests(8)

    def described(i):
        dots = naive.patch(points, i, 6.0, 0.8)
        return naive.descriptor(points[dots], normals[dots])

    own = [described(i) for i in tests]
    nearest = kept[np.linalg.norm(points[tests][:, None] - points[kept][None], axis=2).argmin(axis=1)]
    z = np.mean([np.linalg.norm(a - described(i)) for a, i in zip(own, nearest, strict=True)])
    pairs = np.mean([np.linalg.norm(own[a] - own[b]) for a in range(8) for b in range(a)])
    assert found.loc["farthest", ["Z_centres", "ratio"]].tolist() == pytest.approx([z, z / pairs])


def test_centres_are_compared_with_random_ones_protein_by_protein():
    table = pd.DataFrame({"protein": np.repeat(["a", "b", "c"], 2), "sampler": ["uniform", "paper"] * 3})
    table = table.assign(percent=10, n_S_percent=10.0, ratio=[0.3, 0.4, 0.5, 0.45, 0.4, 0.6])
    found = centres.means(table).set_index("sampler").loc["paper"]
    assert found[["n", "n_below", "n_above"]].tolist() == [3, 1, 2]
    assert found[["ratio", "more_than_uniform"]].tolist() == pytest.approx([1.45 / 3, 0.25 / 3])


def test_the_law_at_other_settings_is_compared_structure_by_structure():
    table = pd.DataFrame(
        {"structure": np.repeat(["a", "b"], 2), "settings": ["default", "dots as in DMS"] * 2}
    )
    table = table.assign(group="chains", requested=0.6, density=0.6, mean=[0.02, 0.024, 0.03, 0.03])
    table["high_99"] = [0.1, 0.24, 0.15, 0.3]
    found = law.by_settings(table).set_index("settings").loc["dots as in DMS"]
    assert found["product"] == pytest.approx(0.6 * 0.027) and found["tail"] == pytest.approx(10)
    changes = found[["change_percent", "change_percent_lowest", "change_percent_highest"]]
    assert changes.to_numpy(float) == pytest.approx([10, 0, 20])
