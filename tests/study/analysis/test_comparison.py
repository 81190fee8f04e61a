"""The comparison of samplers: plain references, exact cases, means over proteins, and figure."""

import logging

import numpy as np
import pandas as pd
import pytest

import naive
import sparsurf
from peptides import peptide, write
from small_study import run_script
from sparsurf import registry
from sparsurf.errors import InputError
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import estimate, reference_values
from sparsurf.evaluation.subset_search import find_subset
from sparsurf.patches.readings import SCALED_LINK
from sparsurf.sampling import published, samplers
from sparsurf.sampling.combination import PARAMETERS, PUBLISHED_CHOICES, choices_from_ranges
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.surface import Surface
from sparsurf_study.analysis import comparison, grid, tables
from sparsurf_study.analysis.comparison import means_by_protein, means_over_proteins

D_LINK = 0.8
GRID = published.parameter_grid([0.3, 0.6, 1.0], [0, 1], [0, 6], [0, 4])


def measure_matrix(table, measure, column="value"):
    """One measure by sampler (rows) and requested n_S (columns), in the order of the table."""
    part = table[table["measure"] == measure]
    matrix = part.pivot(index="sampler", columns="percent", values=column)
    return matrix.reindex(index=part["sampler"].unique(), columns=part["percent"].unique())


@pytest.fixture(scope="module")
def surface(blob):
    return Surface(*blob)


@pytest.fixture(scope="module")
def prepared(surface):
    return PreparedSurface(surface, Settings(patches={"d_link": D_LINK}), streams=Streams(3, "blob/c1"))


@pytest.fixture(scope="module")
def study(prepared):
    """grid.csv and ranges.csv of the blob."""
    result = grid.evaluate_grid(prepared, GRID, 40, 2)
    table = tables.grid_table(result)
    return table, tables.ranges_table(table, result, 5)


@pytest.fixture(scope="module")
def table(prepared, study):
    drawers = comparison.select_methods(prepared, None, study[1])
    return comparison.compare_samplers(prepared, drawers, (5, 20, 60), n_tests=60, draws=2)


def test_a_row_for_every_sampler_size_and_measure(table):
    samplers = [name for name in registry.TABLE["sampler"] if name != "cover"]  # which needs atoms
    assert list(table["sampler"].unique()) == samplers
    assert len(table) == len(samplers) * 3 * len(comparison.USE)
    exact = table[~table["sampler"].str.startswith("paper")]
    assert (exact["n_S"] == 3000 * exact["percent"] / 100).all()
    assert np.allclose(table["n_S_percent"], table["n_S"] / 30)
    of_z = table["measure"].str.startswith("Z ")
    assert table.loc[of_z, ["Z_mean_descriptor", "Z_empty", "se", "low", "high"]].notna().all(axis=None)
    assert table.loc[~of_z, "Z_mean_descriptor"].isna().all()
    use = table.groupby("measure")["use"].unique().map(list).to_dict()
    of_surface = {measure for measure, names in use.items() if names == ["surface"]}
    patches = {f"Z {name}" for name in ("full", "full weighted", "recovered", "kept_scaled", "kept")}
    assert of_surface == patches | {"median patch size kept_scaled", "median patch size kept"}
    assert {measure: use[measure] for measure in use.keys() - of_surface} == {
        "Z centres": ["centres"], "position": ["dots"], "normal": ["dots"], "seconds": ["dots"]
    }  # fmt: skip


def test_values_have_the_intervals_of_their_draws_and_the_references_of_the_surface(prepared, table):
    tests, draws = prepared.draw_tests(60), [prepared.stream("compare", "uniform", 600, k) for k in (0, 1)]
    z_tot, _ = prepared.describe(tests)
    subsets = [np.sort(samplers.uniform(prepared, 600, rng)) for rng in draws]
    wanted = estimate(prepared.distances(subsets, tests, z_tot, "kept")[0])
    rows = table[(table["sampler"] == "uniform") & (table["percent"] == 20)].set_index("measure")
    found = rows.loc["Z kept", ["value", "se", "low", "high"]].tolist()
    assert found == pytest.approx([wanted.mean, wanted.error, wanted.low, wanted.high])
    references = reference_values(z_tot)
    for name in ("Z_mean_descriptor", "Z_empty"):
        assert rows.loc["Z kept", name] == pytest.approx(references[name])
    unpaired = ["seconds", "median patch size kept", "median patch size kept_scaled"]
    assert rows.loc[unpaired, ["se", "low", "high"]].isna().all(axis=None)
    first = ["sampler", "percent", "n_S", "n_S_percent", "use", "measure", "value", "se", "low", "high"]
    assert list(table) == [*first, "Z_mean_descriptor", "Z_empty"]
    paper = table[(table["sampler"] == "paper") & (table["measure"] == "Z full")]
    method = comparison.select_methods(prepared, ["paper"], None)["paper"]
    assert not np.array_equal(paper["n_S"], paper["percent"] * 30)  # the mean over draws
    told, floors = [], {"fresh dots": 0.25}
    few = comparison.compare_samplers(
        prepared, {"paper": method, "any": method}, (5, 20), 5, 2, lambda *done: told.append(done), floors
    )
    sizes = [len(method(600, prepared.stream("compare", "any", 600, k))) for k in (0, 1)]
    one = few[(few["sampler"] == "any") & (few["percent"] == 20)]
    assert (one["n_S"] == np.mean(sizes)).all() and told == [(1, 2), (2, 2)]
    assert few["Z_resampled"].dropna().tolist() == [0.25] * 2 * 2 * 6


