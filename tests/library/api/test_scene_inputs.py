"""Scenes of dots in another order, turned, and with unknown values, on three pieces: which colour is at which place."""

import base64
import importlib
import re
from dataclasses import replace
from types import SimpleNamespace
from typing import NamedTuple

import matplotlib
import numpy as np
import pytest
from scipy.spatial import ConvexHull, cKDTree
from scipy.spatial.transform import Rotation

import sparsurf
from peptides import peptide, write
from sparsurf import Surface
from sparsurf.api.writing import DotsToWrite, write_dots
from sparsurf.surfaces.mesh import Mesh

TURN, SHIFT = Rotation.from_euler("xyz", [30, 110, 200], degrees=True), np.array([30.0, -20, 10])
SIZES, CENTRES = (70, 50, 30), ((0.0, 0, 0), (0, 25, 0), (0, 0, 30))  # of three pieces without a symmetry
UNKNOWN = np.array([160, 160, 160])
KINDS = np.array([[86, 180, 233], [230, 159, 0], [0, 158, 115]])  # contact, saddle, concave


def three_pieces():
    """Points, outward normals, triangles and a number for each point of three bodies that lie far apart."""
    rng = np.random.default_rng(4)
    points, normals, triangles = [], [], []
    for n, centre in zip(SIZES, CENTRES, strict=True):
        unit = rng.normal(size=(n, 3))
        unit /= np.linalg.norm(unit, axis=1)[:, None]
        corners = ConvexHull(unit).simplices
        a, b, c = (unit[corners[:, k]] for k in range(3))
        inwards = np.sum(np.cross(b - a, c - a) * a, axis=1) < 0
        corners[inwards] = corners[inwards][:, ::-1]
        triangles.append(corners + sum(map(len, points)))
        points.append(unit * [6, 5, 4] + centre)
        normals.append(unit)
    points = np.vstack(points)
    return points, np.vstack(normals), np.vstack(triangles), 20 + points @ [0.2, 0.5, -0.3]


@pytest.fixture(scope="module")
def molecule(tmp_path_factory):
    """Three chains, one inside of each piece."""
    parts = [
        peptide(("ALA", "SER"), chain, origin=centre) for chain, centre in zip("ABC", CENTRES, strict=True)
    ]
    path = write(tmp_path_factory.mktemp("molecule") / "three.pdb", "TER\n".join(parts) + "END\n")
    return sparsurf.read_molecule(path)


class Scene(NamedTuple):
    """What a file shows, for each dot or for each corner of the triangles, three after three."""

    places: np.ndarray  # (N, 3), Å
    colours: np.ndarray  # (N, 3), 0..255
    atoms: np.ndarray | None = None  # (A, 3), Å, of the molecule
    normals: np.ndarray | None = None  # (N, 3)


def read_pdb(path):
    """Places of the atoms of a PDB file, their B factors, and whether their occupancy is 1."""
    lines = [line for line in path.read_text().splitlines() if line.startswith(("ATOM", "HETATM"))]
    places = np.array([[line[k : k + 8] for k in (30, 38, 46)] for line in lines], float)
    return places, *(np.array([line[k : k + 6] for line in lines], float) for k in (60, 54))


def read_pml(path):
    """The scene of a script of PyMOL, whose Python runs with a `cmd` that notes what it is given."""
    loaded, words = {}, ("COLOR", "SPHERE", "BEGIN", "TRIANGLES", "NORMAL", "VERTEX", "END")
    cmd = SimpleNamespace(
        load_cgo=lambda objects, name: loaded.setdefault(name, objects),
        read_pdbstr=lambda text, name: loaded.setdefault(name, text),
    )
    for block in re.findall(r"^python\n(.*?)^python end", path.read_text(), re.M | re.S):
        exec(
            block.replace("from pymol import cgo\n", ""),
            {"cmd": cmd, "cgo": SimpleNamespace(**{w: w for w in words})},
        )
    places, colours, normals, colour = [], [], [], None
    values = loaded.get("mesh", loaded.get("dots"))
    for k, word in enumerate(values):
        if word == "COLOR":
            colour = values[k + 1 : k + 4]
        elif word == "NORMAL":
            normals.append(values[k + 1 : k + 4])
        elif word in ("SPHERE", "VERTEX"):
            places.append(values[k + 1 : k + 4])
            colours.append(colour)
    path.with_suffix(".pdb").write_text(loaded["structure"])
    atoms, normals = read_pdb(path.with_suffix(".pdb"))[0], np.array(normals, float) if normals else None
    return Scene(np.array(places, float), 255 * np.array(colours, float), atoms, normals)


