"""Sites: exact search and poses against plain references, the same site on a turned molecule, files and refusals."""

import gzip
import shutil
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import sparsurf
from conftest import ROOT
from sparsurf import InputError
from sparsurf.cli.command import main
from sparsurf.patches.descriptors import PATCHES_PER_CALL
from sparsurf.sites import describing, finding, metric
from sparsurf.sites.describing import FIELDS, _fill_unknown, load_sites, sites_of
from sparsurf.sites.finding import BLOCK, chance, nearest_places
from sparsurf.sites.metric import discriminant, learn_weights, to_metric_space
from sparsurf.sites.pose_search import _likeliest, _scores, _Search, best_pose, rigid_fit

PEPTIDE = ROOT / "data" / "tdp43" / "topology.pdb"
TURN = Rotation.from_euler("xyz", [40, 100, 250], degrees=True).as_matrix()


@pytest.fixture(scope="module")
def turned(tmp_path_factory):
    """The peptide turned and shifted, as a file."""
    molecule = sparsurf.read_molecule(PEPTIDE)
    path = tmp_path_factory.mktemp("turned") / "turned.pdb"
    replace(molecule, xyz=molecule.xyz @ TURN + [5.0, -20, 30]).write_pdb(path)
    return path


@pytest.fixture(scope="module")
def sites():
    return sparsurf.describe_sites(PEPTIDE, percent=8)


@pytest.fixture(scope="module")
def sites_of_turned(turned):
    return sparsurf.describe_sites(turned, percent=8)


def test_the_search_in_blocks_is_the_whole_sort():
    rng = np.random.default_rng(0)
    query = rng.normal(size=(7, 16)).astype(np.float32)
    targets = rng.normal(size=(2 * BLOCK + 100, 16)).astype(np.float32)
    distance, place = nearest_places(query, targets, 5, threads=2)
    whole = np.linalg.norm(query[:, None].astype(float) - targets, axis=2)
    np.testing.assert_array_equal(place, np.argsort(whole, axis=1)[:, :5])
    np.testing.assert_allclose(distance, np.sort(whole, axis=1)[:, :5], rtol=1e-4)


def test_places_far_from_the_origin_are_distinguished_and_equal_ones_come_in_order():
    """At 1,000 from the origin, squares in float32 have errors of 0.1; the distances here are 0, 0.001, 0.002, ..."""
    targets = np.full((3 * BLOCK, 4), 1000.0)
    targets[:, 0] += 1e-3 * np.arange(3 * BLOCK)[::-1]
    targets[-3] = targets[-1]
    distance, place = nearest_places(targets[-1:].copy(), targets, 4, threads=2)
    np.testing.assert_allclose(distance, [[0, 0, 1e-3, 3e-3]], atol=1e-12)
    last = len(targets) - 1
    assert place.tolist() == [[last - 2, last, last - 1, last - 3]]


def test_an_identical_place_leaves_the_spread_of_unrelated_ones_alone():
    """Without its like among the targets or with it, p of another hit is the same, up to the median's rank."""
    rng = np.random.default_rng(3)
    pooled, q = rng.normal(size=(400, 64)), rng.normal(size=(1, 64))
    middle, scale = finding._background(q, pooled)
    with_like = np.concatenate([pooled, q, q + 1e-9, q + 0.02 * rng.normal(size=q.shape)])
    middle_with, scale_with = finding._background(q, with_like)
    np.testing.assert_allclose(middle, middle_with, atol=0.002)
    np.testing.assert_allclose(scale, scale_with, rtol=0.005)
    logs = np.log(np.linalg.norm(q[:, None] - pooled, axis=2))
    np.testing.assert_allclose(middle, np.median(logs, axis=1))
    np.testing.assert_allclose(scale, logs.std(axis=1))


@pytest.mark.parametrize(("n", "described"), [(12, True), (11, False)])
def test_a_patch_of_twelve_dots_is_described(n, described):
    x, y = np.divmod(np.arange(float(n)), 4)
    points = np.stack([x, y, 0 * x], axis=1)
    dots = sparsurf.Surface(points, np.tile([0.0, 0, 1], (n, 1)))
    labels = pd.DataFrame(dict.fromkeys(("chain", "residue", "residue_name"), [""] * n))
    if described:
        assert len(sites_of(dots, labels, "flat", 100)) == n
        return
    with pytest.raises(InputError, match="flat: no patch has 12 dots"):
        sites_of(dots, labels, "flat", 100)


