"""Scripts of sites on a small peptide: sought on its copies, compared with another form of it."""

from dataclasses import replace

import make_surface
import numpy as np
import pandas as pd
import pytest
from noted import noted
from scipy.spatial.transform import Rotation

import compare_forms
import describe_places
import draw_changes
import draw_site
import find_site
from peptides import peptide, write
from small_study import SMALL
from sparsurf import InputError
from sparsurf.molecules.read_molecule import read_study_structure, residue_labels
from sparsurf.pairs.changes import CHANNELS
from sparsurf.report.figures import layout
from sparsurf.sites.describing import FIELDS, load_sites
from sparsurf.sites.finding import COLUMNS
from sparsurf.streams import stream
from sparsurf.surfaces.formats.npz import read_npz, write_npz
from sparsurf.workflow.config import check

SEQUENCE = ("ALA", "LEU", "LYS", "GLY", "SER", "VAL")
SETTINGS = check(SMALL)
SITE = {"query": "p", "residues": "2-4"}
COPIES = 11  # one more than the site is laid on
FORMS = ["p/f0", "q/f0"]


def moved(k):
    """How the k-th copy is turned and moved."""
    return Rotation.from_rotvec([0.1 * k, 0.5, 0.2 * k]).as_matrix(), np.array([10.0 * k, 3.0, -k])