def read_bild(path):
    """The scene of a BILD file; the corners of a triangle share its colour."""
    places, colours, colour = [], [], None
    for name, *numbers in map(str.split, path.read_text().splitlines()):
        if name == ".color":
            colour = [*map(float, numbers)]
        elif name != ".comment":
            corners = np.array(numbers[:3] if name == ".sphere" else numbers, float).reshape(-1, 3)
            places += corners.tolist()
            colours += [colour] * len(corners)
    return Scene(np.array(places), 255 * np.array(colours))


def read_cxc(path):
    """The scene of the files that a script of ChimeraX opens."""
    opened = re.findall(r"^open (\S+)", path.read_text(), re.M)
    pdb, bild = (
        path.with_name(next(name for name in opened if name.endswith(end))) for end in (".pdb", ".bild")
    )
    return read_bild(bild)._replace(atoms=read_pdb(pdb)[0])


def read_ply(path):
    """The scene of a PLY file."""
    header, body = path.read_text().split("end_header\n")
    names, n = re.findall(r"property \w+ (\w+)", header), int(re.search(r"vertex (\d+)", header)[1])
    lines = body.splitlines()
    table = np.array([line.split() for line in lines[:n]], float)
    rows = np.array([line.split()[1:] for line in lines[n:]], int).ravel() if lines[n:] else slice(None)
    places, colours, normals = (
        table[rows][:, [names.index(name) for name in given]]
        for given in (("x", "y", "z"), ("red", "green", "blue"), ("nx", "ny", "nz"))
    )
    return Scene(places, colours, normals=normals)


def read_by_trimesh(path):
    """The scene of a mesh, as trimesh reads it."""
    mesh = importlib.import_module("trimesh").load_mesh(path, process=False)
    corners = mesh.faces.ravel()
    places, normals = mesh.vertices[corners], mesh.vertex_normals[corners]
    return Scene(places, mesh.visual.vertex_colors[corners][:, :3], normals=normals)


READERS = {".pml": read_pml, ".bild": read_bild, ".cxc": read_cxc, ".ply": read_ply}
OF_MESHES = READERS | {".obj": read_by_trimesh, ".glb": read_by_trimesh}


def scaled(values):
    """Colours (N, 3) of numbers on the scale from the smallest to the largest that is known; grey for the others."""
    known = np.isfinite(values)
    share = (values - values[known].min()) / np.ptp(values[known])
    colours = 255 * matplotlib.colormaps["viridis"](np.where(known, share, 0))[:, :3]
    return np.where(known[:, None], colours, UNKNOWN)


def without_some(values):
    """The numbers without the smallest, the largest and every seventh."""
    ends = [values.argmin(), values.argmax()]
    return np.where(np.isin(np.arange(len(values)), ends) | (np.arange(len(values)) % 7 == 3), np.nan, values)


def shuffled(n):
    return np.random.default_rng(n).permutation(n)


def assert_same(found, wanted, colours, of_wanted, tolerance=2.6):
    """Every wanted place occurs once in the file, with its colour, of 255 and rounded to hundredths in BILD."""
    assert len(found) == len(wanted)
    distance, row = cKDTree(wanted).query(found)
    assert distance.max() <= 0.002 and len(np.unique(row)) == len(wanted)
    assert np.abs(colours - of_wanted[row]).max() <= tolerance


CHANGES = {  # order of the dots, and whether they are turned
    "as they are": (lambda n: slice(None), False),
    "in another order": (shuffled, False),
    "turned": (lambda n: slice(None), True),
}


@pytest.fixture(params=CHANGES)
def changed(request, molecule):
    """The dots, their mesh and their molecule in another order or turned; their numbers are in the order of the file."""
    points, normals, triangles, numbers = three_pieces()
    order, is_turned = CHANGES[request.param]
    rows, faces = order(len(points)), order(len(triangles))
    if is_turned:
        points, normals = TURN.apply(points) + SHIFT, TURN.apply(normals)
        molecule = replace(molecule, xyz=TURN.apply(molecule.xyz[0])[None] + SHIFT)
    kinds = np.arange(len(points)) % 3
    atom = np.repeat([0, 10, 20], SIZES)
    surface = Surface(points, normals, kind=kinds, atom=atom)[rows]
    triangles = np.argsort(np.arange(len(points))[rows])[triangles[faces]]
    return SimpleNamespace(surface=surface, triangles=triangles, numbers=numbers[rows], molecule=molecule)