@pytest.mark.parametrize(
    ("height", "degrees", "meets"),
    [(2.4, 0, True), (2.6, 0, False), (0, 72, True), (0, 73, False), (0, 100, False), (0, 180, False)],
)
def test_places_meet_within_two_and_a_half_angstrom_and_73_degrees(height, degrees, meets):
    """cos 72° = 0.309 and cos 73° = 0.292, and 0.3 is the limit."""
    points, normals = np.eye(3) * 9, np.tile([0.0, 0, 1], (3, 1))
    tilt = np.tile([np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))], (3, 1))
    there = points + np.array([0, 0, height])
    search = _Search(points, normals, there, tilt, cKDTree(there), np.diag([1.0, 2, 4]))
    scores, match = _scores(search, np.eye(3)[None], np.zeros((1, 3)))
    assert scores[0] == (7 if meets else 0) and match[0].tolist() == ([0, 1, 2] if meets else [-1] * 3)


def test_distances_of_equal_places_are_the_least():
    rng = np.random.default_rng(4)
    places = 1e3 + rng.normal(size=(50, 64))
    logs = finding.log_distances(places[:3], places)
    whole = np.linalg.norm(places[:3, None] - places, axis=2)
    np.testing.assert_allclose(logs, np.log(np.maximum(whole, finding.MIN_DISTANCE)), rtol=1e-9)
    assert np.exp(logs.min(axis=1)) == pytest.approx([1e-3] * 3)


def test_of_equally_likely_places_the_first_are_candidates():
    likelihood = np.array([[0.0, 2, 0, 1, 0, 0], [3, 3, 3, 3, 3, 3]])
    assert _likeliest(likelihood, 4).tolist() == [[0, 1, 2, 3], [0, 1, 2, 3]]


def test_a_rigid_fit_and_the_best_pose_undo_a_turn():
    rng = np.random.default_rng(1)
    points = rng.uniform(-10, 10, (20, 3))
    normals = points / np.linalg.norm(points, axis=1)[:, None]
    turn, shift = rigid_fit(points, points @ TURN + [1, 2, 3], np.ones(20))
    np.testing.assert_allclose(turn, TURN, atol=1e-9)
    np.testing.assert_allclose(shift, [1, 2, 3], atol=1e-9)
    others = rng.uniform(-30, 30, (200, 3))
    target = np.concatenate([points @ TURN + [1, 2, 3], others])
    target_normals = np.concatenate([normals @ TURN, others / np.linalg.norm(others, axis=1)[:, None]])
    likelihood = rng.uniform(0, 1, (20, 220))  # of wrong matches
    likelihood[np.arange(20), np.arange(20)] = np.where(np.arange(20) % 2, 1.5, 0.2)  # half of the right ones
    pose = best_pose(points, normals, target, target_normals, likelihood)
    np.testing.assert_allclose(pose.rotation, TURN, atol=1e-6)
    assert (pose.match == np.arange(20)).all()
    assert pose.score == pytest.approx(likelihood[np.arange(20), np.arange(20)].sum())


def test_weights_turn_noise_down():
    """Of two numbers that vary alike, the one that differs between two forms counts less."""
    rng = np.random.default_rng(2)
    true = rng.normal(size=(500, 1, 2))
    noise = rng.normal(size=(2, 500, 1, 2)) * [0.05, 2.0]
    learned = learn_weights(
        (true + noise[0], true + noise[1]), np.concatenate([true + noise[0], true + noise[1]]), ["shape"]
    )
    _, matrix = discriminant(("shape",), learned)
    steady, noisy = np.linalg.norm(matrix, axis=1)
    assert steady > 5 * noisy
    with pytest.raises(InputError, match="colour has no weights"):
        to_metric_space(np.zeros((3, 2, 2)), ("colour",), learned)


