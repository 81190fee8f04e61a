"""Scripts of sites on a small peptide and its copies: eleven targets, targets where nothing agrees, mistakes."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import compare_forms
import compute_surface
import describe_places
import draw_site
import find_site
from conftest import ROOT
from peptides import peptide, write
from small_study import EMBEDDED
from sparsurf import InputError
from sparsurf.molecules.read_molecule import read_study_structure, residue_labels
from sparsurf.report.figures import layout
from sparsurf.sites.describing import FIELDS, load_sites
from sparsurf.sites.finding import COLUMNS
from sparsurf.surfaces.formats.npz import read_npz, write_npz
from sparsurf.workflow.config import check_config

SEQUENCE = ("ALA", "LEU", "LYS", "GLY", "SER", "VAL")
CONFIG = check_config({"proteins": {"tdp43": EMBEDDED}}, home=ROOT)
SITE = {"query": "p", "residues": "2-4"}
N_COPIES = 11  # one more than the site is superposed onto


def pose_of(k):
    """Rotation matrix and shift of the k-th copy."""
    return Rotation.from_rotvec([0.1 * k, 0.5, 0.2 * k]).as_matrix(), np.array([10.0 * k, 3.0, -k])


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Folder of a run: a peptide, its copies t00, t01, ..., and the search for a site on the copies."""
    run = tmp_path_factory.mktemp("sites") / "run"
    (run / "p/f0").mkdir(parents=True)
    (run / "p/structures").mkdir()
    write(run / "p/structures/f0.pdb", peptide(SEQUENCE) + "END\n")
    files = [
        str(run / "p/f0" / name) for name in ("surface.npz", "structure.pdb", "surface.dms", "components.csv")
    ]
    compute_surface.main(str(run / "p/structures"), *files, CONFIG["surface"], 0.5, "p/f0")
    describe_places.main(files[0], files[1], str(run / "p/f0/places.sites"), "p/f0")
    surface, query = read_npz(files[0]), load_sites(run / "p/f0/places.sites")
    for k in range(N_COPIES):
        name, (turn, shift) = f"t{k:02d}/f0", pose_of(k)
        (run / name).mkdir(parents=True)
        moved = replace(surface, points=surface.points @ turn + shift, normals=surface.normals @ turn)
        write_npz(run / name / "surface.npz", moved)
        places = {"points": query.points @ turn + shift, "normals": query.normals @ turn}
        replace(query, name=name, **places).save(run / name / "places.sites")
    (run / "sites/s").mkdir(parents=True)
    search(run, run / "sites/s", [run / f"t{k:02d}/f0/places.sites" for k in range(N_COPIES)])
    return run


def search(run, folder, targets):
    """Search for the site; the outputs go to a folder."""
    names = ("hits.csv", "matches.csv", "poses.csv", "superposed", "site.html")
    query = (str(run / "p/f0/places.sites"), str(run / "p/f0/structure.pdb"))
    find_site.main(*query, targets, *(str(folder / name) for name in names), SITE, "s")


def test_places_have_residues_where_there_is_a_structure(run, tmp_path):
    sites, surface = load_sites(run / "p/f0/places.sites"), read_npz(run / "p/f0/surface.npz")
    assert sites.name == "p/f0" and {*sites.labels["residue_name"]} == {*SEQUENCE}
    ready = replace(surface, fields=dict.fromkeys(FIELDS, surface.points[:, 0]))
    write_npz(tmp_path / "c1.npz", ready)
    describe_places.main(str(tmp_path / "c1.npz"), None, str(tmp_path / "c1.sites"), "q/c1")
    bare = load_sites(tmp_path / "c1.sites")
    assert (bare.name, len(bare), {*bare.labels["residue"]}) == ("q/c1", len(sites), {""})


