"""Many complexes: superposition and labels of other forms, relative distances, means with intervals, choosing on few."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.distance import cdist
from scipy.spatial.transform import Rotation
from scipy.stats import t

from conftest import ROOT
from measures import complex_tables, partners
from measures.complex_tables import tables_of
from measures.tables import read_tables
from peptides import peptide, write
from sparsurf import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.pairs import complex_scores, complexes
from sparsurf.pairs.complex_scores import centres_of, score_complex
from sparsurf.pairs.matching import Recipe
from sparsurf.pairs.partners import partner_of
from sparsurf.surfaces.molecular_surface import molecular_surface, surface_for_d_link
from sparsurf.surfaces.radii import radii

SEQUENCE = ("ALA", "LEU", "LYS", "GLY")


@pytest.fixture(scope="module")
def molecules(tmp_path_factory):
    folder = tmp_path_factory.mktemp("complexes")
    return [
        read_molecule(write(folder / f"{chain}.pdb", peptide(3 * SEQUENCE, chain, origin=(0, y, 0))))
        for chain, y in (("A", 0.0), ("B", 8.0))
    ]


@pytest.fixture(scope="module")
def pair(molecules):
    out = []
    for name, molecule in zip("AB", molecules, strict=True):
        surface = molecular_surface(molecule.xyz[0], radii(molecule, "dms"), density=6.0)
        out.append(partner_of(surface, molecule, name))
    return out


def test_another_form_is_placed_on_and_takes_the_labels(molecules):
    straight = molecules[0]
    bend = 5 * np.sin(
        straight.xyz[..., :1] / [8.0, 3.0, 5.0]
    )  # in a straight chain the C-alpha atoms fix no turn about it
    bound = replace(straight, xyz=straight.xyz + bend)
    turn = Rotation.random(rng=2).as_matrix()
    moved = replace(bound, xyz=bound.xyz @ turn.T + [30.0, -5, 2])
    part = moved.take(moved.residue != "1")  # one residue is missing in the other form
    laid = complexes.superpose_onto(part, bound)
    assert np.abs(laid.xyz[0] - bound.xyz[0][bound.residue != "1"]).max() < 1e-9
    labels = bound.xyz[0][:, 0] > 10
    carried = complexes.carried_labels(laid.xyz[0] + 0.1, bound.xyz[0], labels)
    assert np.array_equal(carried, labels[bound.residue != "1"])
    with pytest.raises(InputError, match="share 0 residues"):
        complexes.superpose_onto(molecules[1], bound)


def test_relative_values_lose_what_flatness_explains():
    rng = np.random.default_rng(3)
    rough, noise = rng.random(2000), rng.normal(0, 0.01, 2000)
    left = complexes.relative(3 * np.round(rough, 1) + noise, np.round(rough, 1), bins=10)
    assert left.std() < 0.2 * (3 * rough).std()
    in_bin = np.argsort(np.argsort(np.round(rough, 1), kind="stable")) * 10 // 2000
    assert np.allclose(np.bincount(in_bin, left), 0, atol=1e-9)


@pytest.mark.filterwarnings("ignore:invalid value")  # empty bins
def test_scores_of_four_patches_by_hand():
    # two rough patches 5 Å apart and, 100 Å away, two flat ones; the two nearest of each
    points = np.array([[0.0, 0, 0], [5, 0, 0], [100, 0, 0], [105, 0, 0]])
    partner = SimpleNamespace(
        surface=SimpleNamespace(points=points), roughness=np.repeat([0.1, 0.2, 0.8, 0.9], 1)
    )
    near = SimpleNamespace(distance=np.array([[1.0, 3.0], [3.0, 5.0], [6.0, 8.0], [10.0, 10.0]]))
    found = complexes.distance_scores(partner, np.arange(4), near, (1, 2))
    assert found[1, "plain", "raw"].tolist() == [-1, -3, -6, -10]
    assert found[2, "plain", "raw"].tolist() == [-2, -4, -7, -10]
    assert found[2, "plain", "smoothed"].tolist() == [-3, -3, -8.5, -8.5]
    assert found[1, "relative", "raw"].tolist() == [0, 0, 0, 0]  # ten bins of four patches: each its own
    assert complexes.relative(near.distance[:, 0], partner.roughness, 2).tolist() == [-1, 1, -2, 2]


@pytest.mark.filterwarnings("ignore:invalid value")
def test_complementarity_takes_the_second_down_and_similarity_up():
    up, down = ([np.array([[0.0], [5.0]]), np.array([[1.0], [9.0]])], [None, np.array([[3.0], [20.0]])])
    partner = SimpleNamespace(
        surface=SimpleNamespace(points=np.array([[0.0, 0, 0], [50, 0, 0]])), roughness=np.array([0.1, 0.9])
    )
    first, second = complexes.scores_of_pair([partner] * 2, [np.arange(2)] * 2, up, down, (1,), "name")
    assert first["name", "complementarity", 1, "plain", "raw"].tolist() == [-3, -2]
    assert second["name", "complementarity", 1, "plain", "raw"].tolist() == [-2, -15]
    assert first["name", "similarity", 1, "plain", "raw"].tolist() == [-1, -4]
    assert second["name", "similarity", 1, "plain", "raw"].tolist() == [-1, -4]


def test_together_takes_ranks():
    assert complexes.mean_rank([1.0, 2, 300], [3.0, 2, 1]).tolist() == [2.0, 2.0, 2.0]


def test_means_over_complexes_average_the_sides_first():
    table = pd.DataFrame({"complex": list("aabbc"), "score": "s", "auc": [0.4, 0.6, 0.7, 0.9, np.nan]})
    row = complexes.means_over_complexes(table, ["score"]).iloc[0]
    half = t.ppf(0.975, 1) * np.std([0.5, 0.8], ddof=1) / np.sqrt(2)
    assert row["mean"] == pytest.approx(0.65)
    assert (row["low"], row["high"]) == (pytest.approx(0.65 - half), pytest.approx(0.65 + half))
    assert row["complexes"] == 2


def test_variants_are_chosen_on_few_and_reported_on_the_others():
    table = pd.DataFrame(
        [(name, variant, value) for name, values in {"a": (0.9, 0.5), "b": (0.4, 0.6), "c": (0.2, 0.8)}.items()
         for variant, value in zip("xy", values, strict=True)],
        columns=["complex", "variant", "auc"],
    )  # fmt: skip
    chosen = complexes.chosen_on_few(table, ["variant"], {"a"})
    assert chosen["variant"].tolist() == ["x", "y"]
    assert chosen["chosen_on"].tolist() == [0.9, 0.5]
    assert chosen["mean"].tolist() == pytest.approx([0.3, 0.7])


def test_a_complex_gets_all_scores_and_the_tables_sum_them_up(pair):
    recipes = (Recipe(), Recipe(radius=8.0))
    table, touching, own, same = score_complex(pair, None, None, recipes, (1, 3), max_patches=200)
    assert np.isnan(same).all()
    labels = [each.surface.points[:, 0] > 9 for each in pair]  # as of another form
    again, _, _, same = score_complex(pair, own, labels, recipes, (1, 3), max_patches=200)
    for side in (0, 1):
        at_centres = labels[side][centres_of(pair[side], 200)]
        assert (again.loc[again["side"] == side + 1, "interface"] == at_centres.sum()).all()
    assert same == pytest.approx((1.0, 1.0))  # against itself the control is the map
    control = again[again["score"] == "another protein"].set_index(["side", "map"])["auc"]
    plain = again[(again["score"] == "complementarity") & (again["k"] == 1) & (again["kind"] == "plain")]
    plain = plain[plain["descriptor"] == "published, 6 Å"].set_index(["side", "map"])["auc"]
    pd.testing.assert_series_equal(control.sort_index(), plain.sort_index())
    dots = centres_of(pair[0], 200)
    first = {("published, 6 Å", *complex_scores.MAIN, "smoothed"): pair[0].surface.points[dots, 1]}
    ends = [
        complex_scores._rows(replace(pair[0], name=name), dots, first, labels[0], 0)
        for name in ("one", "one", "other")
    ]
    low = [table["low"][0] for table in ends]  # each surface has random numbers of its own
    assert low[0] == low[1] != low[2] and np.isfinite(low).all()
    assert len(table) == 2 * (
        2 * 2 * 2 * 2 * 2 + 9
    )  # radii, both maps, k, kinds, smoothing; references, combinations
    for side in (0, 1):
        own = pair[side].surface.points[centres_of(pair[side], 200)]
        touching_dots = cdist(own, pair[1 - side].surface.points).min(axis=1) < 3.0
        assert (table.loc[table["side"] == side + 1, "interface"] == touching_dots.sum()).all()
    assert table["interface"].nunique() == 2
    measured = table.dropna(subset="low")
    assert {"complementarity", "flatness", "propensity + protrusion"} <= set(measured["score"])
    assert ((measured["low"] < measured["auc"]) & (measured["auc"] < measured["high"])).all()
    assert table["auc"].between(0, 1).all()
    assert (table["patches"] == 200).all()

    tables = [table.assign(complex=name, form="bound") for name in ("1a1u", "a", "b")]
    tables += [again.assign(complex="six", form=form) for form in ("bound", "unbound")]
    contacts = touching.assign(complex="a", descriptor="published")
    controls = pd.DataFrame(
        {"complex": ["a", "b"], "form": "bound", "correlation_1": [0.5, 0.7], "correlation_2": [0.7, 0.9],
         "descriptor": "published"}
    )  # fmt: skip
    found = tables_of(pd.concat(tables), contacts, controls)
    means = found["complexes_means"].set_index(["group", "score", "map"])["mean"]
    assert set(means.index.levels[0]) == {"tutorial", "bound", "bound six", "unbound six"}
    assert means["bound", "flatness", "-"] == pytest.approx(table[table["score"] == "flatness"]["auc"].mean())
    assert found["complexes_control"]["mean"].tolist() == pytest.approx([0.7])
    assert len(found["complexes"]) == 5 * 2 * 7
    assert len(found["complexes_variants"]) == 0  # all of these are among the first ten: nothing to report on


def test_centres_are_spread(pair):
    dots = centres_of(pair[0], 50)
    assert len(dots) == 50
    place = pair[0].surface.points[dots]
    apart = np.linalg.norm(place[:, None] - place[None], axis=2) + 100 * np.eye(50)
    uniform = pair[0].surface.points[centres_of(pair[0], 50, "uniform")]
    closer = np.linalg.norm(uniform[:, None] - uniform[None], axis=2) + 100 * np.eye(50)
    assert apart.min() > 2 * closer.min()
    with pytest.raises(InputError, match=r"complementarity\.centres\.sampler: there is no sampler 'fathest'"):
        centres_of(pair[0], 50, "fathest")


def test_surfaces_of_complexes_are_placed_by_the_published_rules(molecules):
    partner = partners.ready(molecules[0], "A")
    rules = {"method": "analytic", "density": "auto", "probe_radius": 1.4, "reentrant": "exact"}
    wanted, _ = surface_for_d_link(molecules[0], 0, radii(molecules[0], "dms"), rules, 0.5, "A")
    assert np.array_equal(partner.surface.points, wanted.points) and partner.name == "A"
    assert partner.residues["residue_name"].tolist() == list(3 * SEQUENCE)


def test_an_unbound_form_takes_the_interface_of_the_bound_one(molecules, tmp_path):
    turn = Rotation.from_euler("z", 90, degrees=True).as_matrix()
    paths, moved = [], []
    for name, residues in (("A", "209-222"), ("B", "223-236")):
        molecule = read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues=residues)
        paths.append(tmp_path / f"{name}.pdb")
        moved.append(tmp_path / f"{name}_u.pdb")
        molecule.write_pdb(paths[-1], 0)
        replace(molecule, xyz=molecule.xyz @ turn.T + 20.0).write_pdb(moved[-1], 0)
    pair, labels = partners.unbound_pair(moved, paths, "x")
    bound = partners.pair_of(paths, "x")
    gaps = cdist(bound[0].surface.points, bound[1].surface.points).min(axis=1)
    assert [len(each) for each in labels] == [len(each.surface) for each in pair]
    assert labels[0].mean() == pytest.approx((gaps < 3).mean(), abs=0.03)


def scored(complex_, form, score, auc, **others):
    row = {"complex": complex_, "form": form, "side": 1, "descriptor": "published, 6 Å", "score": score}
    row |= {"k": 1, "kind": "plain", "map": "raw", "auc": auc, "low": auc - 0.1, "high": auc + 0.1}
    return row | {"patches": 9, "interface": 3} | others


def test_groups_main_scores_and_variants_by_hand():
    rows = [scored("1a1u", "bound", "complementarity", 0.9), scored("six", "unbound", "complementarity", 0.5)]
    rows += [
        scored("six", "bound", "complementarity", 0.7),
        scored("b", "bound", "flatness", 0.4, k=0, kind="-"),
    ]
    rows += [
        scored("b", "bound", "complementarity", 0.6),
        scored("b", "bound", "complementarity", 0.2, side=2),
    ]
    rows += [scored("b", "bound", "complementarity", 0.1, k=10), scored("b", "bound", "a + b", 0.1, k=0)]
    rows += [scored("b", "bound", "complementarity", 0.3, descriptor="published, 12 Å")]
    rows += [scored("b", "bound", "complementarity", 0.35, kind="relative", low=np.nan)]
    areas = complex_tables.named(pd.DataFrame(rows))
    groups = areas.drop_duplicates(["complex", "form"]).set_index(["complex", "form"])["group"]
    assert groups.to_dict() == {
        ("1a1u", "bound"): "tutorial",
        ("six", "unbound"): "unbound six",
        ("six", "bound"): "bound six",
        ("b", "bound"): "bound",
    }
    means = complex_tables.means(areas).set_index(["group", "score"])["mean"]
    assert means.to_dict() == pytest.approx(
        {
            ("tutorial", "complementarity"): 0.9,
            ("unbound six", "complementarity"): 0.5,
            ("bound six", "complementarity"): 0.7,
            ("bound", "flatness"): 0.4,
            ("bound", "complementarity"): 0.4,  # both sides, k = 1, the first radius
        }
    )
    main = complex_tables.surfaces(areas)
    assert len(main) == 7 and "a + b" not in set(main["score"])
    contacts = pd.DataFrame(
        {"complex": ["b", "1a1u"], "descriptor": "d", "against": "any pair", "auc": [0.5, 0.75]}
    )
    found = complex_tables.touching(contacts, pd.Series({"b": "bound", "1a1u": "tutorial"}))
    assert found.set_index("group")["mean"].to_dict() == {"bound": 0.5, "tutorial": 0.75}
    controls = pd.DataFrame(
        {"complex": ["a", "b", "c"], "form": ["bound", "unbound", "bound"], "correlation_1": [0.5, 9, np.nan],
         "correlation_2": [0.7, 9, np.nan], "descriptor": "d"}
    )  # fmt: skip
    row = complex_tables.control(controls).iloc[0]
    assert (row["mean"], row["complexes"]) == (pytest.approx(0.6), 1)


def test_variants_are_chosen_on_the_tutorial_and_the_first_ten():
    names = ["1a1u", *(f"p{k:02d}" for k in range(12))]
    rows = [scored(name, "bound", "complementarity", 0.5 + 0.01 * i, group="tutorial" if i == 0 else "bound")
            for i, name in enumerate(names)]  # fmt: skip
    rows += [scored("x", "unbound", "complementarity", 9.0, group="unbound six")]
    row = complex_tables.variants(pd.DataFrame(rows)).iloc[0]
    assert row["chosen_on"] == pytest.approx(0.55)  # 0.50 .. 0.60
    assert (row["mean"], row["complexes"]) == (pytest.approx(0.615), 2)


def test_a_complex_that_looks_like_a_number_keeps_its_name(tmp_path):
    for name in ("1E96", "1CGI"):
        (tmp_path / f"{name}.csv").write_text(f"complex,auc\n{name},0.5\n")
    table = read_tables([tmp_path / "1E96.csv", tmp_path / "1CGI.csv"])
    assert table["complex"].tolist() == ["1E96", "1CGI"] and table["auc"].sum() == 1
