"""No input and no file that nobody named is replaced, by any command or function; its own files are."""

import os
import shlex
import shutil

import pytest

import sparsurf
from peptides import peptide, write
from sparsurf.cli import command, msms
from sparsurf.errors import InputError

NOTES = "notes of the user\n"
STRUCTURES = ("p.pdb", "p.csv", "p.ply", "p.npz", "p.html", "p.png", "p.pml", "p.parquet", "run_frames.csv", "mm.face",
              "folder/a.pdb", "x_molecule.pdb")  # fmt: skip
SPHERES = (
    "same.vert",
    "same.face",
    "same.area",
    "s.xyzr",
)  # as sparsurf-msms reads them, whatever their name is
LINKS = {"link.csv": "p.csv", "in_folder.parquet": "folder/a.pdb", "linked.face": "p.pdb", "scene_molecule.pdb": "p.pdb",
         "page_of.html": "own.html"}  # fmt: skip


@pytest.fixture(scope="module")
def originals(tmp_path_factory):
    """A folder in which files of every format are structures, which are known by their content, and some are notes."""
    tmp_path = tmp_path_factory.mktemp("originals")
    (tmp_path / "folder").mkdir()
    for name in STRUCTURES:
        write(tmp_path / name, peptide() + "END\n")
    dots = sparsurf.surface(tmp_path / "p.pdb")
    rows = "".join(f"{x:.3f} {y:.3f} {z:.3f} 1.7\n" for x, y, z in dots.molecule.xyz[0])
    for name in SPHERES:
        write(tmp_path / name, rows)
    models = "".join(f"MODEL {k}\n{peptide()}ENDMDL\n" for k in (1, 2))
    write(tmp_path / "two.pdb", models)
    write(tmp_path / "t.csv", models)
    for name in ("few.csv", "at.csv"):
        sparsurf.minimal(dots, percent=20).table.to_csv(tmp_path / name, index=False)
    for name in ("q_frames.csv", "w_ranking.csv", "z_frames.csv.gz", "n.face", "n.face.gz", "notes.html", "notes_dots.bild",
                 "other.face", "other.area", "page_of.pdb", "few.html"):  # fmt: skip
        write(tmp_path / name, NOTES)
    write(tmp_path / "own.html", '<meta name="generator" content="sparsurf 1">')
    write(tmp_path / "page_of.pdb", peptide() + "END\n")
    write(tmp_path / "notes.pdb", peptide() + "END\n")
    return tmp_path


@pytest.fixture
def folder(originals, tmp_path, monkeypatch):
    """A copy of these files, with links to some of them."""
    place = shutil.copytree(originals, tmp_path / "own")
    monkeypatch.chdir(place)
    monkeypatch.setenv("DISPLAY", "")
    monkeypatch.setenv("WAYLAND_DISPLAY", "")
    for name, target in LINKS.items():
        os.symlink(target, name)
    os.link("p.csv", "hard.csv")
    return place


def contents(folder):
    """What each file holds, links followed."""
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize(
    "line",
    [
        "surface p.csv -o p.csv",
        "surface p.csv -o ./p.csv",
        "surface p.csv -o folder/../p.csv",
        "surface p.csv -o link.csv",
        "surface link.csv -o p.csv",
        "surface p.csv -o hard.csv",
        "surface mm.face --mesh -o mm.vert",
        "surface p.pdb --mesh -o n.vert",
        "surface p.pdb --mesh -o n.vert.gz",
        "surface p.pdb --mesh -o linked.vert",
        "roughness p.csv -o p.csv",
        "roughness p.html -o p.html",
        "residues p.csv -o p.csv",
        "residues p.png -o p.png",
        "descriptors few.csv -o few.csv",
        "points p.ply -n 20 -o p.ply",
        "points p.pdb p.parquet -n 20 -o p.parquet",
        "points folder -n 20 -o in_folder.parquet",
        "minimal p.csv -o hard.csv",
        "minimal p.pml -o p.pml",
        "recover few.csv -o few.csv",
        "recover few.csv --at at.csv -o at.csv",
        "recover few.csv --mesh -o n.vert",
        "recover mm.face --mesh -o mm.vert",
        "show p.html -o p.html",
        "show notes.pdb",
        "show page_of.pdb",
        "show few.csv --no-open",
        "frames run_frames.csv -o run.csv",
        "frames two.pdb -o q.csv",
        "frames two.pdb -o w.csv",
        "frames two.pdb -o z.csv.gz",
        "frames p.pdb --trajectory t.csv -o t.csv",
        "msms -if same.vert -of same",
        "msms -if same.face -of same",
        "msms -if same.area -af same",
        "msms -if s.xyzr -of other",
        "msms -if s.xyzr -af other",
        "msms -if s.xyzr -of linked",
    ],
)
def test_no_command_replaces_an_input_or_a_file_that_nobody_named(folder, capsys, line):
    before = contents(folder)
    name, *words = shlex.split(line)
    assert (msms.main(words) if name == "msms" else command.main([name, *words])) == 1
    assert contents(folder) == before
    told = capsys.readouterr().err
    assert "is an input file" in told or "exists and was not written by sparsurf" in told