def test_places_are_found_again_on_a_turned_molecule(sites, sites_of_turned):
    at = np.arange(0, len(sites), 25)
    table = sparsurf.find(sites, sites_of_turned, at=at, n=3)
    best = table[table["rank"] == 1]
    true = sites.points[at] @ TURN + [5.0, -20, 30]
    gap = np.linalg.norm(best[["x", "y", "z"]].to_numpy() - true, axis=1)
    # other dots of the same surface, 1.5 Å apart: two forms of proteins give .83
    assert (gap < 3).mean() > 0.9
    assert (table.groupby("query")["score"].diff().dropna() <= 0).all()


def test_a_site_is_found_as_a_whole_with_its_pose(turned, tmp_path):
    hits, folder = tmp_path / "hits.csv", tmp_path / "laid"
    call = ["find", str(PEPTIDE), str(turned), "--residues", "215-222", "--percent", "8"]
    assert main([*call, "-o", str(hits), "--superpose", str(folder)]) == 0
    row = pd.read_csv(hits).iloc[0]
    assert row["rank"] == 1 and row["target"] == "turned" and row["places"] > 10
    laid = sparsurf.read_molecule(folder / "01_turned.pdb")
    there = sparsurf.read_molecule(turned)
    assert np.sqrt(((laid.xyz - there.xyz) ** 2).sum(axis=2).mean()) < 1.0


def test_a_site_is_placed_on_each_of_several_targets_and_targets_of_one_name_are_distinguished(
    tmp_path, capsys
):
    molecule = sparsurf.read_molecule(PEPTIDE, residues="209-216")
    molecule.write_pdb(tmp_path / "q.pdb")
    there = {}
    for k, folder in enumerate("ab"):
        (tmp_path / folder).mkdir()
        turn = Rotation.from_rotvec([0.5 + k, 0.3, -1.0 * k]).as_matrix()
        there[f"m{'' if not k else ' (2)'}"] = moved = replace(molecule, xyz=molecule.xyz @ turn + 30 * k + 5)
        moved.write_pdb(tmp_path / folder / "m.pdb")
    targets = [str(tmp_path / folder / "m.pdb") for folder in "ab"]
    call = [
        *targets,
        "--residues",
        "209-216",
        "-o",
        str(tmp_path / "h.csv"),
        "--superpose",
        str(tmp_path / "laid"),
    ]
    assert main(["find", str(tmp_path / "q.pdb"), *call, "--hits", "2"]) == 0
    table = pd.read_csv(tmp_path / "h.csv")
    assert sorted(table["target"]) == ["m", "m (2)"] and "2 targets are called m" in capsys.readouterr().err
    for row in table.itertuples():
        laid = sparsurf.read_molecule(tmp_path / "laid" / f"{row.rank:02d}_{row.target}.pdb")
        assert np.sqrt(((laid.xyz - there[row.target].xyz) ** 2).sum(axis=2).mean()) < 2.0


@pytest.mark.parametrize("hits", [1, 2])
def test_as_many_hits_are_written_as_requested(tmp_path, sites, hits):
    for name in ("query", "a", "b", "c"):
        replace(sites, name=name).save(tmp_path / f"{name}.sites")
    files = [str(tmp_path / f"{name}.sites") for name in ("query", "a", "b", "c")]
    options = ["--residues", "215-217", "--percent", "8", "--hits", str(hits), "-o", str(tmp_path / "h.csv")]
    assert main(["find", *files, *options]) == 0
    assert pd.read_csv(tmp_path / "h.csv")["target"].tolist() == ["a", "b"][:hits]


def test_nothing_is_reported_of_a_target_on_which_nothing_fits(sites, caplog):
    few = sites.take(np.flatnonzero(sites.labels["residue"] == "215"))
    one = few.take([0])
    far = replace(one, name="far", points=one.points + 500, numbers=one.numbers + 50)
    table = sparsurf.find(replace(few, name="query"), [far], residues="215")
    assert table.empty and caplog.messages == ["no part of the site fits on far"]