def made(folder, name, text):
    """Files of the surface of a structure, in the folder of its name."""
    (folder / name).mkdir(parents=True)
    (folder / name).with_name("structures").mkdir()
    write((folder / name).parent / "structures" / "f0.pdb", text + "END\n")
    ends = {"surface": "npz", "structure": "pdb", "dms": "dms", "components": "csv"}
    files = {key: folder / name / f"{key}.{end}" for key, end in ends.items()}
    make_surface.main({"structures": (folder / name).with_name("structures")}, files, SETTINGS, name)
    return files


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Folder of a run: a peptide, its copies t00, t01, ..., another form of it, and the site sought on the copies."""
    run = tmp_path_factory.mktemp("sites") / "run"
    own = made(run, "p/f0", peptide(SEQUENCE))
    made(run, "q/f0", peptide(("ALA", "LEU", "LYS", "ALA", "SER", "VAL", "GLY"), "B", origin=(0, 50, 0)))
    describe_places.main(own, {"sites": run / "p/f0/places.sites"}, "p/f0", 1)
    surface, query = read_npz(own["surface"]), load_sites(run / "p/f0/places.sites")
    for k in range(COPIES):
        name, (turn, shift) = f"t{k:02d}/f0", moved(k)
        (run / name).mkdir(parents=True)
        dots = replace(surface, points=surface.points @ turn + shift, normals=surface.normals @ turn)
        write_npz(run / name / "surface.npz", dots)
        places = {"points": query.points @ turn + shift, "normals": query.normals @ turn}
        replace(query, name=name, **places).save(run / name / "places.sites")
    (run / "sites/s").mkdir(parents=True)
    targets = [run / f"t{k:02d}/f0/places.sites" for k in range(COPIES)]
    find_site.main(sought(run, targets), found(run), SITE, "s")
    return run


def sought(run, targets=()):
    """Inputs of a search."""
    own = run / "p/f0"
    return {"query": own / "places.sites", "structure": own / "structure.pdb", "targets": targets}


def found(run):
    """Outputs of the search."""
    names = {"hits": "hits.csv", "matches": "matches.csv", "poses": "poses.csv", "page": "site.html"}
    return {key: run / "sites/s" / name for key, name in names.items()} | {"superposed": run / "sites/s/laid"}


def test_places_have_residues_where_there_is_a_structure(run, tmp_path):
    sites, surface = load_sites(run / "p/f0/places.sites"), read_npz(run / "p/f0/surface.npz")
    assert sites.name == "p/f0" and {*sites.labels["residue_name"]} == {*SEQUENCE}
    write_npz(tmp_path / "c1.npz", replace(surface, fields=dict.fromkeys(FIELDS, surface.points[:, 0])))
    describe_places.main({"surface": tmp_path / "c1.npz"}, {"sites": tmp_path / "c1.sites"}, "q/c1", 1)
    bare = load_sites(tmp_path / "c1.sites")
    assert (bare.name, len(bare), {*bare.labels["residue"]}) == ("q/c1", len(sites), {""})


def test_a_site_is_found_on_every_copy_and_laid_on_ten(run):
    files = found(run)
    hits, matches, poses = (pd.read_csv(files[key], dtype=str) for key in ("hits", "matches", "poses"))
    assert hits.columns.to_list() == [*COLUMNS, "p", "places"]
    assert matches.columns[0] == "rank" and (matches["residue"] == matches["residue_there"]).all()
    assert (
        hits["rank"].to_list() == [str(k + 1) for k in range(COPIES)] and hits["target"].nunique() == COPIES
    )
    assert (matches["rank"].value_counts() == int(hits["places"][0])).all()
    assert poses[["rank", "target"]].equals(hits[["rank", "target"]])
    assert poses.columns[2:4].to_list() == ["turn_1_x", "turn_1_y"]
    numbers = poses.drop(columns=["rank", "target"])
    atoms = read_study_structure(run / "p/f0/structure.pdb").xyz[0]
    for place, pose in zip(poses["target"], numbers.to_numpy(float), strict=True):
        turn, shift = moved(int(place[1:3]))
        assert np.allclose(atoms @ pose[:9].reshape(3, 3) + pose[9:], atoms @ turn + shift, atol=0.01)
    laid = sorted(files["superposed"].iterdir())
    assert [path.name for path in laid] == [
        f"{k:02d}_{place.replace('/', '_')}.pdb" for k, place in enumerate(hits["target"][:10], 1)
    ]
    for path in laid:
        turn, shift = moved(int(path.name[4:6]))
        assert np.allclose(read_study_structure(path).xyz[0], atoms @ turn + shift, atol=0.01)
    for table, digits in ((numbers, 6), (matches[["x", "y_there"]], 3)):
        assert table.stack().str.fullmatch(rf"-?\d+\.\d{{{digits}}}").all()
    assert "p/f0" in files["page"].read_text(encoding="utf-8")


def test_nothing_is_laid_on_a_target_on_which_nothing_agrees(run, tmp_path):
    places = load_sites(run / "t00/f0/places.sites").take([0])
    far = replace(places, name="u/f0", points=places.points + 500, numbers=places.numbers + 50)
    far.save(tmp_path / "far.sites")
    files = {key: tmp_path / path.name for key, path in found(run).items()}
    find_site.main(sought(run, [run / "t00/f0/places.sites", tmp_path / "far.sites"]), files, SITE, "s")
    hits = pd.read_csv(files["hits"])
    assert hits["target"].to_list() == ["t00/f0", "u/f0"] and hits["places"].iloc[1] == 0
    assert [path.name for path in files["superposed"].iterdir()] == ["01_t00_f0.pdb"]


def test_a_site_without_query_or_other_targets_is_a_sentence(run):
    for targets in ([], [run / "p/f0/places.sites"]):
        with pytest.raises(InputError, match=r"^sites\.s: p/f0 is all that would be searched"):
            find_site.main(sought(run, targets), {}, SITE, "s")
    with pytest.raises(InputError, match=r"^sites\.s names a conformation that this study has not"):
        find_site.main({}, {}, SITE, "s")


def test_the_three_clearest_hits_are_seen_as_the_site_and_take_its_colours(run, tmp_path, monkeypatch):
    hits = pd.read_csv(found(run)["hits"])
    clearest, p = [4, 0, 2], [1e-7, 1e-6, 1e-5]  # rows of the table, which is in the order of the scores
    hits["p"] = 0.5
    hits.loc[clearest, "p"] = p
    hits.to_csv(tmp_path / "hits.csv", index=False)
    best = hits["target"].iloc[clearest].to_list()
    inputs = sought(run) | {"hits": tmp_path / "hits.csv", "poses": found(run)["poses"]}
    inputs["surfaces"] = [run / place / "surface.npz" for place in ("p/f0", *best)]
    inputs["structures"] = [inputs["structure"]]
    outputs = {f"view_{side}": tmp_path / f"view_{side}.html" for side in (1, 2)}
    figures = noted(monkeypatch, draw_site, "site_figure", lambda *_: layout.sheet(9, 9))
    pages = noted(monkeypatch, draw_site, "coloured_page", lambda title, *_: title)
    draw_site.main(inputs, outputs | {"png": str(tmp_path / "site.png")}, SETTINGS, SITE, "s")
    ((name, panels, residues),) = figures
    assert name == "s" and residues == ["A:LEU2", "A:LYS3", "A:GLY4"]
    titles = [f"hit {k + 1}: {hits['target'][k]}, p below 0.0001" for k in clearest]
    assert [title for title, *_ in panels] == ["the site on p/f0", *titles]
    surface, molecule = (read(run / "p/f0" / each) for read, each in
                         ((read_npz, "surface.npz"), (read_study_structure, "structure.pdb")))  # fmt: skip
    own = molecule.residue_index[surface.atom] - 1
    own[own > 2], steps = -1, np.linalg.norm(np.diff(surface.points, axis=0), axis=1)
    assert np.array_equal(panels[0][3], own)
    for _, points, normals, residue in panels:
        assert np.allclose(points, surface.points, atol=0.01) and np.allclose(
            normals, surface.normals, atol=0.01
        )
        assert np.array_equal(residue[own >= 0], own[own >= 0])
    for side, (page, place) in enumerate(zip(pages, ("p/f0", best[0]), strict=True), 1):
        title, called, shown, settings, (values,), atoms = page
        assert (title, called, settings) == (f"s, {place}", f"s/{side}", SETTINGS)
        assert values.name == "distance from the site"
        assert np.array_equal(values.values == 0, panels[side - 1][3] >= 0)
        assert np.linalg.norm(np.diff(shown.points, axis=0), axis=1) == pytest.approx(steps, abs=0.01)
        seen = shown.normals[own >= 0].mean(axis=0)
        assert np.allclose(
            seen / np.linalg.norm(seen), [0, 0, 1], atol=1e-3
        )  # the site is looked at from above
        assert atoms == (residue_labels(inputs["structure"]) if side == 1 else [])
        assert title == outputs[f"view_{side}"].read_text()
    assert np.allclose(pages[0][2].points, pages[1][2].points, atol=0.01)
    assert (tmp_path / "site.png").is_file()


def forms(run):
    """Inputs of two forms that are compared."""
    return {
        f"{what}_{side}": run / name / f"{what}.{end}"
        for side, name in enumerate(FORMS, 1)
        for what, end in (("surface", "npz"), ("structure", "pdb"))
    }


def changed(*_):
    """changes.csv as if two forms had been compared; the last residue that they share is buried."""
    table = pd.DataFrame({"chain": "A", "residue": list("123456"), "residue_name": SEQUENCE})
    table["residue_name_second"] = table["residue_name"].replace("GLY", "ALA")
    table = table.assign(
        **{f"{each}{end}": 1.0 for each in CHANNELS for end in ("", "_floor", "_difference")}
    )
    total = [1.0, 2.0, 3.0, 4.123456, 5.0, np.nan]
    return table.assign(total=total, total_floor=1.5, total_moved=2.5, above=1, above_moved=1)


def test_two_forms_are_compared_and_laid_on_each_other(run, tmp_path, monkeypatch):
    calls, inputs = noted(monkeypatch, compare_forms, "changes", changed), forms(run)
    outputs = {key: tmp_path / key for key in ("changes", "page", "pdb_1.pdb", "pdb_2.pdb")}
    outputs |= {f"pdb_{side}": outputs.pop(f"pdb_{side}.pdb") for side in (1, 2)}
    compare_forms.main(inputs, outputs, SETTINGS, {"changes": FORMS}, "bend", 3)
    ((*both, rng, threads),) = calls
    assert threads == 3 and rng.random() == stream(SETTINGS["seed"], "changes", *FORMS).random()
    given = [read_study_structure(inputs[f"structure_{side}"]) for side in (1, 2)]
    for side, (form, own, name) in enumerate(zip(both, given, FORMS, strict=True), 1):
        assert form.name == name and np.array_equal(form.molecule.xyz, own.xyz)
        assert {*form.molecule.chain} == {"A"}  # of the second, too: each has one
        dots = read_npz(inputs[f"surface_{side}"]).points
        assert np.array_equal(form.surface.points, dots) and np.allclose(form.lay(own.xyz[0]).points, dots)
    assert outputs["changes"].read_text().splitlines()[4].startswith("A,4,GLY,ALA,")
    assert ",4.1235," in outputs["changes"].read_text()
    first, second = (read_study_structure(outputs[f"pdb_{side}"]) for side in (1, 2))
    assert np.allclose(first.xyz, given[0].xyz) and np.allclose(
        second.xyz, given[1].xyz - [0, 50, 0], atol=2e-3
    )
    for form, rest in ((first, [-1.0]), (second, [-1.0, -1.0])):
        assert form.b_factor[::5].tolist() == pytest.approx([1, 2, 3, 4.12, 5, *rest])
    page = outputs["page"].read_text(encoding="utf-8")
    assert "Changes bend" in page and "From p/f0 to q/f0" in page


def test_forms_that_are_one_or_not_there_are_a_sentence(run):
    one = forms(run) | {"structure_2": forms(run)["structure_1"]}
    with pytest.raises(InputError, match=r"^sites\.bend: both names mean one conformation"):
        compare_forms.main(one, {}, SETTINGS, {"changes": FORMS}, "bend", 1)
    with pytest.raises(InputError, match=r"^sites\.bend names a conformation that this study has not"):
        compare_forms.main({}, {}, SETTINGS, {"changes": FORMS}, "bend", 1)


def test_forms_are_shown_in_the_colours_of_their_change(run, tmp_path, monkeypatch):
    changed().to_csv(tmp_path / "changes.csv", index=False)
    outputs = {f"view_{side}": tmp_path / f"view_{side}.html" for side in (1, 2)}
    pages = noted(monkeypatch, draw_changes, "coloured_page", lambda title, *_: title)
    figures = noted(monkeypatch, draw_changes, "changes_figure", lambda *_: layout.sheet(9, 9))
    inputs, png = forms(run) | {"changes": tmp_path / "changes.csv"}, str(tmp_path / "changes.png")
    draw_changes.main(inputs, outputs | {"png": png}, SETTINGS, {"changes": FORMS}, "bend")
    for side, (title, called, surface, _, (values,), atoms) in enumerate(pages, 1):
        assert title == f"bend, {FORMS[side - 1]}" == outputs[f"view_{side}"].read_text()
        assert (
            called == f"bend/{side}" and values.name.startswith("change from") and values.symbol == "change"
        )
        assert atoms == residue_labels(inputs[f"structure_{side}"])
        residue = read_study_structure(inputs[f"structure_{side}"]).residue_index[surface.atom]
        total = np.append(changed()["total"], np.nan)
        assert np.array_equal(values.values, total[residue], equal_nan=True)
    ((name, both, table),) = figures
    assert name == "bend" and [form[0] for form in both] == FORMS and len(table) == 6
    assert (tmp_path / "changes.png").is_file()
