"""A value of the wrong type is refused in a sentence, whichever argument of whichever function it is given as."""

import inspect
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import sparsurf
from conftest import ROOT
from sparsurf.cli import command
from sparsurf.dot_fields.curvature import principal_curvatures
from sparsurf.errors import InputError
from sparsurf.surfaces.mesh import Mesh
from sparsurf.surfaces.surface import Surface

TOPOLOGY = ROOT / "data" / "tdp43" / "topology.pdb"
D_LINK = 1.6  # Å, for few dots
FUNCTIONS = sorted(
    name for name in dir(sparsurf) if not name.startswith("_") and inspect.isfunction(getattr(sparsurf, name))
)


class Unshown:
    """An object that no message can quote."""

    def __repr__(self):
        raise RuntimeError("no text")

    __str__ = __format__ = __repr__


WRONG = [
    True, -1, 1.5, float("nan"), b"x", "", [], [1, 2], {"a": 1}, np.array(1.0), np.array([]), np.array([1.0, 2.0]),
    np.ones((2, 3)), np.array(True), np.array([None]), object(), len, 1j, Path("x"), Fraction(1, 100), 5e-324, "x" * 5000,
    [[1], [1, 2]], Unshown(),
]  # fmt: skip


@pytest.fixture(scope="module")
def molecule():
    return sparsurf.read_molecule(TOPOLOGY, residues="209-212", hydrogens="remove")


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.filterwarnings("ignore")
def test_no_function_fails_from_inside(molecule, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sparsurf.api.show.has_display", lambda: False)
    molecule.write_pdb(tmp_path / "a.pdb")
    dots = sparsurf.surface(molecule, density=1.2, d_link=D_LINK)
    function = getattr(sparsurf, name)
    parameters = inspect.signature(function).parameters
    given = {"molecule": molecule, "folder": tmp_path, "subset": [1, 2], "subsets": {"a": [1, 2]}, "at": [0, 1],
             "names": ("hydropathy",), "path": tmp_path / ("a.pdb" if name == "read_molecule" else "b.csv")}  # fmt: skip
    base = {
        each: given.get(each, dots)
        for each, one in parameters.items()
        if one.default is inspect.Parameter.empty
    }
    base |= {"d_link": D_LINK} if "d_link" in parameters else {}
    base |= {"n_dots": 20} if name in ("sample", "minimal", "points", "points_of") else {}
    base |= {"open_browser": False} if name == "show" else {}
    for argument in parameters:
        for value in WRONG:
            try:
                result = function(**base | {argument: value})
                if name == "points_of":
                    list(result)
            except InputError as error:
                assert str(error).endswith((".", "?"))
            except Exception as error:
                pytest.fail(f"{argument} of the type {type(value).__name__}: {error!r}")


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda m, d: sparsurf.density_for(0.02, hydrogens="no"), "hydrogens is 'no'"),
        (lambda m, d: sparsurf.error_at(1, hydrogens=1), "hydrogens is 1"),
        (lambda m, d: sparsurf.points_of(""), "path is empty"),
        (lambda m, d: sparsurf.points_of(5), "Path, not int"),
        (lambda m, d: sparsurf.write(d, "a.csv", frame=7), "frame=7 is that of `molecule`; leave it out"),
        (lambda m, d: sparsurf.write(d, "a.csv", frame="x"), "frame is 'x'"),
        (lambda m, d: sparsurf.write(m, "a.pdb", frame=1), "frame 1"),
        (lambda m, d: sparsurf.surface(m, frame=True), "whole number"),
        (lambda m, d: sparsurf.sample(d, 10), "here 2 values"),
        (lambda m, d: sparsurf.sample(d, surface=d), "given twice"),
        (lambda m, d: sparsurf.roughness(), "roughness needs surface"),
        (lambda m, d: sparsurf.write(d.to_frame(), "a.csv", frame=2), "frame=2 is that of"),
        (lambda m, d: sparsurf.components((m.xyz[0] * np.nan, np.ones(m.n_atoms)), d), "other spheres"),
        (lambda m, d: sparsurf.components((d.origin.xyz, d.origin.radii + 0.1), d), "other spheres"),
        (lambda m, d: sparsurf.components((), d), "a tuple is not a molecule"),
        (lambda m, d: sparsurf.fields(d, "hydropathy", charges="none"), "field potential"),
    ],
)  # fmt: skip
def test_no_argument_is_ignored_in_silence(molecule, tmp_path, monkeypatch, call, words):
    monkeypatch.chdir(tmp_path)
    dots = sparsurf.surface(molecule, density=1.2, d_link=D_LINK)
    with pytest.raises(InputError, match=words):
        call(molecule, dots)