def test_names_of_fields_may_come_in_any_order(small, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(small)
    names = ["potential", "charge", "aromaticity", "volume", "hydropathy"]
    call = ["find", "a.pdb", "a.sites", "--residues", "209-212", "-o", str(tmp_path / "h.csv")]
    assert main([*call, "--fields", ",".join(names)]) == 0
    assert pd.read_csv(tmp_path / "h.csv")["p"].notna().all()
    for name in ("a.pdb", "a.sites"):
        shutil.copy(name, tmp_path)
    call = ["find", "a.pdb", str(tmp_path), "--residues", "209-212", "-o", "h.csv"]
    assert main([*call, "--fields", "hydropathy,volume"]) == 0
    assert pd.read_csv("h.csv")["target"].to_list() == ["a"]
    (small / "h.csv").unlink()
    error = capsys.readouterr().err
    assert f"left out: {tmp_path}/a.sites was described with other settings than QUERY" in error


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (np.nan, "peptide: the field volume has no numbers"),
        (1e6, "peptide: a field has numbers of 10,000 and more"),
    ],
)
def test_a_field_that_cannot_be_described_is_reported(values, said, recwarn):
    dots = sparsurf.surface(sparsurf.read_molecule(PEPTIDE, residues="209-216"))
    odd = replace(dots, fields={"volume": np.full(len(dots), values) * dots.points[:, 0]})
    with pytest.raises(InputError, match=said):
        sparsurf.describe_sites(odd, fields=["volume"], name="peptide")
    assert not recwarn.list


def test_each_place_gets_as_many_hits_as_requested_where_places_lie_densely(small):
    dense = sparsurf.describe_sites(small / "a.pdb", percent=60)
    few = sparsurf.find(dense, dense, at=range(5), n=10, percent=60)
    assert few.groupby("query")["rank"].apply(list).tolist() == [list(range(1, 11))] * 5
    assert (few.sort_values(["query", "rank"]).groupby("query")["score"].diff().dropna() <= 0).all()


def test_saved_sites_come_back_and_are_small(sites, tmp_path):
    path = tmp_path / "a.sites"
    sites.save(path)
    back = load_sites(path)
    np.testing.assert_array_equal(back.numbers, sites.numbers)
    assert back.settings == sites.settings and back.labels.equals(sites.labels.astype(str))
    fields = ["hydropathy", "volume", "aromaticity", "charge", "potential"]
    own = {"fields": fields, "percent": 8, "radius": 10.0, "order": 10, "version": 2}
    assert sites.settings == own
    assert path.stat().st_size / len(sites) < 700
    table = [sparsurf.find(each, path, at=[3], n=2) for each in (sites, path)]
    pd.testing.assert_frame_equal(*table)


def test_dots_with_fields_are_described_without_the_structure(tmp_path):
    few = tmp_path / "few.csv"
    fields = ["--fields", "hydropathy,volume"]
    assert main(["minimal", str(PEPTIDE), "--percent", "8", *fields, "-o", str(few)]) == 0
    found = sparsurf.describe_sites(few, percent=100, fields=("hydropathy", "volume"))
    assert found.numbers.shape[1] == 3
    with pytest.raises(InputError, match="no potential"):
        sparsurf.describe_sites(few, percent=100, fields=("potential",))