def test_a_site_is_found_on_every_copy_and_superposed_onto_ten(run):
    folder = run / "sites/s"
    hits, matches, poses = (
        pd.read_csv(folder / f"{name}.csv", dtype=str) for name in ("hits", "matches", "poses")
    )
    assert hits.columns.to_list() == [*COLUMNS, "p", "places"]
    assert matches.columns[0] == "rank" and (matches["residue"] == matches["residue_there"]).all()
    assert hits["rank"].to_list() == [str(k + 1) for k in range(N_COPIES)]
    assert hits["target"].nunique() == N_COPIES and poses[["rank", "target"]].equals(hits[["rank", "target"]])
    assert (matches["rank"].value_counts() == int(hits["places"][0])).all()
    numbers = poses.drop(columns=["rank", "target"])
    atoms = read_study_structure(run / "p/f0/structure.pdb").xyz[0]
    for place, pose in zip(poses["target"], numbers.to_numpy(float), strict=True):
        turn, shift = pose_of(int(place[1:3]))
        assert np.allclose(atoms @ pose[:9].reshape(3, 3) + pose[9:], atoms @ turn + shift, atol=0.01)
    paths = sorted((folder / "superposed").iterdir())
    best = enumerate(hits["target"][:10], 1)
    assert [path.name for path in paths] == [f"{k:02d}_{place.replace('/', '_')}.pdb" for k, place in best]
    for path in paths:
        turn, shift = pose_of(int(path.name[4:6]))
        assert np.allclose(read_study_structure(path).xyz[0], atoms @ turn + shift, atol=0.01)
    for table, digits in ((numbers, 6), (matches[["x", "y_there"]], 3)):
        assert table.stack().str.fullmatch(rf"-?\d+\.\d{{{digits}}}").all()
    assert "p/f0" in (folder / "site.html").read_text(encoding="utf-8")


def test_nothing_is_superposed_onto_a_target_on_which_nothing_agrees(run, tmp_path):
    places = load_sites(run / "t00/f0/places.sites").take([0])
    far = replace(places, name="u/f0", points=places.points + 500, numbers=places.numbers + 50)
    far.save(tmp_path / "far.sites")
    search(run, tmp_path, [run / "t00/f0/places.sites", tmp_path / "far.sites"])
    hits = pd.read_csv(tmp_path / "hits.csv")
    assert hits["target"].to_list() == ["t00/f0", "u/f0"] and hits["places"].iloc[1] == 0
    assert [path.name for path in (tmp_path / "superposed").iterdir()] == ["01_t00_f0.pdb"]


def test_a_site_without_query_or_other_targets_is_a_sentence(run, tmp_path):
    for targets in ([], [run / "p/f0/places.sites"]):
        with pytest.raises(InputError, match=r"^sites\.s: p/f0 is all that would be searched"):
            search(run, tmp_path, targets)
    with pytest.raises(InputError, match=r"^sites\.s names a conformation that this study does not have"):
        find_site.main(None, None, [], "", "", "", "", "", SITE, "s")


def test_forms_that_are_one_or_not_there_are_a_sentence():
    rest = ("", "", "", "", ["p/f0", "q/f0"], CONFIG["surface"], 0.5, 1, "bend")
    with pytest.raises(InputError, match=r"^sites\.bend: both names mean one conformation"):
        compare_forms.main("a.npz", "a.npz", "a.pdb", "a.pdb", *rest)
    with pytest.raises(InputError, match=r"^sites\.bend names a conformation that this study does not have"):
        compare_forms.main(None, None, None, None, *rest)


