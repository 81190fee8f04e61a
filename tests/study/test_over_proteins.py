"""Claims over many proteins: made-up proteins whose answers are known, and a peptide measured end to end."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binom, spearmanr, t
from test_summary import ROUGHS, run_of, study

import study_proteins
import write_proteins
from peptides import atom_line, peptide, write
from sparsurf import InputError
from sparsurf.molecules.likeness import likeness, words_of
from sparsurf.molecules.reading import read_molecule
from sparsurf.patches.descriptors import DESCRIPTORS, PUBLISHED
from sparsurf.patches.zernike.polynomials import indices
from sparsurf.sampling import law
from sparsurf.sampling.combination import texts_of
from sparsurf.streams import stream
from sparsurf.study import (
    over_proteins,
    protein_files,
    protein_scores,
    protein_tables,
    protein_variants,
)
from sparsurf.study.protein_scores import (
    OF_RECOVERED,
    PERCENTS,
    SAMPLERS,
    SEED,
    Counts,
    Rules,
    measure,
    ready,
    thin_grid,
)

FEW = Counts(draws=2, tests=5, of_floors=10, draws_by_n_s=1, tests_by_n_s=10)
GRID = law.grid([0.2, 1.0], [0], [0, 4], [0])
SAMPLING = {"alpha": [0.1, 0.2, 0.3], "beta": [0], "gamma": [2, 4], "delta": [1]}


def curve(protein="p", sampler="uniform", islands="surface", factor=1.0):
    """Z that falls with the square root of n_S: `factor` times as many dots are needed for the same Z."""
    percents = np.array(PERCENTS)
    table = {"protein": protein, "sampler": sampler, "islands": islands, "percent": percents}
    return pd.DataFrame(table | {"n_S_percent": percents, "Z": np.sqrt(factor * 10 / percents)})


def floor(protein="p", **z):
    return pd.DataFrame(
        [(protein, name, value) for name, value in z.items()], columns=["protein", "floor", "Z"]
    )


def floors_at(fresh):
    return floor(**{"fresh dots": fresh, "turned": 1.0, "atoms moved 0.1 Å": 2.0, "atoms moved 0.3 Å": 0.9})


def test_enough_is_where_the_curve_comes_near_a_yardstick():
    found = over_proteins.enough(curve(), floors_at(0.1)).set_index("yardstick")["n_S_percent"]
    # Z = sqrt(10 / n) within a tenth of 1: n = 10 / 1.1^2
    assert found["turned"] == pytest.approx(10 / over_proteins.CLOSE**2)
    assert found["fresh dots"] == np.inf
    assert found["atoms moved 0.1 Å"] == pytest.approx(10 / (2 * over_proteins.CLOSE) ** 2)
    assert (over_proteins.enough(curve(), floors_at(9.0))["n_S_percent"] == 0).sum() == 1


def test_quartiles_hold_numbers_beyond_what_was_measured():
    table = pd.DataFrame({"n_S_percent": [0.0, 1, 2, 3, 4, 5, 6, np.inf, np.inf]})
    row = over_proteins.enough_means(table.assign(sampler="s", islands="surface", yardstick="y")).iloc[0]
    assert (row["median"], row["highest"], row["lowest"]) == (4, np.inf, 0)
    assert (row["n"], row["n_less"], row["n_more"]) == (9, 1, 2)
    ten = pd.DataFrame(
        {"n_S_percent": np.arange(10.0), "sampler": "s", "islands": "surface", "yardstick": "y"}
    )
    row = over_proteins.enough_means(ten).iloc[0]  # the 3rd, the 5th and the 8th: values that were found
    assert (row["quarter"], row["median"], row["three_quarters"]) == (2, 4, 7)


@pytest.mark.parametrize("n", [6, 20, 65])
def test_interval_of_a_median_is_that_of_ranks(n):
    low, high = over_proteins.median_interval(np.random.default_rng(0).permutation(n).astype(float))
    # it misses the median where at most `low` values lie below it, or above
    assert high == n - 1 - low
    assert 1 - 2 * binom.cdf(low, n, 0.5) >= 0.95 > 1 - 2 * binom.cdf(low + 1, n, 0.5)


def test_interval_of_a_median_covers_skewed_numbers():
    rng, held = np.random.default_rng(1), 0
    for _ in range(400):
        low, high = over_proteins.median_interval(rng.exponential(size=20))
        held += low <= np.log(2) <= high
    assert held / 400 > 0.92  # exactly 0.959


def test_times_fewer_dots_is_the_ratio_of_the_curves():
    curves = pd.concat([curve(), curve(sampler="farthest", islands="recovered", factor=0.25)])
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


def test_a_winner_is_looked_for_where_both_rules_have_one():
    parameters = {"alpha": 1.0, "beta": 0.0, "gamma": [0.0, 2.0, np.nan], "delta": 0.0}
    theirs = pd.DataFrame({"islands": "kept", "n_combinations": [1, 1, 0], **parameters, "best_set": ""})
    mine = theirs.assign(n_combinations=1, best_set=["(1, 0, 0, 0)", "(1, 0, 4, 0)", "(1, 0, 6, 0)"])
    of = [(SimpleNamespace(ranges=ranges),) for ranges in (mine, theirs)]
    assert protein_variants.held(*of) == 0.5


def test_the_factor_of_a_variant_is_that_of_a_quarter_of_uniform_dots():
    recovered = curve(sampler="farthest", islands="recovered")
    recovered["Z"] = 5 / recovered["percent"]  # that of 25 % uniform dots, sqrt(10 / 25), at 7.9 %
    ranges = pd.DataFrame({"islands": ["kept", "kept", "surface"], "d_held_out": [0.5, 1.0, -0.5]})
    measured = SimpleNamespace(ranges=ranges, protein="p"), floor(**{"fresh dots": 0.25})
    found = protein_variants.claims((*measured, pd.concat([curve(), recovered])))
    assert found["factor"] == pytest.approx(25 / (5 / np.sqrt(0.4)), rel=1e-3)
    assert found["over_floor"] == pytest.approx(2) and found["d_kept"] == 0.75 and found["d_surface"] == -0.5


def test_a_share_of_ranges_lies_between_none_and_all(measured):
    result, *others = measured[1]
    none = result.ranges.assign(best_set="")
    three = [(replace(result, protein=name), *others, {}) for name in "pqr"]
    mixed = [*three[:2], (replace(three[2][0], ranges=none), *others, {})]
    table = protein_variants.table({protein_variants.DEFAULT: three, "other": mixed})
    row = table.set_index(["variant", "claim"]).loc[("other", "held")]
    assert row[["value", "value_low", "value_high"]].tolist() == pytest.approx([2 / 3, 0, 1])


def test_d_over_proteins(made_up):
    table = over_proteins.d_by_range(made_up[1]["summary"]).set_index(["islands", "range"])
    row = table.loc[("kept", 3)]
    assert row["n"] == row["n_above"] == 12 and row["own_low"] < 1.0 < row["own_high"]
    assert row["own_low"] > 0.9 and abs(row["lost"]) < 0.1
    assert table.loc[("surface", 3), "n_below"] >= 10 and table.loc[("surface", 0), "own_high"] < 0
    assert abs(row["near"]) < 0.1 and row["near_low"] <= row["near"] <= row["near_high"]
    assert table.loc[("surface", 3), "n_above"] == 0  # though of some the interval holds 0
    assert ("kept", 2) not in table.index  # nothing keeps 12 %


def test_d_of_two_proteins_by_hand():
    """Each counts once, with the mean of its ranges; an empty range does not count."""
    rows = [
        ("a", 1, 5, 10.0, 1.0, 0.5, 1.5, 0.75, 0.875),
        ("a", 2, 5, 30.0, 3.0, -0.5, 6.5, 2.0, 2.25),
        ("b", 1, 5, 20.0, -1.0, -1.5, -0.5, -1.0, -1.5),
        ("b", 2, 0, 99.0, 99.0, 99.0, 99.0, 99.0, 99.0),
    ]
    columns = ["protein", "range", "n_combinations", "n_S_percent", "d_held_out", "d_held_out_low"]
    columns += ["d_held_out_high", "d_from_all", "d_from_near"]
    table = over_proteins.d_by_range(pd.DataFrame(rows, columns=columns).assign(islands="kept"))
    whole, first, second = table.to_dict("records")
    assert [each["range"] for each in (whole, first, second)] == [0, 1, 2]
    assert (first["n"], first["n_above"], first["n_below"], second["n"]) == (2, 1, 1, 1)
    assert (second["n_above"], second["n_below"]) == (0, 0)  # its interval holds 0
    assert (first["n_S_percent"], whole["n_S_percent"], second["n_S_percent"]) == (15, 20, 30)
    assert (first["own"], whole["own"], second["own"]) == (0, 0.5, 3)  # a has 2 in the mean, b -1
    assert (first["from_all"], first["lost"], first["near"]) == (-0.125, 0.125, -0.1875)
    assert (second["lost"], second["near"]) == (1.0, 0.25)
    assert np.isnan(first["own_high"])  # two proteins have no interval yet


def test_one_combination_is_the_best_on_all(made_up):
    results, run = made_up
    table = over_proteins.plateaus(results, run["summary"]).set_index(["islands", "range"])
    row = table.loc[("kept", 3)]
    assert row["winner"] == row["best_set"] == "(1, 0, 2, 0)" and row["n_best_set"] == 1
    assert row["n_there"] == 12 and row["n_held"] >= 11


def test_a_protein_counts_only_where_it_has_the_winner_in_that_range(made_up):
    results, run = made_up
    other = results[0].grid.assign(n_S_percent=30 - results[0].grid["n_S_percent"])
    moved = [replace(results[0], grid=other), *results[1:]]
    table = over_proteins.plateaus(moved, run["summary"]).set_index(["islands", "range"])
    assert table.loc[("kept", 3), "n_there"] == 11


def test_the_plateau_breaks_where_proteins_differ():
    results = study(lambda r, s: 5 * (s % 2), ROUGHS)
    row = (
        over_proteins.plateaus(results, run_of(results)["summary"])
        .set_index(["islands", "range"])
        .loc[("kept", 3)]
    )
    assert row["n_held"] < 8


def test_confidence_sets_over_proteins_hold_the_best(made_up):
    rng = np.random.default_rng(3)
    assert over_proteins.coverage_of_set(made_up[0], "kept", 3, 3, rng, resampled=60) > 0.9
    alike = study(lambda r, s: 2.5, ROUGHS)  # two combinations are equally good
    assert over_proteins.coverage_of_set(alike, "kept", 3, 3, rng, resampled=60) > 0.85


def test_coverage_tells_normal_numbers_from_skewed_ones():
    rng = np.random.default_rng(4)
    normal = over_proteins.coverage_of_mean(rng.normal(size=40), rng)
    skewed = over_proteins.coverage_of_mean(np.append(np.zeros(39), 1.0), rng)
    assert normal == pytest.approx(0.95, abs=0.02) and skewed < 0.75


def test_power_grows_with_the_number_of_proteins():
    few, many = (over_proteins.power(n, np.random.default_rng(5), runs=600) for n in (15, 60))
    assert few["rho"] > many["rho"] > many["critical"] > 0
    # one of four at 0.05: as a single test at 1 - 0.95^(1/4); Fisher's z of 60 pairs
    assert many["critical"] == pytest.approx(np.tanh(2.49 / np.sqrt(57)), abs=0.03)
    assert many["rho"] == pytest.approx(np.tanh((2.49 + 0.84) / np.sqrt(57)), abs=0.05)


def test_rank_correlations_with_size_and_roughness():
    surfaces = pd.DataFrame(
        {"protein": list("abcdef"), "N": [1, 2, 3, 4, 5, 6], "mean_roughness": [3, 1, 2, 6, 5, 4]}
    )
    values = pd.Series([1.0, 5, 2, 8, 9, np.inf], index=list("abcdef"))
    table = over_proteins.rank_correlations({"x": values}, surfaces).set_index("against")
    assert table.loc["N", "rho"] == pytest.approx(spearmanr(values, surfaces["N"]).statistic)
    assert table.loc["mean_roughness", "rho_low"] < table.loc["mean_roughness", "rho"]


RESIDUES = ["ALA", "GLY", "SER", "VAL", "LEU", "ILE", "THR", "CYS", "MET", "PRO"]


def molecule_of(tmp_path, residues, name="m"):
    return read_molecule(write(tmp_path / f"{name}.pdb", peptide(residues)))


def test_sequences_tell_conformations_from_other_proteins(tmp_path):
    one = words_of(molecule_of(tmp_path, RESIDUES, "a"))
    other = words_of(molecule_of(tmp_path, RESIDUES[::-1], "b"))
    part = words_of(molecule_of(tmp_path, RESIDUES[2:], "c"))
    assert len(one) == 6 and likeness(one, part) == 1 and likeness(one, other) == 0
    assert likeness(one, words_of(molecule_of(tmp_path, RESIDUES[:3], "d"))) == 0
    mixed = words_of(molecule_of(tmp_path, [*RESIDUES[:6], *RESIDUES[:3]], "e"))
    assert len(mixed) == 5 and likeness(one, mixed) == 0.4  # two of its five words
    text = peptide(RESIDUES[:5]) + "TER\n" + peptide(RESIDUES[:5], "B", origin=(0, 40, 0))
    assert len(words_of(read_molecule(write(tmp_path / "two.pdb", text)))) == 1  # no word over two chains


def test_one_protein_of_each_kind_is_measured(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(study_proteins, "FEWEST_ATOMS", 5 * len(RESIDUES[1:]))  # as many as `part` has
    for name, residues in {
        "long": RESIDUES,
        "part": RESIDUES[1:],
        "other": RESIDUES[::-1],
        "few": RESIDUES[:3],
    }.items():
        write(tmp_path / f"{name}.pdb", peptide(residues))
    write(tmp_path / "broken.pdb", "nothing")
    write(tmp_path / "notes.txt", "nothing")
    hydrogen = atom_line("HA", "PRO", "A", "1", (1.8, -0.5, -0.9), element="H")
    write(tmp_path / "other.pdb", peptide(RESIDUES[::-1]) + hydrogen)
    found = study_proteins.structures(tmp_path)
    assert all("H" not in molecule.element for _, _, molecule in found)
    names = [name for name, _, _ in study_proteins.distinct(found)]
    said = capsys.readouterr().out
    assert names == ["part", "other"]
    assert "long: left out, its sequence is like that of part" in said and "few: left out, 15 atoms" in said
    assert "broken.pdb: left out" in said and "notes" not in said
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="holds no structure"):
        study_proteins.structures(tmp_path / "empty")


def test_hydrogens_are_compared_where_a_file_has_them(monkeypatch):
    files = {"bare": "CNOC", "polar": "CNOCH", "whole": "CHHNHOCH", "more": "CH"}
    monkeypatch.setattr(
        study_proteins, "read_molecule", lambda path: SimpleNamespace(element=np.array(list(files[path])))
    )
    proteins = [(name, name, None) for name in files]
    assert [name for name, _ in study_proteins.with_hydrogens(proteins, 5)] == ["whole", "more"]
    assert [name for name, _ in study_proteins.with_hydrogens(proteins, 1)] == ["whole"]


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    molecule = molecule_of(tmp_path_factory.mktemp("m"), RESIDUES[:4])
    return molecule, measure(molecule, "p", GRID, counts=FEW)


def test_a_protein_is_the_same_with_any_number_of_threads(measured):
    again = measure(measured[0], "p", GRID, threads=2, counts=FEW)
    for one, other in ((measured[1][0].grid, again[0].grid), *zip(measured[1][1:], again[1:], strict=True)):
        pd.testing.assert_frame_equal(one, other, check_exact=True)


def test_a_protein_is_measured_as_it_is_and_recovered(measured):
    result, floors, by_n_s = measured[1]
    assert len(by_n_s) == 2 * len(SAMPLERS) * len(PERCENTS)
    exact = by_n_s[(by_n_s["sampler"] == "farthest") & (by_n_s["percent"] >= 4)]
    wished = exact["percent"] / 100 * result.n_dots
    assert (exact["n_S"] - wished).abs().max() <= 0.5
    assert np.allclose(exact["n_S_percent"], 100 * exact["n_S"] / result.n_dots)
    z = by_n_s[by_n_s["sampler"] == "farthest"].pivot(index="percent", columns="islands", values="Z")
    assert (
        z.loc[10.0, "recovered"] < z.loc[10.0, "surface"] and z.loc[40.0, "surface"] < z.loc[4.0, "surface"]
    )
    assert set(over_proteins.YARDSTICKS) <= set(floors["floor"])
    assert floors["draws"].tolist() == [3] * 4
    assert result.best["yardsticks"]["floors"]["turned"] == floors.set_index("floor").loc["turned", "Z"]
    assert list(result.ranges["islands"].unique()) == ["kept", "surface"]


def test_a_grid_is_recovered_alone(measured, tmp_path):
    found = measure(measured[0], "p", GRID, counts=FEW._replace(samplers=()), readings=("recovered",))
    assert list(found[0].ranges["islands"].unique()) == ["recovered"] and found[2].empty
    protein_files.save(tmp_path / "p", *found, n_atoms=20)
    result, _, by_n_s, _ = protein_files.load(tmp_path / "p")
    assert by_n_s.empty
    evaluator, _ = ready(measured[0], "p", Rules(), 1)
    tests = evaluator.draw_tests(FEW.tests)
    z_tot, _ = evaluator.describe(tests)
    pairs = [evaluator.pair(GRID[1], draw) for draw in range(FEW.draws)]
    z = np.array([evaluator.distances(pair, tests, z_tot, "recovered")[0] for pair in pairs])
    assert result.grid["Z_tS_recovered"][1] == pytest.approx(z[:, 0].mean(), rel=1e-5)
    assert result.grid["Z_tR_recovered"][1] == pytest.approx(z[:, 1].mean(), rel=1e-5)
    four = [replace(result, protein=name) for name in "abcd"]
    four[1] = replace(four[1], grid=result.grid.assign(d_recovered=result.grid["d_recovered"] - 1))
    own, covered = protein_tables.of_recovered(four)
    own = own.set_index("range")
    assert own.loc[1, "lowest_protein"] == "b"
    assert own.loc[1, "from_all"] == pytest.approx(
        own.loc[1, "lowest"] + 3 / 4
    )  # d of the other three is 1 higher
    assert covered[["quantity", "n"]].iloc[0].to_list() == ["d held out, `recovered`", 4]
    assert own["n"].unique().tolist() == [4]
    assert own.loc[0, "own"] == pytest.approx(result.ranges["d_held_out"].mean())
    held = result.ranges[result.ranges["n_combinations"] > 0]
    assert own["own"].iloc[1:].to_numpy() == pytest.approx(held["d_held_out"].to_numpy())
    assert own["n_combinations"].iloc[1:].tolist() == held["n_combinations"].tolist()
    first = texts_of(held)[0]
    assert own["winner"].iloc[1] == first and own["n_there"].iloc[1] == 4 == own["n_held"].iloc[1]


def test_the_whole_recovered_grid_is_set_beside_its_quarter_on_the_same_proteins(measured):
    counts = FEW._replace(samplers=())
    result = measure(measured[0], "p", GRID, counts=counts, readings=("recovered",))[0]
    empty = result.ranges["n_combinations"].to_numpy() == 0

    def on(protein, d, n_s):
        """The result with d held out d + k and n_S n_s + k in the k-th range that holds combinations."""
        k = np.where(empty, np.nan, np.cumsum(~empty))
        return replace(
            result, protein=protein, ranges=result.ranges.assign(d_held_out=d + k, n_S_percent=n_s + k)
        )

    whole = [on("a", 1.0, 10), on("b", 2.0, 20), on("c", 6.0, 60), on("alone", 99.0, 90)]
    quarter = [on("c", 2.0, 30), on("other", 50.0, 1), on("b", 1.0, 20), on("a", 0.5, 13)]
    found, covered = protein_tables.of_whole_grid(whole, quarter)
    found = found.set_index("range")
    assert covered[["quantity", "interval", "n"]].iloc[0].to_list() == [
        "d held out, `recovered`, whole less a quarter of the grid", "mean", 3,
    ]  # fmt: skip
    again = over_proteins.coverage_of_mean(
        np.array([0.5, 1.0, 4.0]), stream(SEED, "coverage", "recovered_whole")
    )
    assert covered["coverage"].iloc[0] == again
    filled = (np.flatnonzero(~empty) + 1).tolist()
    assert found.index.tolist() == [0, *filled] and found["n"].unique().tolist() == [3]
    gains = np.array([0.5, 1.0, 4.0])
    half = t.ppf(0.975, 2) * gains.std(ddof=1) / np.sqrt(3)
    expected = [gains.mean(), gains.mean() - half, gains.mean() + half]
    for _, row in found.iterrows():
        assert row[["gain", "gain_low", "gain_high"]].to_list() == pytest.approx(expected)
    second = found.loc[filled[1]]
    assert second[["whole", "quarter", "n_S_percent", "n_S_percent_quarter"]].to_list() == pytest.approx(
        [5.0, 2 + 3.5 / 3, 32.0, 23.0]
    )
    assert found.loc[0, "whole"] == pytest.approx(3 + (len(filled) + 1) / 2)


def test_the_smallest_are_recovered_each_once(monkeypatch, tmp_path):
    sizes = {"c": 3, "a": 1, "b": 2}
    molecules = {name: SimpleNamespace(n_atoms=n, n_residues=10 * n) for name, n in sizes.items()}
    ordered = [(name, name, molecules[name]) for name in ("a", "b", "c")]
    monkeypatch.setattr(study_proteins, "structures", lambda folder: ordered)
    monkeypatch.setattr(study_proteins, "distinct", iter)
    monkeypatch.setattr(study_proteins, "check", lambda config: {"sampling": SAMPLING})
    asked, saved = [], []
    one = SimpleNamespace(n_dots=1)
    monkeypatch.setattr(study_proteins, "measure", lambda *given: asked.append(given) or (one,))
    monkeypatch.setattr(study_proteins, "save", lambda place, *tables, **more: saved.append((place, more)))
    (tmp_path / "recovered" / "a").mkdir(parents=True)
    study_proteins.main("folder", tmp_path, recovered=2)
    assert [place for place, _ in saved] == [
        tmp_path / "a",
        tmp_path / "b",
        tmp_path / "c",
        tmp_path / "recovered" / "b",
    ]
    assert saved[1][1] == {"n_atoms": 2, "n_residues": 20}
    molecule, name, combinations, *_, counts, readings = asked[-1]
    assert molecule is molecules["b"] and name == "b"
    assert readings == ("recovered",) and counts == OF_RECOVERED
    assert np.array_equal(combinations, law.grid([0.1, 0.3], [0], [2, 4], [1]))
    assert np.array_equal(asked[0][2], law.grid([0.1, 0.2, 0.3], [0], [2, 4], [1]))
    assert asked[0][-1] == ("kept", "surface")
    del saved[:], asked[:]
    study_proteins.main("folder", tmp_path / "all", whole=1)
    assert [place.relative_to(tmp_path / "all").as_posix() for place, _ in saved] == [
        "a",
        "b",
        "c",
        "recovered_whole/a",
    ]
    _, name, combinations, *_, counts, readings = asked[-1]
    assert name == "a" and readings == ("recovered",) and counts == OF_RECOVERED
    assert np.array_equal(combinations, law.grid([0.1, 0.2, 0.3], [0], [2, 4], [1]))
    del saved[:]
    study_proteins.main("folder", tmp_path / "small", most_dots=70)  # two atoms have about as many
    assert [place.name for place, _ in saved] == ["a", "b"]


def test_a_large_protein_gets_one_draw_by_n_s(measured, monkeypatch):
    asked, n_dots = [], measured[1][0].n_dots
    monkeypatch.setattr(protein_scores, "by_n_s", lambda _, counts: asked.append(counts.draws_by_n_s))
    for most in (n_dots, n_dots - 1):
        monkeypatch.setattr(protein_scores, "ONE_DRAW", most)
        measure(measured[0], "p", GRID, counts=FEW._replace(draws_by_n_s=2))
    assert asked == [2, 1]


def test_rules_are_changed_on_the_smallest_of_four_hundred_atoms(monkeypatch, tmp_path):
    proteins = [(f"p{n}", f"p{n}", SimpleNamespace(n_atoms=n)) for n in (399, 400, 401)]
    places = []
    monkeypatch.setattr(study_proteins, "with_hydrogens", lambda *_: [("p399", "with its hydrogens")])
    monkeypatch.setattr(study_proteins, "_measure_one", lambda place, *_: places.append(place))
    monkeypatch.setattr(protein_variants, "enter_short_descriptor", lambda: None)
    monkeypatch.setattr(
        protein_variants, "VARIANTS", {key: {} for key in ("as it is", "probe 1.2 Å", "hydrogens kept")}
    )
    study_proteins.measure_variants(proteins, tmp_path, GRID, 1, 1)
    assert [place.relative_to(tmp_path).as_posix() for place in places] == [
        "as it is/p400",
        "as it is/p399",
        "probe 1.2 Å/p400",
        "hydrogens kept/p399",
    ]


def test_what_is_saved_comes_back_and_half_a_protein_is_refused(measured, tmp_path):
    protein_files.save(tmp_path / "p", *measured[1], n_atoms=20)
    result, floors, _, single = protein_files.load(tmp_path / "p")
    assert result.mean_roughness == measured[1][0].mean_roughness and single["n_atoms"] == 20
    pd.testing.assert_frame_equal(result.ranges, measured[1][0].ranges, check_dtype=False)
    pd.testing.assert_frame_equal(floors, measured[1][1])
    protein_files.save(tmp_path / "z", replace(measured[1][0], n_dots=7), *measured[1][1:], n_atoms=1)
    (tmp_path / "p").rename(tmp_path / "r")
    (tmp_path / "r.part").mkdir()
    (tmp_path / "r.part" / "protein.json").write_text("{")  # of a run that was killed
    assert [each[0].protein for each in protein_files.load_all(tmp_path)] == ["z", "r"]  # the smaller first
    (tmp_path / "r").rename(tmp_path / "p")
    (tmp_path / "p" / "by_n_s.csv").unlink()
    with pytest.raises(InputError, match="does not hold what was measured"):
        protein_files.load_all(tmp_path)
    with pytest.raises(InputError, match="holds no measured protein"):
        write_proteins.main(str(tmp_path / "nothing"), tmp_path, tmp_path)


def test_variants_and_recovered_grids_are_taken_from_their_folders(tmp_path, monkeypatch):
    for name in ("variants/probe 1.2 Å", "recovered", "recovered_whole", "tables", "evidence"):
        (tmp_path / name).mkdir(parents=True)
    asked, one = [], pd.DataFrame({"value": [1.2345678]})
    monkeypatch.setattr(write_proteins, "load_all", lambda folder: folder.relative_to(tmp_path).as_posix())
    monkeypatch.setattr(
        write_proteins, "tables_of", lambda *given: asked.append(given) or {"d": one, "summary": one}
    )
    write_proteins.write_tables(tmp_path, tmp_path / "tables", tmp_path / "evidence")
    assert asked == [(".", {"probe 1.2 Å": "variants/probe 1.2 Å"}, "recovered", "recovered_whole")]
    for path in ("tables/proteins_d.csv", "evidence/summary.csv.gz"):
        assert pd.read_csv(tmp_path / path)["value"].tolist() == [1.2346]
    # the same bytes whenever they are written: a gzip file tells the time otherwise
    assert (tmp_path / "evidence" / "summary.csv.gz").read_bytes()[4:8] == bytes(4)


def test_rows_of_what_was_not_measured_again_stay(tmp_path, monkeypatch):
    monkeypatch.setattr(write_proteins, "load_all", lambda folder: [])
    for shares in ({"d": 0.9, "d, `recovered`": 0.8}, {"d": 0.95}):
        table = pd.DataFrame({"quantity": list(shares), "coverage": list(shares.values())})
        found = {"coverage": table, "d": table}
        monkeypatch.setattr(write_proteins, "tables_of", lambda *_, found=found: found)
        write_proteins.write_tables(tmp_path, tmp_path, tmp_path)
    stored = pd.read_csv(tmp_path / "proteins_coverage.csv")
    assert stored.to_numpy().tolist() == [["d", 0.95], ["d, `recovered`", 0.8]]
    assert pd.read_csv(tmp_path / "proteins_d.csv").to_numpy().tolist() == [
        ["d", 0.95]
    ]  # whole tables are new


def test_one_rule_changed_at_a_time():
    assert protein_variants.rules_of(protein_variants.DEFAULT) == Rules()
    for variant, changes in protein_variants.VARIANTS.items():
        rules = protein_variants.rules_of(variant)
        assert {key: getattr(rules, key) for key in changes} == changes and len(changes) <= 1
        numbers = [value for value in changes.values() if isinstance(value, float)]
        assert numbers == [float(word) for word in variant.split() if re.fullmatch(r"[0-9.]+", word)] or (
            variant == protein_variants.SHORT
        )
        assert variant in (protein_variants.DEFAULT, protein_variants.HYDROGENS) or rules != Rules()
    assert thin_grid({"alpha": [1, 2, 3], "beta": [4, 5], "gamma": [1, 2, 3]}) == {
        "beta": [4],
        "alpha": [1, 3],
        "gamma": [1, 2, 3],
    }


def test_the_short_descriptor_is_the_beginning_of_the_published_one(measured, monkeypatch):
    monkeypatch.delitem(DESCRIPTORS, protein_variants.SHORT, raising=False)
    protein_variants.enter_short_descriptor()
    try:
        short, whole = (
            ready(measured[0], "p", Rules(descriptor=name), 1)[0].describe(np.arange(5))[0]
            for name in (protein_variants.SHORT, PUBLISHED)
        )
    finally:
        DESCRIPTORS.pop(protein_variants.SHORT)
    few = [k for k, (order, _) in enumerate(indices()) if order <= 10]
    assert short.shape == (5, len(few)) == (5, 36)
    assert np.array_equal(short, whole[:, few])


def test_claims_of_variants_are_set_against_the_unvaried_rules(measured):
    result, floors, by_n_s = measured[1]
    worse = by_n_s.assign(Z=np.where(by_n_s["islands"] == "recovered", 2 * by_n_s["Z"], by_n_s["Z"]))
    table = protein_variants.table(
        {
            protein_variants.DEFAULT: [(result, floors, by_n_s, {})],
            "other": [(result, floors, worse, {}), (replace(result, protein="new"), floors, worse, {})],
        }
    ).set_index(["variant", "claim"])
    assert table.loc[("other", "d_kept"), "change"] == 0
    assert (table["n"] == 1).all()  # one of them was not measured by the unvaried rules
    before, after = (table.loc[(each, "over_floor"), "value"] for each in (protein_variants.DEFAULT, "other"))
    assert after == pytest.approx(2 * before) and table.loc[
        ("other", "over_floor"), "change"
    ] == pytest.approx(before)
    assert table.loc[(protein_variants.DEFAULT, "held"), "value"] == 1
    at_ten = by_n_s[(by_n_s["sampler"] == "farthest") & (by_n_s["islands"] == "recovered")].set_index(
        "percent"
    )
    fresh = floors.set_index("floor").loc["fresh dots", "Z"]
    assert before == pytest.approx(at_ten.loc[10.0, "Z"] / fresh)