def test_what_does_not_fit_is_refused_in_a_sentence(sites, sites_of_turned, tmp_path):
    other = replace(sites_of_turned, settings=sites_of_turned.settings | {"percent": 20.0})
    with pytest.raises(InputError, match=r"percent 20\.0, and the query with 8"):
        sparsurf.find(sites, other, at=[0])
    bare = replace(sites_of_turned, settings=sites_of_turned.settings | {"fields": ["hydropathy"]})
    with pytest.raises(InputError, match="turned has no volume"):
        sparsurf.find(sites, bare, at=[0])
    with pytest.raises(InputError, match="residues: '900-910' is not in topology"):
        sparsurf.find(sites, sites_of_turned, residues="900-910")
    with pytest.raises(InputError, match="needs 3"):
        sparsurf.find(sites.take(np.arange(2)), sites_of_turned, residues=str(sites.labels["residue"][0]))
    with pytest.raises(InputError, match="at: the query has the places 0 to"):
        sparsurf.find(sites, sites_of_turned, at=[10**6])
    with pytest.raises(InputError, match="either"):
        sparsurf.find(sites, sites_of_turned)
    old = replace(sites, settings=sites.settings | {"version": 0})
    old.save(tmp_path / "old.sites")
    with pytest.raises(InputError, match="version 0, not 2"):
        load_sites(tmp_path / "old.sites")
    (tmp_path / "no.sites").write_text("nothing")
    with pytest.raises(InputError, match="holds no Sites"):
        load_sites(tmp_path / "no.sites")
    rng = np.random.default_rng(0)
    few = rng.normal(size=(6, 3))
    few /= np.linalg.norm(few, axis=1)[:, None]
    with pytest.raises(InputError, match="no patch has 12 dots"):
        sparsurf.describe_sites(
            sparsurf.surface(([[0.0, 0, 0]], [1.7])).take(np.arange(6)), percent=100, fields=()
        )


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """Folder with a peptide of eight residues, and its Sites of other settings."""
    folder = tmp_path_factory.mktemp("small")
    molecule = sparsurf.read_molecule(PEPTIDE, residues="209-216")
    molecule.write_pdb(folder / "a.pdb")
    sites = sparsurf.describe_sites(molecule, name="a")
    sites.save(folder / "a.sites")
    replace(sites, settings=sites.settings | {"percent": 20.0}).save(folder / "percent.sites")
    few = replace(sites, numbers=sites.numbers[:, :2], settings=sites.settings | {"fields": ["hydropathy"]})
    few.save(folder / "fields.sites")
    replace(sites, numbers=sites.numbers[:5]).save(folder / "damaged.sites")
    replace(sites, points=sites.points * np.nan).save(folder / "nan.sites")
    sparsurf.write(sparsurf.surface(molecule), folder / "dots.csv")
    held = dict(np.load(folder / "a.sites"))
    for name, change in {
        "versions": {"version": np.ones(2, int)},
        "words": {"points": held["points"].astype(str)},
        "complex": {"numbers": held["numbers"].astype(complex)},
        "none": {key: value[:0] for key, value in held.items() if len(value.shape) and key != "fields"},
    }.items():
        with open(folder / f"{name}.sites", "wb") as stream:
            np.savez(stream, **held | change)
    for path in (folder / "empty" / "a.pdb", folder / "one" / "b.pdb"):
        path.mkdir(parents=True)
    (folder / "empty" / ".a.pdb").write_text("what a Finder leaves")
    (folder / "one" / "a.sites.gz").write_bytes(gzip.compress((folder / "a.sites").read_bytes()))
    return folder


@pytest.mark.parametrize(
    ("call", "said"),
    [
        ("a.sites none.pdb --residues 209-212 -o h.csv", "none.pdb does not exist"),
        ("a.sites empty --residues 209-212 -o h.csv", "holds no structure and no Sites"),
        ("a.sites percent.sites --residues 209-212 -o h.csv", "described with percent 20.0"),
        ("a.sites fields.sites --residues 209-212 -o h.csv", "a has no volume, aromaticity"),
        ("a.sites damaged.sites --residues 209-212 -o h.csv", "damaged.sites holds no Sites"),
        ("a.sites nan.sites --residues 209-212 -o h.csv", "nan.sites holds no Sites"),
        ("a.sites versions.sites --residues 209-212 -o h.csv", "versions.sites holds no Sites"),
        ("a.sites words.sites --residues 209-212 -o h.csv", "words.sites holds no Sites"),
        ("a.sites complex.sites --residues 209-212 -o h.csv", "complex.sites holds no Sites"),
        ("a.sites none.sites --residues 209-212 -o h.csv", "none.sites holds no Sites"),
        ("a.sites dots.csv --residues 209-212 -o h.csv", "dots: its dots have no hydropathy"),
        ("a.sites a.sites --residues B:209 -o h.csv", "'B:209' is not in a"),
        ("a.sites a.sites --residues x -o h.csv", "'x' is not of the form"),
        ("a.sites a.sites -o h.csv", "--residues is missing"),
        ("a.sites a.sites --residues 209 -o none/h.csv", "there is no folder"),
        ("a.sites a.sites --residues 209 -o h.csv --superpose laid", "a.sites is not a structure"),
        ("a.pdb a.sites --residues 209 -o h.csv --superpose a.pdb", "a.pdb is a file"),
        ("a.pdb -o none/a.sites", "there is no folder"),
        ("a.sites -o h.sites --percent 30", "percent: a was described with 10; leave"),
        ("a.pdb a.sites --residues 209 -o h.csv --superpose .", "--superpose: . is where a.pdb lies"),
        ("a.pdb one --residues 209 -o h.csv --superpose one", "--superpose: one is where one lies"),
        ("a.sites a.sites dots.csv --residues 209 -o dots.csv", "dots.csv is a file that is read"),
        ("a.pdb -o a.csv", "name at least one TARGET"),
        ("a.pdb -o h.sites --superpose laid", "--superpose and --hits are about hits"),
        ("a.pdb -o h.sites --hits 3", "--superpose and --hits are about hits"),
        ("a.pdb -o h.sites --fields hydropathy,bfactor", "--fields: sites are not compared by bfactor"),
        ("a.sites a.pdb --residues 209 -o h.csv --percent 20", "percent: a was described with 10; leave"),
        ("a.sites a.pdb --residues 209 -o h.csv --fields charge", "fields: a was described with hydropathy,"),
        ("a.pdb a.sites --residues 209 -o h.csv --fields colour", "there is no field 'colour'"),
        ("a.pdb a.pdb --residues 209 -o h.csv --percent 0.1", "no patch has 12 dots"),
    ],
)
def test_a_wrong_call_is_answered_in_one_sentence(small, monkeypatch, capsys, call, said):
    monkeypatch.chdir(small)
    assert main(["find", *call.split()]) == 1
    error = capsys.readouterr().err
    assert said in error and "Traceback" not in error
    assert not (small / "h.csv").exists() and not (small / "h.sites").exists()