def test_the_form_that_lacks_residues_is_named(monkeypatch, caplog):
    """The first form has residues 5 and 6, and the second lacks them."""
    for name, instead in (
        ("read_npz", lambda path: path),
        ("read_study_structure", lambda path: path),
        ("numbered_alike", lambda molecule, _: molecule),
        ("radii", lambda *_: None),
        ("surface_generator", lambda *_: (None, None)),
        ("unmatched_residues", lambda *_: ("A:5, A:6", "")),
    ):
        monkeypatch.setattr(compare_forms, name, instead)
    monkeypatch.setattr(compare_forms, "Form", lambda name, *_: name)
    monkeypatch.setattr(compare_forms, "changes_between", lambda *_: 1 / 0)
    rest = ("", "", "", "", ["p/f0", "q/f0"], CONFIG["surface"], 0.5, 1, "bend")
    with pytest.raises(ZeroDivisionError):
        compare_forms.main("a.npz", "b.npz", "a.pdb", "b.pdb", *rest)
    (told,) = [record.getMessage() for record in caplog.records]
    assert told.startswith("q/f0 lacks residues A:5, A:6 of p/f0, so changes next to them may come from that")


def spy(monkeypatch, name, instead):
    """Return a list that collects the calls of a function of draw_site, in whose place another does the work."""
    calls = []
    monkeypatch.setattr(draw_site, name, lambda *args: calls.append(args) or instead(*args))
    return calls


def test_the_three_clearest_hits_are_drawn_from_the_side_of_the_site(run, tmp_path, monkeypatch):
    hits = pd.read_csv(run / "sites/s/hits.csv")
    clearest = [4, 0, 2]  # rows of the table, which is in the order of the scores
    hits["p"] = 0.5
    hits.loc[clearest, "p"] = [1e-7, 1e-6, 0.3]  # the last is a hit by chance
    hits.to_csv(tmp_path / "hits.csv", index=False)
    best = hits["target"].iloc[clearest].to_list()
    figures = spy(monkeypatch, "site_figure", lambda *_: layout.constrained(90, 90))
    pages = spy(monkeypatch, "coloured_page", lambda title, *_: title)
    structure = str(run / "p/f0/structure.pdb")
    draw_site.main(
        query=str(run / "p/f0/places.sites"),
        structure=structure,
        surfaces=[str(run / place / "surface.npz") for place in ("p/f0", *best)],
        structures=[structure],
        hits=str(tmp_path / "hits.csv"),
        poses=str(run / "sites/s/poses.csv"),
        png=str(tmp_path / "site.png"),
        view_1=str(tmp_path / "view_1.html"),
        view_2=str(tmp_path / "view_2.html"),
        site=SITE,
        patches=CONFIG["patches"],
        seed=CONFIG["seed"],
        name="s",
    )
    ((name, panels, residues),) = figures
    assert name == f"s: found on 2 of {len(hits)} surfaces" and residues == ["A:LEU2", "A:LYS3", "A:GLY4"]
    titles = [f"found on {hits['target'][k]}, p below 0.0001" for k in clearest[:2]]
    titles.append(f"not found on {hits['target'][clearest[2]]}, p 0.3")
    assert [panel[0] for panel in panels] == ["the site on p/f0", *titles]
    surface, molecule = read_npz(run / "p/f0/surface.npz"), read_study_structure(structure)
    site = molecule.residue_index[surface.atom] - 1
    site[site > 2] = -1
    assert np.array_equal(panels[0][3], site)
    for _, points, normals, _ in panels:  # every copy is carried onto the query
        assert np.allclose(points, surface.points, atol=0.01)
        assert np.allclose(normals, surface.normals, atol=0.01)
    for *_, residue in panels[:3]:
        assert np.array_equal(residue[site >= 0], site[site >= 0])
    assert (panels[3][3] == -1).all()  # a miss is not painted as a hit
    for page, place, side in zip(pages, ("p/f0", best[0]), (1, 2), strict=True):
        title, label, shown = page[:3]
        assert (title, label) == (f"s, {place}", f"s/{side}")
        seen = shown.normals[site >= 0].mean(axis=0)
        assert np.allclose(seen / np.linalg.norm(seen), [0, 0, 1], atol=1e-3)  # the site is seen from above
        assert page[-1] == (residue_labels(structure) if side == 1 else [])
        assert (tmp_path / f"view_{side}.html").read_text() == title
    assert np.allclose(pages[0][2].points, pages[1][2].points, atol=0.01)
    assert (tmp_path / "site.png").is_file()