def test_a_page_needs_more_than_one_dot(tmp_path):
    for n in (1, 50):  # at one place
        (tmp_path / "a.csv").write_text("x,y,z,nx,ny,nz\n" + n * "1,2,3,0,0,1\n")
        with pytest.raises(InputError, match="single dot;"):
            sparsurf.show(tmp_path / "a.csv", open_browser=False)


def test_a_name_that_is_not_utf8_is_no_trouble(molecule, tmp_path, capsys):
    path = tmp_path / "n\udcff.pdb"  # the byte 0xff
    molecule.write_pdb(path)
    for output in ("o.html", "o.png", "\udcff.csv"):
        command.main(["surface", str(path), "-o", str(tmp_path / output), "--density", "1.5"])
        assert (tmp_path / output).stat().st_size > 1000
    assert "n\ufffd" in (tmp_path / "o.html").read_text(encoding="utf-8")


def test_output_to_a_closed_stream_is_refused(molecule, tmp_path):
    molecule.write_pdb(tmp_path / "a.pdb")
    run = f"'{sys.executable}' -m sparsurf surface a.pdb -o - >&-"
    done = subprocess.run(["sh", "-c", run], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode != 0 and "standard output" in done.stderr


@pytest.mark.parametrize("kind", ["npz", "ply", "csv"])
def test_fields_whose_names_cannot_be_kept_are_named(molecule, tmp_path, caplog, kind):
    dots = sparsurf.surface(molecule, density=1.2, d_link=D_LINK)
    path = tmp_path / f"a.{kind}"
    if kind == "npz":
        np.savez(path, points=dots.points, normals=dots.normals, **{"bad name": dots.area, "good": dots.area})
    else:
        names = ["x", "y", "z", "nx", "ny", "nz", "bad-name", "good"]
        table = np.column_stack([dots.points, dots.normals, dots.area, dots.area])
        head = ",".join(names)
        if kind == "ply":
            rows = "\n".join(f"property float {each.upper() if each[:1] == 'n' else each}" for each in names)
            head = f"ply\nformat ascii 1.0\nelement vertex {len(dots)}\n{rows}\nend_header"
        np.savetxt(path, table, header=head, comments="", delimiter="," if kind == "csv" else " ")
    found = sparsurf.read_surface(path)
    assert list(found.fields) == ["good"] and len(found) == len(dots)
    assert "'bad" in caplog.text and "left out:" in caplog.text


def test_the_volume_of_a_mesh_does_not_depend_on_its_place():
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    for shift in (0, 1e6):
        mesh = Mesh(Surface(corners + shift, np.tile([0.0, 0, 1], (4, 1))), faces)
        assert mesh.volume == pytest.approx(1 / 6, rel=1e-9)


def test_curvature_of_atoms_in_one_place_is_that_of_one(molecule):
    twice = molecule.take(np.append(np.arange(molecule.n_atoms), 7))
    dots = [
        sparsurf.surface((each.xyz[0], np.full(each.n_atoms, 1.7)), density=1.2, d_link=D_LINK)
        for each in (molecule, twice)
    ]
    one, two = (principal_curvatures(each, each.origin) for each in dots)
    assert np.isfinite(two).all()
    np.testing.assert_allclose(one, two)


@pytest.mark.parametrize("names", [["hydropathy"], ("hydropathy", "potential"), "hydropathy"])
def test_names_of_fields_in_the_place_of_dots_are_known_as_such(names):
    """They were called a list that is not a surface."""
    with pytest.raises(InputError, match="missing; call"):
        sparsurf.fields(ROOT / "data" / "tdp43" / "topology.pdb", names)