def test_packed_sites_of_a_folder_are_searched_and_what_is_no_file_is_passed_over(small, tmp_path):
    names = str(small / "a.sites"), str(small / "one"), "--residues", "209-212", "-o", str(tmp_path / "h.csv")
    assert main(["find", *names]) == 0
    assert pd.read_csv(tmp_path / "h.csv")["target"].tolist() == ["a"]
    assert (
        main(["find", str(small / "a.pdb"), "-o", str(tmp_path / "a.sites.gz")]) == 0
    )  # as they are written
    assert np.array_equal(load_sites(tmp_path / "a.sites.gz").points, load_sites(small / "a.sites").points)


def test_sites_are_searched_by_the_settings_they_were_described_with(small):
    known = small / "percent.sites"  # with 20 %
    assert len(sparsurf.find(known, known, at=[0], n=1, percent=20)) == 1
    assert len(sparsurf.find(known, known, at=[0], n=1)) == 1
    with pytest.raises(InputError, match="percent: a was described with 20"):
        sparsurf.find(known, known, at=[0], percent=5)


def test_files_of_dots_in_a_folder_and_dots_that_are_few_are_reported(small, tmp_path, caplog, capsys):
    fields = ["--fields", ",".join(FIELDS)]
    for name, percent in (("few.csv", "12"), ("many.csv", "100")):
        assert (
            main(["minimal", str(small / "a.pdb"), "--percent", percent, *fields, "-o", str(tmp_path / name)])
            == 0
        )
    (tmp_path / "notes.txt").write_text("nothing")
    sparsurf.find(small / "a.sites", tmp_path / "few.csv", at=[0])
    assert "few.csv: its dots lie 1.0 Å apart" in caplog.text and "10 % of these are kept" in caplog.text
    caplog.clear()
    sparsurf.find(small / "a.sites", tmp_path / "many.csv", at=[0])
    assert "apart" not in caplog.text
    (tmp_path / "a.pdb").write_bytes((small / "a.pdb").read_bytes())
    call = str(small / "a.sites"), str(tmp_path), "--residues", "209-212", "-o", str(tmp_path / "hits.csv")
    assert main(["find", *call]) == 0
    said = capsys.readouterr().err
    assert "2 files of dots in" in said and "left out (few.csv, many.csv)" in said
    (tmp_path / "other.sites").write_bytes((small / "percent.sites").read_bytes())
    assert main(["find", *call]) == 0
    assert "other.sites was described with other settings than QUERY" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("at", "said"),
    [
        ([[0, 0, 0], [np.nan, 0, 0]], "point 1 has NaN"),
        ([[1.0, 2]], r"not shape \(1, 2\)"),
        (np.zeros((0, 3)), r"not shape \(0, 3\)"),
        (["x"], "not something else"),
        ([[1.0, 2, 3], [4.0]], "not something else"),
        ([[1.0, 2, 3], 4.0], "not something else"),
        ([[1e4, 0, 0]], "Å away from a"),
    ],
)
def test_places_that_are_none_are_refused(small, at, said):
    with pytest.raises(InputError, match=said):
        sparsurf.find(small / "a.sites", small / "a.sites", at=at)
    with pytest.raises(InputError, match=r"too few dots|no patch has|not |point 1"):
        sparsurf.find(small / "a.pdb", small / "a.sites", at=at)