@pytest.mark.parametrize("suffix", READERS)
@pytest.mark.parametrize("shown", ["kind", "field", "field of some"])
def test_each_dot_has_its_colour_at_its_place(suffix, shown, changed, tmp_path):
    numbers = without_some(changed.numbers) if shown == "field of some" else changed.numbers
    dots = changed.surface if shown == "kind" else replace(changed.surface, fields={"height": numbers})
    wanted = KINDS[dots.kind] if shown == "kind" else scaled(numbers)
    path = tmp_path / f"dots{suffix}"
    if suffix == ".ply":  # as the command writes a column
        column = None if shown == "kind" else "height"
        write_dots(path, DotsToWrite(dots, dots.fields, column))
    else:
        sparsurf.write(dots, path, changed.molecule)
    scene = READERS[suffix](path)
    assert_same(scene.places, dots.points, scene.colours, wanted)
    if scene.atoms is not None:
        assert np.abs(scene.atoms - changed.molecule.xyz[0]).max() < 0.001
    if scene.normals is not None:
        assert_same(scene.places, dots.points, 100 * scene.normals, 100 * dots.normals)


@pytest.mark.parametrize("suffix", OF_MESHES)
@pytest.mark.parametrize("shown", ["field", "field of some"])
def test_each_triangle_has_the_colours_of_its_corners(suffix, shown, changed, tmp_path):
    numbers = without_some(changed.numbers) if shown == "field of some" else changed.numbers
    mesh = Mesh(replace(changed.surface, fields={"height": numbers}), changed.triangles)
    if OF_MESHES[suffix] is read_by_trimesh:
        pytest.importorskip("trimesh")
    molecule = changed.molecule if suffix in (".pml", ".cxc") else None
    sparsurf.write(mesh, tmp_path / f"mesh{suffix}", molecule, colours=True)
    scene = OF_MESHES[suffix](tmp_path / f"mesh{suffix}")
    corners = mesh.vertices.points[mesh.triangles]
    wanted = scaled(numbers)[mesh.triangles]
    if suffix in (".bild", ".cxc"):  # one colour for each triangle
        wanted = np.repeat(wanted.mean(axis=1, keepdims=True), 3, axis=1)
    found = scene.places.reshape(-1, 3, 3)
    assert_same(found.mean(axis=1), corners.mean(axis=1), np.zeros(len(found)), np.zeros(len(found)))
    sides = [np.cross(of[:, 1] - of[:, 0], of[:, 2] - of[:, 0]) for of in (found, corners)]
    assert_same(found.mean(axis=1), corners.mean(axis=1), *(100 * side for side in sides), tolerance=5)
    # a corner occurs in several triangles, which its distance to their middles tells apart
    marks = [of + 0.1 * (of - of.mean(axis=1, keepdims=True)) for of in (found, corners)]
    marks = [mark.reshape(-1, 3) for mark in marks]
    assert_same(*marks, scene.colours, wanted.reshape(-1, 3))
    if scene.atoms is not None:
        assert np.abs(scene.atoms - molecule.xyz[0]).max() < 0.001
    if scene.normals is not None:
        normals = mesh.vertices.normals[mesh.triangles].reshape(-1, 3)
        assert_same(*marks, 100 * scene.normals, 100 * normals)


def test_each_dot_of_a_pdb_has_its_number_as_b_factor_or_an_occupancy_of_0(changed, tmp_path):
    numbers = without_some(changed.numbers)
    sparsurf.write(replace(changed.surface, fields={"height": numbers}), tmp_path / "dots.pdb")
    places, b_factor, occupancy = read_pdb(tmp_path / "dots.pdb")
    assert np.abs(places - changed.surface.points).max() < 0.001
    known = np.isfinite(numbers)
    assert np.abs(b_factor - numbers)[known].max() < 0.0051
    assert not known.all() and occupancy.tolist() == known.astype(float).tolist()


def test_each_point_of_a_vtp_has_its_number(changed, tmp_path):
    numbers = without_some(changed.numbers)
    mesh = Mesh(replace(changed.surface, fields={"height": numbers}), changed.triangles)
    sparsurf.write(mesh, tmp_path / "mesh.vtp")
    arrays = re.findall(r'Name="(\w+)"[^>]*>\s*([^<\s]+)', (tmp_path / "mesh.vtp").read_text())
    content = {name: base64.b64decode(text)[8:] for name, text in arrays}
    places = np.frombuffer(content["points"], "<f4").reshape(-1, 3)
    assert np.abs(places - mesh.vertices.points).max() < 1e-4
    height = np.frombuffer(content["height"], "<f4")
    assert np.allclose(height, numbers, atol=1e-4, equal_nan=True) and np.isnan(numbers).any()
    assert np.frombuffer(content["connectivity"], "<i4").tolist() == mesh.triangles.ravel().tolist()
