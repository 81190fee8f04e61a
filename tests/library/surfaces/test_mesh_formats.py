"""Meshes in formats of other programs, opened by programs that are not ours; those that are not installed are skipped."""

import os
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pytest

import sparsurf
from conftest import ROOT
from sparsurf.cli.command import main
from sparsurf.errors import InputError
from sparsurf.surfaces.formats.colours import KIND_COLOURS, scale_of

PROTEIN = ROOT / "data/tdp43/topology.pdb"


@pytest.fixture(scope="module")
def mesh():
    return sparsurf.mesh(PROTEIN, 700, fields=["roughness", "hydropathy"])


@pytest.mark.parametrize("name", ["m.obj", "m.glb", "m.stl", "m.ply", "m.obj.gz"])
@pytest.mark.parametrize("colours", [None, True])
def test_trimesh_opens_a_closed_mesh(mesh, tmp_path, name, colours):
    trimesh = pytest.importorskip("trimesh")
    sparsurf.write(mesh, tmp_path / name, colours=colours)
    path = tmp_path / name
    if name.endswith(".gz"):
        import gzip

        path = tmp_path / "unpacked.obj"
        path.write_bytes(gzip.decompress((tmp_path / name).read_bytes()))
    found = trimesh.load(path, force="mesh", process=name == "m.stl")  # an STL repeats its corners
    assert found.is_watertight and found.volume == pytest.approx(mesh.volume, rel=1e-4)
    if name != "m.stl":
        assert np.abs(found.vertices - mesh.vertices.points).max() < 1e-3
        assert np.array_equal(found.faces, mesh.triangles)
        if colours:
            shades = scale_of("roughness", mesh.vertices.fields["roughness"]).colours
            assert np.abs(found.visual.vertex_colors[:, :3].astype(int) - shades).max() <= 1
    if name == "m.obj":  # trimesh computes normals of its own
        lines = [line.split() for line in path.read_text().splitlines()]
        normals = np.array([words[1:] for words in lines if words[:1] == ["vn"]], float)
        assert np.abs(normals - mesh.vertices.normals).max() < 1e-3
    if colours and name != "m.stl":
        bare = replace(mesh, vertices=replace(mesh.vertices, fields={}))
        sparsurf.write(bare, tmp_path / "kinds.ply", colours=True)
        found = trimesh.load(tmp_path / "kinds.ply", process=False)
        assert np.array_equal(found.visual.vertex_colors[:, :3], KIND_COLOURS[mesh.vertices.kind])


def test_without_trimesh_one_sentence_says_what_to_install(mesh, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "trimesh", None)
    with pytest.raises(InputError, match="pip install trimesh,"):
        sparsurf.write(mesh, tmp_path / "m.glb")
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match=r"written as '\.obj'"):
        sparsurf.write(mesh.vertices, tmp_path / "dots.obj")


@pytest.mark.parametrize("faces", [True, False])
def test_pyvista_finds_all_numbers_of_a_vtp(mesh, tmp_path, faces):
    pyvista = pytest.importorskip("pyvista")
    sparsurf.write(mesh if faces else mesh.vertices, tmp_path / "m.vtp")
    found = pyvista.read(tmp_path / "m.vtp")
    assert np.abs(found.points - mesh.vertices.points).max() < 1e-4
    for name, values in mesh.vertices.fields.items():
        assert found.point_data[name] == pytest.approx(values, rel=1e-5, abs=1e-6)
    assert np.array_equal(found.point_data["atom"], mesh.vertices.atom)
    if faces:
        assert np.array_equal(found.regular_faces, mesh.triangles)
        assert found.is_manifold and found.volume == pytest.approx(mesh.volume, rel=1e-4)


def test_a_vtp_is_xml_with_the_numbers_in_base64(mesh, tmp_path):
    import base64

    sparsurf.write(mesh, tmp_path / "m.vtp")
    root = ElementTree.parse(tmp_path / "m.vtp").getroot()
    piece = root.find("PolyData/Piece")
    assert piece.attrib["NumberOfPoints"] == "700" and piece.attrib["NumberOfPolys"] == str(
        len(mesh.triangles)
    )
    arrays = {array.attrib["Name"]: array for array in root.iter("DataArray")}
    content = base64.b64decode(arrays["hydropathy"].text)
    assert np.frombuffer(content[8:], "<f4") == pytest.approx(mesh.vertices.fields["hydropathy"], rel=1e-5)
    assert np.frombuffer(content[:8], "<u8")[0] == len(content) - 8


def test_meshio_opens_what_it_reads(mesh, tmp_path):
    meshio = pytest.importorskip("meshio")
    pytest.importorskip("trimesh")
    for name in ("m.obj", "m.ply", "m.vtp"):
        sparsurf.write(mesh, tmp_path / name)
        if name == "m.vtp":  # a format that it does not read
            continue
        found = meshio.read(tmp_path / name)
        assert np.abs(found.points - mesh.vertices.points).max() < 1e-3
        assert np.array_equal(found.cells_dict["triangle"], mesh.triangles)


@pytest.mark.skipif(shutil.which("pymol") is None, reason="PyMOL is not installed")
def test_pymol_opens_a_coloured_mesh(mesh, tmp_path):
    sparsurf.write(mesh, tmp_path / "m.pml")
    script = "print('extent', cmd.get_extent('mesh'), cmd.get_names())"
    words = ["pymol", "-ckq", str(tmp_path / "m.pml"), "-d", script]
    path = os.pathsep.join(["/usr/bin", os.environ["PATH"]])  # Debian's own python runs it
    environment = os.environ | {"PATH": path}
    environment.pop("PYTHONPATH", None)
    run = subprocess.run(words, capture_output=True, text=True, timeout=120, check=False, env=environment)
    assert "'structure'" in run.stdout and "'mesh'" in run.stdout, run.stdout + run.stderr


def test_a_full_mesh_with_a_field_is_a_small_script(tmp_path):
    sparsurf.write(sparsurf.mesh(PROTEIN, fields="roughness"), tmp_path / "m.pml")
    assert (tmp_path / "m.pml").stat().st_size < 5e6


def test_the_command_colours_where_asked(tmp_path):
    pytest.importorskip("trimesh")
    for name in ("m.ply", "m.obj", "m.glb"):
        sizes = []
        for words in ([], ["--colours"]):
            call = ["surface", str(PROTEIN), "--mesh", "--density", "0.2", *words, "-o", str(tmp_path / name)]
            assert main(call) == 0
            sizes.append((tmp_path / name).stat().st_size)
        assert sizes[1] > 1.05 * sizes[0]