def test_the_time_is_a_median_over_draws(prepared, monkeypatch):
    times = iter(np.cumsum([0, 1, 0, 2, 0, 9, 0, 4, 0, 5, 0, 30.0]))
    monkeypatch.setattr(comparison.time, "perf_counter", lambda: next(times))
    table = comparison.compare_samplers(
        prepared, comparison.select_methods(prepared, ["uniform"]), (10, 20), n_tests=3, draws=3
    )
    assert table.loc[table["measure"] == "seconds", "value"].tolist() == [2, 5]


def test_every_measure_equals_the_plain_method(prepared, surface):
    kept = np.sort(samplers.poisson(prepared, 150, np.random.default_rng(1)))
    tests = prepared.draw_tests(3)
    z_tot, _ = prepared.describe(tests)
    found = comparison._measure(prepared, [kept], tests, z_tot, (1, 1, -1))
    points, normals = surface.points, surface.normals
    gaps = np.linalg.norm(points[:, None] - points[kept][None], axis=2)
    weight = np.bincount(gaps.argmin(axis=1), minlength=len(kept))
    link = SCALED_LINK * np.sqrt(prepared.area / len(kept))
    assert link > D_LINK
    sizes = {}
    for t, i in enumerate(tests):
        nearest = kept[gaps[i].argmin()]
        cosine = normals[i] @ normals[nearest]
        assert found["position"][0, 0, t] == pytest.approx(gaps[i].min())
        assert found["normal"][0, 0, t] == pytest.approx(np.degrees(np.arccos(min(cosine, 1.0))), abs=1e-4)
        ball = kept[np.linalg.norm(points[kept] - points[i], axis=1) <= 6.0]
        whole, at_centre = (naive.patch(points, k, 6.0, D_LINK) for k in (i, nearest))
        on_surface = np.intersect1d(ball, whole)
        share = weight[np.searchsorted(kept, on_surface)]
        cases = {
            "Z full": (on_surface, None),
            "Z full weighted": (on_surface, share),
            "Z kept_scaled": (naive.island(points, ball, link), None),
            "Z kept": (naive.island(points, ball, D_LINK), None),
            "Z centres": (at_centre, None),
        }
        true = naive.descriptor(points[whole], normals[whole])
        for measure, (ids, weights) in cases.items():
            z = np.linalg.norm(true - naive.descriptor(points[ids], normals[ids], weights=weights))
            assert found[measure][0, 0, t] == pytest.approx(z, rel=1e-6, abs=1e-9), measure
            sizes.setdefault(measure, []).append(len(ids))
    median = {measure: np.median(counts) for measure, counts in sizes.items()}
    for rule in ("kept_scaled", "kept"):
        assert found[f"median patch size {rule}"] == 100 * median[f"Z {rule}"] / median["Z full"]
    assert median["Z kept_scaled"] > median["Z kept"]


def test_measures_of_several_sizes_and_draws_are_those_of_each_subset(prepared):
    """The share of a fragment is that of the median patch of its own n_S."""
    rng, tests = np.random.default_rng(2), prepared.draw_tests(5)
    subsets = [np.sort(rng.choice(3000, n, replace=False)) for n in (150, 160, 1500, 1600)]
    z_tot, _ = prepared.describe(tests)
    found = comparison._measure(prepared, subsets, tests, z_tot, (2, 2, -1))
    alone = [comparison._measure(prepared, [subset], tests, z_tot, (1, 1, -1)) for subset in subsets]
    for measure in comparison.USE.keys() - {"seconds"}:
        if not measure.startswith("median"):
            wanted = np.reshape([each[measure] for each in alone], (2, 2, 5))
            assert np.allclose(found[measure], wanted, atol=1e-9), measure
    sizes = {
        reading: prepared.distances(subsets, tests, z_tot, reading)[1].reshape(2, -1)
        for reading in ("full", "kept", "kept_scaled")
    }
    median = {reading: np.median(values, axis=1) for reading, values in sizes.items()}
    for rule in ("kept", "kept_scaled"):
        share = 100 * median[rule] / median["full"]
        assert found[f"median patch size {rule}"] == pytest.approx(share)
    assert median["full"][1] > 5 * median["full"][0]


