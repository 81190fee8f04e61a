"""What `write` puts into a file: a mesh with its triangles, dots with their fields, nothing twice; others read them."""

import os
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import sparsurf
from conftest import ROOT
from sparsurf.cli import command
from sparsurf.errors import InputError

PEPTIDE = ROOT / "data" / "tdp43" / "topology.pdb"


@pytest.fixture(scope="module")
def molecule():
    return sparsurf.read_molecule(PEPTIDE, residues="209-216")


@pytest.fixture(scope="module")
def mesh(molecule):
    return sparsurf.mesh(molecule, 300, fields=["hydropathy", "roughness"])


def header_of(path):
    return path.read_text().split("end_header")[0].splitlines()


def test_an_npz_of_a_mesh_has_its_triangles(mesh, tmp_path):
    sparsurf.write(mesh, tmp_path / "m.npz")
    with np.load(tmp_path / "m.npz") as held:
        arrays = dict(held)
    names = {
        "vertices",
        "normals",
        "faces",
        "area",
        "kind",
        "atom",
        "chain",
        "residue",
        "residue_name",
        "atom_name",
    }
    assert set(arrays) == names | {"hydropathy", "roughness"}
    assert {arrays[k].dtype for k in ("vertices", "normals", "area", "hydropathy")} == {np.dtype(np.float32)}
    assert arrays["faces"].dtype == np.int32 and np.array_equal(arrays["faces"], mesh.triangles)
    assert np.array_equal(arrays["vertices"], mesh.vertices.points)  # which are those of float32
    assert arrays["residue"].tolist() == mesh.to_frame()["residue"].tolist()
    again = sparsurf.read_surface(tmp_path / "m.npz")
    assert np.array_equal(again.points, mesh.vertices.points) and np.array_equal(
        again.atom, mesh.vertices.atom
    )
    assert again.fields["hydropathy"] == pytest.approx(mesh.vertices.fields["hydropathy"], rel=1e-6)
    assert set(again.fields) == {"hydropathy", "roughness"}


def test_what_a_killed_call_left_beside_its_output_is_removed_by_a_later_one(mesh, tmp_path):
    """After an hour; nothing of a call that may still write, nor a file of the user."""
    for name in ("killed/part.npz", "writing/part.npz", "mine/notes.txt"):
        file = tmp_path / f".sparsurf-{name}"
        file.parent.mkdir()
        file.touch()
        if "writing" not in name:
            os.utime(file.parent, (0, 0))
    sparsurf.write(mesh, tmp_path / "m.npz")
    assert {path.name for path in tmp_path.iterdir()} == {"m.npz", ".sparsurf-writing", ".sparsurf-mine"}
    assert (tmp_path / ".sparsurf-mine" / "notes.txt").exists()


def test_a_csv_of_a_mesh_is_refused(mesh, tmp_path):
    with pytest.raises(
        InputError,
        match="CSV cannot store",
    ):
        sparsurf.write(mesh, tmp_path / "m.csv")
    with pytest.raises(InputError, match=r"as '\.dms'; name a file that ends in (?!.*csv)"):
        sparsurf.write(mesh, tmp_path / "m.dms")
    assert not list(tmp_path.iterdir())


def test_a_ply_of_a_mesh_has_floats_alone_and_the_names_that_are_given(mesh, tmp_path):
    sparsurf.write(mesh, tmp_path / "m.ply", names={"hydropathy": "hphob"})
    header = header_of(tmp_path / "m.ply")
    properties = [line.split()[1:] for line in header if line.startswith("property") and "list" not in line]
    assert {kind for kind, _ in properties} == {"float"}
    names = [name for _, name in properties]
    assert names == ["x", "y", "z", "nx", "ny", "nz", "area", "kind", "atom", "hphob", "roughness"]
    assert header[-2:] == ["element face 596", "property list uchar int vertex_indices"]
    again = sparsurf.read_surface(tmp_path / "m.ply")
    assert again.fields["hphob"] == pytest.approx(mesh.vertices.fields["hydropathy"], rel=1e-5)
    sparsurf.write(mesh, tmp_path / "c.ply", colours=True)
    assert "property uchar red" in header_of(tmp_path / "c.ply")
    sparsurf.write(mesh.vertices, tmp_path / "d.ply")
    assert "property uchar red" in header_of(tmp_path / "d.ply")
    sparsurf.write(mesh.vertices, tmp_path / "e.ply", colours=False)
    assert "property uchar red" not in header_of(tmp_path / "e.ply")