@pytest.mark.parametrize("wrong", [5, ["charge", 5], [["charge"]], np.array([1.0])])
def test_names_of_fields_are_words(small, wrong):
    with pytest.raises(InputError, match="fields is "):
        sparsurf.describe_sites(small / "a.pdb", fields=wrong)
    with pytest.raises(InputError, match="names is "):
        sparsurf.fields(sparsurf.surface(small / "a.pdb"), wrong)


def test_one_name_or_many_in_any_sequence(small):
    dots = sparsurf.surface(small / "a.pdb")
    found = [sparsurf.fields(dots, names) for names in ("charge", ["charge"], np.array(["charge"]))]
    assert [list(each) for each in found] == [["charge"]] * 3


def test_places_with_hardly_a_dot_around_are_left_out_and_reported(small, caplog):
    dots = sparsurf.surface(small / "a.pdb")
    at = np.array([dots.points[7], dots.points[7] + 1000, dots.points[90]])
    sites = sparsurf.describe_sites(dots, percent=100, fields=(), at=at, name="mine")
    np.testing.assert_allclose(sites.points, at[[0, 2]], rtol=0, atol=1e-5)
    assert "mine: 1 of 3 points are left out: too few dots are around them" in caplog.text
    caplog.clear()
    sparsurf.describe_sites(dots, percent=100, fields=(), at=at[::2])
    assert "left out" not in caplog.text


def test_places_are_described_in_blocks_of_any_size(monkeypatch):
    whole = sparsurf.describe_sites(PEPTIDE, percent=25)
    monkeypatch.setattr(describing, "PLACES_AT_ONCE", PATCHES_PER_CALL)
    in_blocks = sparsurf.describe_sites(PEPTIDE, percent=25)
    assert len(whole) > 2 * PATCHES_PER_CALL and np.array_equal(in_blocks.numbers, whole.numbers)


def test_p_is_a_logistic_tail_and_unknown_for_other_settings(small):
    constants = np.array([-2.0, -0.5, 2.0])
    p = chance(np.array([1.0, 0.8, 0.0, 0.2]), np.array([0.8, 1.0, 0.0, 0.05]), 10, constants)
    width = np.exp(-2.0) * 2  # a fourth of 40 places
    gap = [0.2 / (width * 0.64), -0.2 / width, -np.inf, 0.15 / (width * 0.01)]
    np.testing.assert_allclose(p, 1 / (1 + np.exp(gap)))
    known = sparsurf.find(small / "a.sites", small / "a.sites", residues="209-212")
    assert known["p"][0] < 0.01
    other = sparsurf.find(small / "percent.sites", small / "percent.sites", residues="209-212")
    assert np.isnan(other["p"][0]) and other["score"][0] == known["score"][0]


def test_a_site_and_its_mirror_image_change_places_on_a_mirrored_target(sites):
    mirror = np.float32([1, 1, -1])
    mirrored = replace(sites, points=sites.points * mirror, normals=sites.normals * mirror)
    site = sites.take(np.argsort(np.linalg.norm(sites.points - sites.points[5], axis=1))[:20])
    hits, turned = (finding.find_site(site, [target]) for target in (sites, mirrored))
    assert hits.mirrored[0] == pytest.approx(turned.table["score"][0], rel=1e-6)
    assert turned.mirrored[0] == pytest.approx(hits.table["score"][0], rel=1e-6)
    assert hits.table["score"][0] > 2 * hits.mirrored[0]