def test_all_dots_have_no_error(prepared):
    whole = comparison.compare_samplers(
        prepared, comparison.select_methods(prepared, ["uniform"]), (100,), n_tests=20, draws=1
    ).set_index("measure")["value"]
    # 'kept' and 'kept_scaled' link the same dots, within d_link and within at least d_link
    assert whole[["Z full", "Z kept", "Z centres", "position"]].abs().max() < 1e-9
    assert whole[["median patch size kept"]].eq(100).all() and whole["Z kept_scaled"] < 0.2


def test_cores_change_nothing_but_the_time(prepared, surface):
    drawers = [
        comparison.select_methods(e, ["paper", "farthest"]) for e in (prepared, prepared.with_threads(2))
    ]
    one, two = (comparison.compare_samplers(prepared, d, (10,), n_tests=30, draws=2) for d in drawers)
    same = one["measure"] != "seconds"
    pd.testing.assert_frame_equal(one[same], two[same])


def test_one_warning_per_surface(prepared, caplog):
    drawers = comparison.select_methods(prepared, ["uniform", "poisson", "farthest"])
    with caplog.at_level(logging.WARNING, "sparsurf"):
        table = comparison.compare_samplers(prepared, drawers, (10, 90), n_tests=30, draws=1)
    (record,) = [r.getMessage() for r in caplog.records]
    left = measure_matrix(table, "median patch size kept")
    assert (left[10.0 if 10.0 in left else 10] < 50).all() and (left[90] > 50).all()
    assert record.startswith("blob/c1: some subsets")
    assert record.endswith("at 10 %")


def test_fragments_are_named_by_their_reading_and_size(caplog):
    left = {
        ("kept", "a"): [10, 49.9, 50], ("kept", "b"): [10, 20, 60], ("kept", "c"): [10, 20, 30],
        ("kept_scaled", "a"): [50, 60, 70], ("kept_scaled", "b"): [60, 10, 70], ("kept_scaled", "c"): [60, 70, 70],
    }  # fmt: skip
    rows = [
        {"sampler": sampler, "percent": percent, "measure": f"median patch size {rule}", "value": value}
        for (rule, sampler), values in left.items()
        for percent, value in zip((2.5, 10.0, 40.0), values, strict=True)
    ]
    comparison._warn_of_fragments(pd.DataFrame(rows), "p/c1")
    assert [message.split(": ", 2)[2] for message in caplog.messages] == [
        "under kept, those of a, b at 2.5, 10 %; under kept, those of c at every n_S; under kept_scaled, those of b at 10 %"
    ]
    caplog.clear()
    comparison._warn_of_fragments(pd.DataFrame(rows)[-3:], "p/c1")
    assert not caplog.messages


@pytest.mark.parametrize(
    ("z", "n_s"),
    [(1, 20), (2**0.5, 10 * 2**0.5), (0.5, 80), (0.5**0.5, 40 * 2**0.5), (2.0, 10), (2.1, 0), (0.4, np.inf), (np.nan, np.inf)],
)  # fmt: skip
def test_the_size_that_reaches_a_z_lies_on_a_curve_of_logarithms_without_its_rises(z, n_s):
    n, values = np.array([10.0, 20, 40, 80]), np.array([2.0, 1.0, 1.5, 0.5])
    assert comparison.smallest_n_s(z, n, values) == pytest.approx(n_s)