def test_a_ply_of_a_mesh_has_no_kind_where_it_is_unknown(blob, tmp_path):
    sparsurf.write(sparsurf.mesh(sparsurf.Surface(*blob), 300), tmp_path / "m.ply")
    names = [line.split()[-1] for line in header_of(tmp_path / "m.ply") if line.startswith("property float")]
    assert "kind" not in names and names[:7] == ["x", "y", "z", "nx", "ny", "nz", "area"]


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (
            {"hydropaty": "hphob"},
            "names has 'hydropaty',",
        ),
        ({"hydropathy": "roughness"}, "fields 'roughness'"),
        ({"hydropathy": "x"}, "called 'x'"),
        ("hphob", "must be a dictionary"),
    ],
)
def test_names_that_do_not_fit_are_a_sentence(mesh, tmp_path, names, words):
    with pytest.raises(InputError, match=words):
        sparsurf.write(mesh, tmp_path / "m.ply", names=names)


def test_two_fields_may_change_their_names(mesh, tmp_path):
    sparsurf.write(mesh, tmp_path / "m.npz", names={"hydropathy": "roughness", "roughness": "hydropathy"})
    again = sparsurf.read_surface(tmp_path / "m.npz").fields
    for name, other in (("hydropathy", "roughness"), ("roughness", "hydropathy")):
        assert again[name] == pytest.approx(mesh.vertices.fields[other], rel=1e-6)


def test_names_and_colours_are_about_fields(mesh, molecule, tmp_path):
    with pytest.raises(InputError, match="names, colours"):
        sparsurf.write(mesh.to_frame(), tmp_path / "t.csv", names={"a": "b"})
    with pytest.raises(InputError, match="colours is 1"):
        sparsurf.write(mesh, tmp_path / "m.ply", colours=1)


def test_an_npz_of_dots_holds_no_array_twice(molecule, tmp_path):
    dots = sparsurf.surface(molecule)
    dots = replace(dots, fields={"mine": np.arange(len(dots)) / 7})
    for name, result in (("dots", dots), ("few", sparsurf.minimal(dots, n_dots=50))):
        sparsurf.write(result, tmp_path / f"{name}.npz", names={"mine": "yours"})
        with np.load(tmp_path / f"{name}.npz") as held:
            arrays = dict(held)
        assert not {"x", "y", "z", "nx", "ny", "nz", "mine"} & set(arrays)
        contents = [
            array.tobytes() for array in arrays.values() if array.dtype.kind == "f" and array.std() > 0
        ]
        assert len(set(contents)) == len(contents)
        again = sparsurf.read_surface(tmp_path / f"{name}.npz")
        surface = result if name == "dots" else result.surface
        assert np.array_equal(again.points, surface.points) and np.array_equal(again.area, surface.area)
        assert np.array_equal(again.fields["yours"], surface.fields["mine"])


def test_points_and_normals_are_enough_for_an_npz(molecule, tmp_path):
    points, normals = sparsurf.points(molecule, 200)
    np.savez(tmp_path / "bare.npz", points=points, normals=normals)
    again = sparsurf.read_surface(tmp_path / "bare.npz")
    assert np.array_equal(again.points, points) and np.isnan(again.area).all() and (again.atom == -1).all()
    few = sparsurf.points(molecule, 200, fields="roughness")
    for name in ("few.npz", "few.ply", "few.csv"):
        sparsurf.write(few, tmp_path / name, names={"roughness": "R"})
        again = sparsurf.read_surface(tmp_path / name)
        assert again.points == pytest.approx(few.points, abs=1e-4)
        assert again.fields["R"] == pytest.approx(few.fields["roughness"], rel=1e-5)
    residues = sparsurf.residues(few)
    again = sparsurf.read_surface(tmp_path / "few.npz")
    table = sparsurf.residues(molecule, again, roughness_values=again.fields["R"])
    assert table["area"].to_numpy() == pytest.approx(residues["area"].to_numpy(), rel=1e-5)


def test_the_command_writes_meshes_as_npz(mesh, tmp_path):
    output = tmp_path / "m.npz"
    assert command.main(["surface", str(PEPTIDE), "--mesh", "--density", "1", "-o", str(output)]) == 0
    with np.load(output) as held:
        assert held["faces"].max() + 1 == len(held["vertices"]) == len(held["residue"])