def test_unknown_dots_have_the_mean_of_the_known_ones():
    assert _fill_unknown(np.array([0.0, np.nan, 1.0, 5.0])).tolist() == [0.0, 2.0, 1.0, 5.0]


def test_a_site_of_many_places_is_searched_by_forty_that_are_far_apart(sites, monkeypatch):
    """By hand on a line: the first point, its other end, the middle; then 40 of the places of a peptide."""
    line = np.outer(np.arange(5.0), [1, 0, 0])
    assert finding._farthest_points(line, 3).tolist() == [0, 4, 2]
    assert len(sites) > 45
    backwards = sites.take(np.arange(len(sites))[::-1])  # sites come in the order of farthest points
    monkeypatch.setattr(finding, "CALIBRATED", {})  # else p of such places is unknown
    hits = finding.find_site(backwards, [sites])
    plain = finding._farthest_points(backwards.points, 40)
    assert np.array_equal(hits.places.points, backwards.points[plain]) and len(set(plain)) == 40
    assert hits.table["places"].tolist() == [40]
    scores = hits.table["score"].to_numpy()
    p, other = (finding.chance(scores, hits.mirrored, n, finding.null()) for n in (len(sites), 40))
    assert np.log(hits.table["p"][0]) == pytest.approx(np.log(p[0]), rel=1e-6)  # p goes by all places
    assert np.log(p[0]) < 1.5 * np.log(other[0])


def test_p_of_a_very_high_score_is_small_but_not_0():
    p = chance(np.array([2.0, 999.0]), np.array([1.0, 1.0]), 40, finding.null())
    assert 0 < p[1] < 1e-9 < p[0] < 1e-3


def test_the_highest_score_comes_first_whatever_the_order_of_the_targets(sites, sites_of_turned):
    rng = np.random.default_rng(3)
    other = replace(sites_of_turned, name="other", numbers=rng.permutation(sites_of_turned.numbers))
    for targets in ([other, sites_of_turned], [sites_of_turned, other]):
        table = sparsurf.find(sites, targets, residues="212-216")
        assert table["target"].tolist() == [sites_of_turned.name, "other"] and table["rank"].tolist() == [
            1,
            2,
        ]
        assert table["score"].is_monotonic_decreasing and table["score"].diff()[1] < -0.01
        (best,) = sparsurf.find(sites, targets, residues="212-216", n=1)["target"]
        assert best == sites_of_turned.name


def test_hits_at_one_place_of_two_targets_are_two_hits(sites, sites_of_turned):
    twin = replace(sites_of_turned, name="twin")
    table = sparsurf.find(sites, [sites_of_turned, twin], at=[0, 40], n=2)
    for _, hits in table.groupby("query"):
        assert {*hits["target"]} == {sites_of_turned.name, "twin"}
        assert hits["score"].nunique() == 1 and hits[["x", "y", "z"]].drop_duplicates().shape[0] == 1


def test_components_of_one_number_by_hand():
    """Of a variance of 4, 1 lies within places that correspond: (4 - 1) / 1 of it tells places apart, and 2 is the scale."""
    learned = {
        "channels": ["shape"],
        "mean": np.array([[5.0]]),
        "within": np.array([[1.0]]),
        "total": np.array([[4.0]]),
    }
    mean, matrix = discriminant(("shape",), learned)
    assert mean == [5.0] and np.abs(matrix) == pytest.approx(np.sqrt(3) / 2)


def test_numbers_that_vary_together_are_shrunk_towards_their_own_variances():
    within = np.array([[1.0, 0.5], [0.5, 1.0]])
    learned = {"channels": ["shape"], "mean": np.zeros((1, 2)), "within": within, "total": 4 * np.eye(2)}
    _, matrix = discriminant(("shape",), learned)
    apart = 0.5 / (1 + metric.SHRINKAGE) / 4  # what they share, in units of the scales
    ratios = 1 / np.array([0.25 - apart, 0.25 + apart])
    assert np.linalg.norm(matrix, axis=0) == pytest.approx(np.sqrt(ratios - 1) / 2)