@pytest.mark.parametrize("has_atoms", [True, False])
def test_a_sampler_may_read_the_fields_of_atoms(study, tmp_path, monkeypatch, has_atoms):
    """In the job of a study as in Python; without atoms, the sentence names the sampler."""
    path, seen = write(tmp_path / "p.pdb", peptide()), []

    def curved(prepared, n, rng):
        seen.append(sparsurf.fields(prepared.surface, "mean_curvature")["mean_curvature"].to_numpy())
        return np.argsort(-seen[-1], kind="stable")[:n]

    monkeypatch.setitem(registry.TABLE, "sampler", dict(registry.TABLE["sampler"]))
    sparsurf.register("sampler", "curved", curved)
    dots = sparsurf.surface(path)
    write_npz(tmp_path / "surface.npz", dots)
    pd.DataFrame({"roughness": sparsurf.roughness(dots)}).to_csv(tmp_path / "roughness.csv", index=False)
    study[1].assign(link_over_spacing=1.0, share_in_island=1.0).to_csv(tmp_path / "ranges.csv", index=False)
    sparsurf.floors(dots).to_csv(tmp_path / "floors.csv", index=False)
    inputs = {name: str(tmp_path / f"{name}.csv") for name in ("roughness", "ranges", "floors")}
    inputs |= {"surface": str(tmp_path / "surface.npz"), "structure": str(path) if has_atoms else []}
    outputs = {"table": str(tmp_path / "compare.csv"), "png": str(tmp_path / "compare.png")}
    params = {key: Settings().model_dump()[key] for key in ("surface", "patches", "sampling")}
    params |= {"samplers": ["curved"], "percents": [30], "title": "p", "seed": 3}
    params["evaluation"] = {"test_dots": 5, "draws": 1, "readings": ["kept", "full"]}
    place = {"protein": "p", "conformation": "c1"}
    if not has_atoms:
        with pytest.raises(InputError, match="sampler 'curved': fields:"):
            run_script("compare_samplers", tmp_path, inputs, outputs, params, **place)
        return
    run_script("compare_samplers", tmp_path, inputs, outputs, params, **place)
    assert {*pd.read_csv(tmp_path / "compare.csv")["sampler"]} == {"curved"}
    assert np.allclose(seen[-1], sparsurf.fields(dots, "mean_curvature")["mean_curvature"], atol=0.01)


def test_the_papers_sampler_takes_the_winners_of_this_run(prepared, study):
    ranges = study[1]
    lowest, rows = choices_from_ranges(ranges)
    kept = ranges[(ranges["reading"] == "kept") & ranges["alpha"].notna()]
    assert np.array_equal(rows, kept[PARAMETERS]) and np.isfinite(rows).all()
    assert np.array_equal(lowest, kept["n_S_low_percent"])
    own = samplers.get_samplers(["paper"], "compare.samplers", choices_from_ranges(ranges))["paper"]
    n = round(0.01 * (lowest[1] + 1) * 3000)
    wanted = published.sample_cover(
        prepared.cover, samplers.tune_alpha(prepared.cover, rows[1], n), np.random.default_rng(4)
    )
    assert np.array_equal(own(prepared, n, np.random.default_rng(4)), wanted)
    methods = comparison.select_methods(prepared, ["paper"], ranges)
    assert list(methods) == ["paper"] and np.array_equal(
        methods["paper"](n, np.random.default_rng(4)), wanted
    )
    table_1 = comparison.select_methods(prepared, ["paper"])["paper"](n, np.random.default_rng(4))
    assert not np.array_equal(table_1, wanted)
    assert choices_from_ranges(ranges[ranges["reading"] == "full"]) is PUBLISHED_CHOICES


def curves(measure="Z full", percents=(2.5, 10, 40), **factors):
    """A comparison in which Z = factor / sqrt(n_S); around centres, the first factor is doubled."""
    rows = [
        {"sampler": name, "percent": p, "n_S": 10 * p, "n_S_percent": p, "use": "surface", "measure": m}
        | {"value": factor / np.sqrt(p), "se": 0.01, "low": factor / np.sqrt(p) - 0.02}
        | {"high": factor / np.sqrt(p) + 0.02, "Z_mean_descriptor": 1.5, "Z_empty": 9.6}
        for m in (measure, "Z centres")
        for k, name in enumerate(factors)
        for factor in [factors[name] * (2 if m == "Z centres" and k == 0 else 1)]
        for p in percents
    ]
    return pd.DataFrame(rows)