def test_trimesh_reads_meshes(mesh, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    sparsurf.write(mesh, tmp_path / "m.ply")
    found = trimesh.load(tmp_path / "m.ply", process=False)
    assert np.array_equal(found.faces, mesh.triangles) and found.is_watertight
    assert found.vertices == pytest.approx(mesh.vertices.points, abs=6e-5)
    assert found.volume == pytest.approx(mesh.volume, rel=1e-3)


def test_meshio_reads_meshes_and_fields(mesh, tmp_path):
    meshio = pytest.importorskip("meshio")
    sparsurf.write(mesh, tmp_path / "m.ply")
    found = meshio.read(tmp_path / "m.ply")
    assert np.array_equal(found.cells_dict["triangle"], mesh.triangles)
    assert found.point_data["hydropathy"] == pytest.approx(mesh.vertices.fields["hydropathy"], rel=1e-5)
    assert found.point_data["atom"].astype(int).tolist() == mesh.vertices.atom.tolist()


def test_plyfile_reads_meshes_and_fields(mesh, tmp_path):
    plyfile = pytest.importorskip("plyfile")
    sparsurf.write(mesh, tmp_path / "m.ply", names={"roughness": "iface"})
    vertices = plyfile.PlyData.read(tmp_path / "m.ply")["vertex"]
    assert vertices["iface"] == pytest.approx(mesh.vertices.fields["roughness"], rel=1e-5)


def b_factors_of(path):
    """B factors of the lines of atoms, by residue number."""
    lines = [line for line in path.read_text().splitlines() if line.startswith(("ATOM", "HETATM"))]
    return pd.Series([float(line[60:66]) for line in lines], [line[22:27].strip() for line in lines])


@pytest.mark.parametrize("of", ["residues", "atoms"])
def test_a_column_is_written_as_b_factors(molecule, tmp_path, of, caplog):
    table = getattr(sparsurf.areas(molecule), of)
    sparsurf.write(table, tmp_path / "a.pdb", molecule, column="accessible")
    expected = (
        table["accessible"] if of == "atoms" else table["accessible"].iloc[molecule.residue_index]
    ).to_numpy()
    found = b_factors_of(tmp_path / "a.pdb")
    np.testing.assert_allclose(found, expected, atol=0.00501)
    assert found.index.tolist() == molecule.residue.tolist() and caplog.messages == []
    again = sparsurf.read_molecule(tmp_path / "a.pdb")
    np.testing.assert_allclose(again.b_factor, found)
    sparsurf.write(table[table["residue"] != "212"], tmp_path / "a.pdb", molecule, column="accessible")
    without = (molecule.residue == "212").sum()
    assert (b_factors_of(tmp_path / "a.pdb")["212"] == 0).all()
    assert f"{without} atoms have no accessible; their B factor is 0" in caplog.text


@pytest.mark.parametrize(
    ("change", "name", "given", "words"),
    [
        ({}, "a.pdb", {}, "give column as well"),
        ({}, "a.pdb", {"column": "accessible"}, "give molecule as well"),
        ({}, "a.csv", {"column": "accessible"}, r"cannot be written as '\.csv'; name a file that ends in \.pdb"),
        ({}, "a.pdb", {"column": "height"}, "has no column 'height' of values; it has chain, residue"),
        ({"accessible": 1234.5}, "a.pdb", {"column": "accessible"}, "accessible is 1234.5 to 1234.5, .* scale the column"),
        ({"residue": "209"}, "a.pdb", {"column": "accessible"}, "two rows for one residue"),
        ({"residue": None}, "a.pdb", {"column": "accessible"}, "has no column residue"),
    ],
)  # fmt: skip
def test_a_column_that_cannot_be_written_is_a_sentence(molecule, tmp_path, change, name, given, words):
    table = sparsurf.areas(molecule).residues.assign(**change).dropna(axis=1, how="all")
    with pytest.raises(InputError, match=words):
        sparsurf.write(table, tmp_path / name, None if words.startswith("give mol") else molecule, **given)


def test_commands_write_a_column_and_name_one_for_a_pdb_alone(tmp_path, capsys):
    table, written = tmp_path / "a.csv", tmp_path / "a.pdb"
    for command_of, column in (("areas", "relative"), ("residues", "mean_roughness")):
        words = [command_of, str(PEPTIDE), "--residues", "209-216"]
        assert command.main([*words, "-o", str(table)]) == 0
        assert command.main([*words, "--column", column, "-o", str(written)]) == 0
        expected = pd.read_csv(table, dtype={"residue": str}).set_index("residue")[column].dropna()
        found = b_factors_of(written).groupby(level=0).first()[expected.index]
        np.testing.assert_allclose(found, expected, atol=0.00501)
        assert command.main([*words, "-o", str(written)]) == 1
        assert "--column: name" in capsys.readouterr().err
        assert command.main([*words, "--column", column, "-o", str(table)]) == 1
        assert "--column: name" in capsys.readouterr().err