def chimerax(path):
    """Write dots as a scene of ChimeraX."""
    sparsurf.surface("p.pdb").write(path)


@pytest.mark.parametrize(
    "call",
    [
        lambda: sparsurf.frames("run_frames.csv", path="run.csv"),
        lambda: sparsurf.frames(sparsurf.read_molecule("run_frames.csv"), path="run.csv"),
        lambda: sparsurf.frames("p.pdb", "t.csv", path="t.csv"),
        lambda: sparsurf.frames("two.pdb", path="q.csv"),
        lambda: sparsurf.write(sparsurf.surface("p.csv"), "link.csv"),
        lambda: sparsurf.write(sparsurf.read_surface("few.csv"), "p.csv", molecule="p.csv"),
        lambda: sparsurf.surface("p.ply").write("p.ply"),
        lambda: sparsurf.read_molecule("p.pdb", residues="1-2").write("p.pdb"),
        lambda: sparsurf.points("p.npz", 20).write("p.npz"),
        lambda: sparsurf.minimal("p.csv", percent=20).write("p.csv"),
        lambda: sparsurf.minimal("p.html", percent=20).write("p.html"),
        lambda: sparsurf.mesh("p.pdb").write("n.vert"),
        lambda: sparsurf.mesh("p.ply").write("p.ply"),
        lambda: sparsurf.write(sparsurf.mesh("few.csv"), "n.vert.gz"),
        lambda: chimerax("x.cxc"),
        lambda: chimerax("notes.cxc"),
        lambda: chimerax("scene.cxc"),
        lambda: sparsurf.show("p.html", "p.html", open_browser=False),
        lambda: sparsurf.surface("p.html").show(path="p.html"),
        lambda: sparsurf.show("p.pdb", open_browser=False).save("p.pdb"),
        lambda: next(sparsurf.points_of("folder", 20)).write("in_folder.parquet"),
    ],
)  # fmt: skip
def test_no_function_replaces_an_input_or_a_file_that_nobody_named(folder, call):
    before = contents(folder)
    with pytest.raises(InputError):
        call()
    assert contents(folder) == before


def test_the_molecule_of_a_scene_is_not_replaced_by_the_scene_of_a_part_of_it(folder):
    """It was written by the scene, and is an input of the next one."""
    sparsurf.surface("p.pdb").write("twice.cxc")
    before = contents(folder)
    part = sparsurf.surface(sparsurf.read_molecule("twice_molecule.pdb", residues="1-2"))
    with pytest.raises(InputError, match="input file"):
        part.write("twice.cxc")
    assert contents(folder) == before


@pytest.mark.parametrize(
    ("line", "named"),
    [
        ("surface p.pdb --mesh -o own.vert", "own.face"),
        ("surface p.pdb --mesh -o own.vert.gz", "own.face.gz"),
        ("frames two.pdb -o own.csv", "own_frames.csv"),
        ("frames two.pdb -o own.csv.gz", "own_frames.csv.gz"),
        ("frames two.pdb -o own.parquet", "own_frames.parquet"),
        ("frames two.pdb -o own.csv", "own_ranking.csv"),
        ("frames two.pdb --groups A:1-2+A:3-4 -o own.csv", "own_contacts.csv"),
        ("msms -if s.xyzr -of out -af out", "out.face"),
        ("msms -if s.xyzr -of out -no_header", "out.vert"),
        ("show two.pdb --no-open", "two.html"),
    ],
)
def test_what_was_written_there_before_is_replaced(folder, line, named):
    if "parquet" in line:
        pytest.importorskip("pyarrow")
    name, *words = shlex.split(line)
    for _ in range(2):
        assert (msms.main(words) if name == "msms" else command.main([name, *words])) == 0
        size = (folder / named).stat().st_size
        os.utime(folder / named, (0, 0))
    assert size > 100
    assert (msms.main(words) if name == "msms" else command.main([name, *words])) == 0
    assert (folder / named).stat().st_mtime > 0