def test_summary_means_and_spread_between_proteins():
    """Of a protein of three conformations and of two others: means, where medians would be others.

    Each protein has a random subset of its own, with which its other samplers are compared.
    """
    factors = [(3.0, 2.0), (4.0, 4.0), (5.0, 9.0), (2.0, 1.0), (1.0, 1.5)]
    one, two, three, other, last = (curves(uniform=u, farthest=f) for u, f in factors)
    tables_of = {
        ("p", "c1"): one,
        ("p", "c2"): two,
        ("p", "c3"): three,
        ("pq", "c1"): other,
        ("r", "c1"): last,
    }
    units = means_by_protein(tables_of)
    assert list(units) == ["p", "pq", "r"]
    assert units["p"]["sampler"].unique().tolist() == ["uniform", "farthest"]
    means = means_over_proteins(units).query("sampler == 'farthest' and percent == 10")
    row, around = (means[means["measure"] == measure].iloc[0] for measure in ("Z full", "Z centres"))
    assert around["ratio"] == pytest.approx(row["ratio"] / 2)
    z = np.array([5.0, 1.0, 1.5]) / np.sqrt(10)  # the mean of the conformations, then protein by protein
    assert row["value"] == pytest.approx(z.mean()) and row["sd"] == pytest.approx(z.std(ddof=1))
    assert (row["lowest"], row["highest"]) == pytest.approx((z[1], z[0])) and row["n"] == 3
    ratios = [5 / 4, 1 / 2, 1.5]
    assert (row["ratio_lowest"], row["ratio_highest"]) == pytest.approx((0.5, 1.5))
    assert (row["ratio"], row["ratio_sd"]) == pytest.approx((np.mean(ratios), np.std(ratios, ddof=1)))
    assert row[["n_S_percent", "Z_mean_descriptor", "Z_empty"]].tolist() == pytest.approx([10, 1.5, 9.6])
    other = other.assign(n_S_percent=12.0, Z_empty=3.6, Z_mean_descriptor=0.5, Z_resampled=0.25)
    first = one.assign(Z_resampled=0.75)
    of_both = means_over_proteins({"p": first, "q": other, "r": first})
    assert of_both.loc[of_both["percent"] == 10, "n_S_percent"].eq(32 / 3).all()
    references = of_both[["Z_mean_descriptor", "Z_empty", "Z_resampled"]].drop_duplicates()
    assert references.to_numpy() == pytest.approx(np.array([[3.5, 22.8, 1.75]]) / 3)
    assert of_both["sampler"].unique().tolist() == ["uniform", "farthest"]  # in the order of the tables
    assert of_both["measure"].unique().tolist() == ["Z full", "Z centres"]
    assert list(means_by_protein({("p", "c1"): one, ("p", "c2"): two})) == ["p/c1", "p/c2"]


def test_minimal_has_the_requested_size_in_order_of_choice(prepared):
    for name in [name for name in registry.TABLE["sampler"] if name != "cover"]:  # which needs atoms
        dots = find_subset(prepared, name, 300)
        weight = np.bincount(samplers.nearest_chosen(prepared.points, dots), minlength=len(dots))
        assert weight.sum() == 3000 and (weight > 0).all()
        assert name.startswith("paper") or len(dots) == 300
    short, long = (find_subset(prepared, "farthest", n) for n in (100, 300))
    assert np.array_equal(short, long[:100])
    published, corrected = (prepared.with_cover(each) for each in (prepared.cover, prepared.corrected_cover))
    for name, own in (("paper", published), ("paper_corrected", corrected)):
        dots = find_subset(prepared, name, combination=(1.0, 0.0, 6.0, 0.0))
        assert dots.tolist() == own.pair((1.0, 0.0, 6.0, 0.0), 0)[0].tolist()
    assert len(dots) != len(published.pair((1.0, 0.0, 6.0, 0.0), 0)[0])


@pytest.mark.parametrize("name", ["farthest", "uniform", "poisson", "paper"])
def test_minimal_for_a_requested_z(prepared, name):
    tests = prepared.draw_tests(100)
    z_tot, _ = prepared.describe(tests)

    def z_of(subset):
        return prepared.distances([subset], tests, z_tot, "full")[0].mean()

    dots = find_subset(prepared, name, z=1.0, n_tests=100)
    assert z_of(dots) <= 1.0
    if registry.TABLE["sampler"][name].nested:
        assert z_of(dots[:-1]) > 1.0  # one dot fewer does not do
        # nor any of the sizes on the way there
        assert all(z_of(dots[:n]) > 1.0 for n in np.geomspace(10, 0.95 * len(dots), 20).astype(int))


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        ({"n_s": 3001}, "n_dots is 3001, but blob/c1 has 3000 dots"),
        ({"n_s": 0}, "n_dots is 0, but"),
        ({"z": -0.1}, "max_z is -0.1, but a distance cannot be negative"),
        ({"z": float("nan")}, "max_z is nan"),
        ({"sampler": "best", "n_s": 3}, "sampler: there is no sampler 'best'"),
        (
            {"sampler": "paper_corrected", "z": 1e-4},
            "max_z is 0.0001, but paper_corrected reaches only",
        ),
    ],
)
def test_minimal_refuses_in_one_sentence(prepared, asked, sentence):
    with pytest.raises(InputError, match=sentence.replace(".", r"\.")):
        find_subset(prepared, **asked)
