"""Places of sites of a run in batches: a byte for a component, the nearest as in a plain search, hits as in `find`."""

import shutil

import numpy as np
import pandas as pd
import pytest

import small_study
import sparsurf
from peptides import peptide, write
from sparsurf import InputError
from sparsurf.batches import search, tables
from sparsurf.batches.analysis import Structure, analyse_batch
from sparsurf.batches.places import pack_places, settings_of_places
from sparsurf.cli import command
from sparsurf.sites import describing, finding, metric
from sparsurf.sites.describing import places_of_residues
from sparsurf.workflow.config import check_config

pytest.importorskip("pyarrow", reason="pyarrow is installed by the extra `many`")
CHAINS = {
    "a": ("ALA", "SER", "ALA", "VAL", "GLY", "ALA"),
    "b": ("SER", "VAL", "SER", "GLY"),
    "c": ("VAL", "VAL", "ALA", "SER", "VAL"),
    "d": ("GLY", "ALA", "SER"),
}
CONFIG = {"run": "many", "sampling": False, "batch": 2, "places": True, "proteins": {"folder": "structures"}}


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Folder of a finished study of four peptides and an empty file."""
    folder = tmp_path_factory.mktemp("places") / "study"
    (folder / "structures").mkdir(parents=True)
    for name, residues in CHAINS.items():
        write(folder / f"structures/{name}.pdb", peptide(residues) + "END\n")
    write(folder / "structures/empty.pdb", "END\n")
    process = small_study.snakemake(folder, CONFIG)
    assert process.returncode == 0, small_study.output(process)
    return folder


@pytest.fixture
def copy(study, tmp_path):
    """Return a copy of the study, to be changed."""
    return shutil.copytree(study, tmp_path / "study")


def described(study, names="abcd"):
    """Sites of the structures of the study."""
    return [sparsurf.describe_sites(study / f"structures/{name}.pdb") for name in names]


def site_of(study, residues="2-4"):
    """Places of a site on the first peptide."""
    sites = described(study, "a")[0]
    return sites.take(places_of_residues(sites, residues))


def components_of(study, query):
    """Components of a query, and of all stored places as they were before rounding, in the order of the groups."""
    by_name = {sites.name: sites for sites in described(study)}
    groups, _ = search.list_groups(study / "results/many")
    stored = []
    for group in groups:
        sites = by_name[group.protein]
        molecule = sparsurf.read_molecule(study / f"structures/{group.protein}.pdb")
        order = np.argsort(
            [molecule.residues["residue"].tolist().index(r) for r in sites.labels["residue"]], kind="stable"
        )
        stored.append(metric.to_metric_space(sites.numbers[order], sites.fields))
    return metric.to_metric_space(query.numbers, query.fields), groups, stored


def test_components_are_rounded_to_an_eighth_and_cut_at_127():
    rng = np.random.default_rng(0)
    components = rng.normal(0, 3, (200, 64))
    error = metric.quantise(components) / metric.STEPS_PER_UNIT - components
    assert np.abs(error).max() <= 1 / 16 and np.abs(error).mean() == pytest.approx(1 / 32, rel=0.05)
    assert metric.quantise(np.array([15.9, -200.0, 0.0625, 0.19])).tolist() == [127, -127, 0, 2]


def test_the_metric_does_not_depend_on_the_signs_of_eigenvectors(monkeypatch):
    channels, learned = ("shape", "charge"), metric.weights()
    expected = metric.discriminant(channels, learned)[1]
    eigh = metric.eigh

    def other_library(*matrices):
        ratio, rotation = eigh(*matrices)
        return ratio, rotation * np.where(np.arange(len(ratio)) % 2, 1, -1)

    monkeypatch.setattr(metric, "eigh", other_library)
    assert np.array_equal(metric.discriminant(channels, learned)[1], expected)


def test_a_row_is_a_place_by_residue(study):
    table = tables.read_parquet(study / "results/many", "places")
    assert list(table) == list(tables.columns_of("places"))
    for sites in described(study):
        rows = table.query("protein == @sites.name")
        assert rows["residue"].astype(int).is_monotonic_increasing and len(rows) == len(sites)
        order = np.argsort(sites.labels["residue"].astype(int), kind="stable").to_numpy()
        points, normals = tables.unpack_dots(rows)
        assert np.abs(points - sites.points[order]).max() <= 1 / 64
        assert (normals * sites.normals[order]).sum(axis=1).min() > np.cos(np.radians(2**0.5))
        expected = metric.quantise(metric.to_metric_space(sites.numbers[order], sites.fields))
        stored = np.frombuffer(b"".join(rows["numbers"]), np.int8).reshape(-1, 64)
        assert np.array_equal(stored, expected)


def test_nearest_places_are_those_of_a_plain_search_of_rounded_components(study):
    q, groups, stored = components_of(study, site_of(study))
    assert [group.n_places for group in groups] == [len(part) for part in stored]
    assert [group.begin for group in groups] == [0, *np.cumsum([len(part) for part in stored])[:-1]]
    nearest, middle, scale = search.nearest_of_each(q, groups)
    rounded = [metric.quantise(part) / metric.STEPS_PER_UNIT for part in stored]
    for k, part in enumerate(rounded):
        distance = np.linalg.norm(q[:, None] - part[None], axis=2).min(axis=1)
        assert np.allclose(np.exp(nearest[:, k]), distance, rtol=0, atol=1e-3)
    log_distance = np.log(np.linalg.norm(q[:, None] - np.concatenate(rounded)[None], axis=2))
    assert np.allclose([middle, scale], finding.background(log_distance), rtol=0, atol=1e-4)


def test_every_nth_place_of_the_run_is_a_sample(study, monkeypatch):
    monkeypatch.setattr(finding, "N_BACKGROUND", 200)
    q, groups, stored = components_of(study, site_of(study))
    stride = sum(map(len, stored)) // 200
    assert stride > 2
    rounded = np.concatenate([metric.quantise(part) for part in stored])[::stride] / metric.STEPS_PER_UNIT
    expected = finding.background(np.log(np.linalg.norm(q[:, None] - rounded[None], axis=2)))
    assert np.allclose(search.nearest_of_each(q, groups)[1:], expected, rtol=0, atol=1e-4)


def test_structures_are_described_as_they_were(study):
    again = search.similar_structures(study / "results/many", site_of(study), 10)
    assert sorted(sites.name for sites in again) == [*"abcd"] and again[0].name == "a"
    for_one_hit = search.similar_structures(study / "results/many", site_of(study), 1)
    assert len(for_one_hit) == 4  # rounded numbers rank roughly: more structures than hits are searched
    expected = {sites.name: sites for sites in described(study)}
    for sites in again:
        assert np.array_equal(sites.numbers, expected[sites.name].numbers)
        assert np.array_equal(sites.points, expected[sites.name].points)
        pd.testing.assert_frame_equal(sites.labels, expected[sites.name].labels)


def test_hits_are_those_of_find_on_the_structures(study, tmp_path, monkeypatch):
    monkeypatch.setattr(search, "N_EXTRA", 1)
    query = study / "structures/a.pdb"
    table = sparsurf.find(query, study / "results/many", residues="2-4", n=2)
    names = [sites.name for sites in search.similar_structures(study / "results/many", site_of(study), 2)]
    assert len(names) == 3
    pd.testing.assert_frame_equal(table, sparsurf.find(query, described(study, names), residues="2-4", n=2))
    assert table["target"][0] == "a" and len(table) == 2
    path = tmp_path / "hits.csv"
    call = [
        "find",
        str(query),
        str(study / "results/many"),
        "--residues",
        "2-4",
        "--hits",
        "2",
        "-o",
        str(path),
    ]
    assert command.main([*call, "--superpose", str(tmp_path / "laid")]) == 0
    written = pd.read_csv(path)
    assert written["target"].tolist() == table["target"].tolist()
    assert np.allclose(written["score"], table["score"], atol=1e-3) and np.allclose(
        written["p"], table["p"], atol=1e-3
    )
    assert sorted(file.name for file in (tmp_path / "laid").iterdir())[0] == "01_a.pdb"


def test_a_run_is_searched_beside_other_targets(study):
    query = study / "structures/a.pdb"
    table = sparsurf.find(query, [study / "results/many", query], residues="2-4")
    assert sorted(table["target"]) == ["a", "a (2)", "b", "c", "d"]


def test_only_structures_with_similar_places_are_superposed(study, monkeypatch):
    monkeypatch.setattr(search, "N_SUPERPOSED", 2)
    run, site = study / "results/many", site_of(study)
    q, groups, _ = components_of(study, site)
    nearest, middle, scale = search.nearest_of_each(q, groups)
    similarity = np.maximum((middle[:, None] - nearest) / scale[:, None] - finding.MIN_SCORE, 0).sum(axis=0)
    best = [groups[k].protein for k in np.argsort(-similarity)[:2]]
    assert sorted(sites.name for sites in search.similar_structures(run, site, 10)) == sorted(best)


def test_all_places_of_a_site_decide_what_is_superposed(study, monkeypatch):
    """The first structure has one place that is almost the same; on the second, all places are alike."""
    site = site_of(study)
    n = len(finding.superposed_places(site))
    nearest = np.array([[-3.0, 4.0], *[[10.0, 4.0]] * (n - 1)])  # log distances, below a background of 10
    _, groups, _ = components_of(study, site)
    monkeypatch.setattr(search, "N_SUPERPOSED", 1)
    monkeypatch.setattr(search, "nearest_of_each", lambda *_: (nearest, np.full(n, 10.0), np.ones(n)))
    monkeypatch.setattr(search, "pose_scores", lambda query, q, superposed, *_: np.ones(len(superposed)))
    assert search.rank_structures(groups[:2], site, 1) == [groups[1].protein]


def test_the_bytes_do_not_depend_on_cores(study, tmp_path):
    folder = tmp_path / "again"
    shutil.copytree(study / "structures", folder / "structures")
    process = small_study.snakemake(folder, CONFIG, "--cores", "1")
    assert process.returncode == 0, small_study.output(process)
    paths = sorted((study / "results/many").rglob("*.parquet"))
    assert sum(path.parent.name == "places" for path in paths) == 2
    for path in paths:
        assert (folder / path.relative_to(study)).read_bytes() == path.read_bytes(), path


def test_places_of_an_earlier_study_are_removed(copy):
    process = small_study.snakemake(copy, CONFIG | {"places": False})
    assert process.returncode == 0, small_study.output(process)
    assert not list((copy / "results/many/places").glob("*.parquet"))
    assert sorted(tables.read_parquet(copy / "results/many", "surfaces")["protein"]) == [*"abcd"]
    with pytest.raises(
        InputError, match=r"many has no places: set `places: true` in the study and run again\.$"
    ):
        sparsurf.find(copy / "structures/a.pdb", copy / "results/many", residues="2-4")


def second_file(folder):
    """Return the second file of places."""
    return sorted((folder / "results/many/places").glob("*.parquet"))[1]


def damage(folder):
    """Cut the second file of places in half."""
    path = second_file(folder)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def damage_numbers(folder):
    """Overwrite some bytes of the numbers of a file of places; its footer stays as it is."""
    path = second_file(folder)
    content = bytearray(path.read_bytes())
    content[200:-3000] = bytes(len(content) - 3200)
    path.write_bytes(content)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (damage, ".parquet is damaged ("),
        (damage_numbers, ".parquet is damaged ("),
        (lambda folder: shutil.copy(folder / "results/many/dots/0001.parquet", folder / "results/many/places"), "is damaged ("),
        (lambda folder: write(folder / "structures/b.pdb", peptide(CHAINS["d"]) + "END\n"), "structures/b.pdb has changed"),
        (lambda folder: (folder / "structures/b.pdb").unlink(), "structures/b.pdb does not exist any more: put"),
    ],
)  # fmt: skip
def test_what_cannot_be_searched_is_said_in_one_sentence(copy, capsys, change, words):
    change(copy)
    call = ["find", str(copy / "structures/a.pdb"), str(copy / "results/many"), "--residues", "2-4"]
    assert command.main([*call, "-o", str(copy / "hits.csv")]) == 1
    *warnings, error = capsys.readouterr().err.splitlines()
    assert words in error and all(line.startswith("sparsurf: warning: ") for line in warnings)
    assert not (copy / "hits.csv").exists()


def test_other_settings_and_single_places_are_refused(study, monkeypatch):
    run, query = study / "results/many", study / "structures/a.pdb"
    with pytest.raises(InputError, match="is searched for whole sites: give `residues` instead of `at`"):
        sparsurf.find(query, run, at=[1, 2])
    with pytest.raises(InputError, match=r"many was described with percent 10\.0, and the query with 20"):
        sparsurf.find(query, run, residues="2-4", percent=20)
    with pytest.raises(InputError, match="arrangement needs 3"):
        search.similar_structures(run, site_of(study).take(np.arange(2)), 1)
    with pytest.raises(InputError, match="'99' is not in a"):
        sparsurf.find(query, run, residues="99")
    monkeypatch.setattr(search, "fingerprint", lambda: 0)
    with pytest.raises(InputError, match="places of other settings or another version: run the study again"):
        sparsurf.find(query, run, residues="2-4")


def test_a_structure_without_places_is_a_failure(tmp_path, monkeypatch):
    monkeypatch.setattr(describing, "MIN_DOTS_IN_PATCH", 10**6)
    write(tmp_path / "a.pdb", peptide() + "END\n")
    config = check_config(
        {
            "sampling": False,
            "batch": 1,
            "places": True,
            "proteins": {"a": {"structure": str(tmp_path / "a.pdb")}},
        }
    )
    out = analyse_batch([Structure("a", str(tmp_path / "a.pdb"))], config)
    assert out["failures"]["reason"].str.contains("no patch has 1000000 dots").tolist() == [True]
    assert all(out[name].empty for name in ("surfaces", "residues", "dots", "places"))


def test_a_run_without_any_place_says_so(tmp_path):
    write(tmp_path / "x.pdb", "END\n")
    config = check_config(
        {
            "sampling": False,
            "batch": 1,
            "places": True,
            "proteins": {"x": {"structure": str(tmp_path / "x.pdb")}},
        }
    )
    out = analyse_batch([Structure("x", str(tmp_path / "x.pdb"))], config)
    (tmp_path / "places").mkdir()
    tables.write_parquet(
        tmp_path / "places/0001.parquet", "places", out["places"], [], settings_of_places(config)
    )
    assert tables.read_parquet(tmp_path, "places").empty
    with pytest.raises(InputError, match="has no structure with places; failures/ has the reasons"):
        search.list_groups(tmp_path)


def test_places_need_batches(tmp_path):
    write(tmp_path / "a.pdb", peptide() + "END\n")
    config = {"sampling": False, "places": True, "proteins": {"a": {"structure": str(tmp_path / "a.pdb")}}}
    with pytest.raises(InputError, match="places is for a study with `batch`"):
        check_config(config)


def test_places_take_less_than_80_bytes(tmp_path):
    molecule = sparsurf.read_molecule("data/tdp43/topology.pdb")
    sites = sparsurf.describe_sites(molecule, name="tdp43")
    rows = pack_places(sites, molecule).assign(protein="tdp43")
    path = tmp_path / "places.parquet"
    tables.write_parquet(path, "places", rows, [], {})
    assert path.stat().st_size < 70 * len(sites)
