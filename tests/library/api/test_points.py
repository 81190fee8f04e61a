"""A few points of a structure or of a folder: exact, spread, the same bytes however they are asked for."""

import numpy as np
import pandas as pd
import pytest

import sparsurf
from conftest import ROOT
from sparsurf.cli import command
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("structures")
    for name, residues in (("b", "209-216"), ("a", "217-224")):
        molecule = read_molecule(ROOT / "data/tdp43/topology.pdb", residues=residues)
        molecule.write_pdb(place / f"{name}.pdb")
    return place


def test_points_are_dots_of_the_surface_without_cavities():
    path = ROOT / "data/tdp43/topology.pdb"
    dots = sparsurf.surface(path, cavities="remove")
    points, normals = sparsurf.points(path, 300)
    assert points.dtype == normals.dtype == np.float32 and points.shape == normals.shape == (300, 3)
    rows = {row.tobytes(): n for n, row in enumerate(dots.points.astype(np.float32))}
    chosen = [rows[row.tobytes()] for row in points]
    assert np.array_equal(normals, dots.normals[chosen].astype(np.float32)) and len({*chosen}) == 300
    assert np.array_equal(points[:100], sparsurf.points(path, 100)[0])
    gaps = np.linalg.norm(points[:, None] - points, axis=2) + 9 * np.eye(300)
    area = dots.area.sum() / 300
    assert gaps.min() > 0.7 * np.sqrt(area)  # a square of that area has this side


def test_more_points_than_the_default_density_has_are_placed(folder):
    dots = sparsurf.surface(folder / "a.pdb")
    n = 2 * len(dots)
    assert len(np.unique(sparsurf.points(folder / "a.pdb", n)[0], axis=0)) == n
    points = sparsurf.points(folder / "a.pdb", density=0.5)[0]
    assert len(points) == round(dots.area.sum() / 2)
    with pytest.raises(InputError, match="more than 100 per"):
        sparsurf.points(folder / "a.pdb", 10_000_000)
    with pytest.raises(InputError, match="either n_dots or density"):
        sparsurf.points(folder / "a.pdb", 10, density=1.0)


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_folder_gives_the_points_of_each_structure(folder, jobs, tmp_path):
    (tmp_path / "c.pdb").write_text("nothing")
    for path in folder.iterdir():
        (tmp_path / path.name).write_text(path.read_text())
    results = list(sparsurf.points_of(tmp_path, 50, jobs=jobs, seed=3))
    assert [name for name, *_ in results] == ["a", "b"]
    for name, points, normals in results:
        alone = sparsurf.points(folder / f"{name}.pdb", 50, seed=3)
        assert np.array_equal(alone[0], points) and np.array_equal(alone[1], normals)


def test_folders_of_structures(folder, tmp_path):
    with pytest.raises(InputError, match="holds no structure"):
        list(sparsurf.points_of(tmp_path))
    for name in ("a.pdb", "a.ent"):
        (tmp_path / name).write_text((folder / "a.pdb").read_text())
    with pytest.raises(InputError, match="one name"):
        list(sparsurf.points_of(tmp_path))
    pytest.importorskip("pyarrow")
    output = tmp_path / "points.parquet"
    assert command.main(["points", str(folder), "-n", "40", "-o", str(output)]) == 0
    table = pd.read_parquet(output)
    assert list(table) == ["name", "x", "y", "z", "nx", "ny", "nz"] and (table.dtypes[1:] == np.float32).all()
    expected = [(name, np.hstack(arrays)) for name, *arrays in sparsurf.points_of(folder, 40)]
    assert np.array_equal(table.iloc[:, 1:], np.concatenate([rows for _, rows in expected]))
    assert table["name"].tolist() == [name for name, rows in expected for _ in rows]


@pytest.mark.parametrize("suffix", ["npz", "ply"])
def test_the_command_writes_the_points_of_one_structure(folder, suffix, tmp_path):
    output = tmp_path / f"points.{suffix}"
    assert command.main(["points", str(folder / "a.pdb"), "-n", "60", "-o", str(output)]) == 0
    dots = np.load(output)["points"] if suffix == "npz" else sparsurf.read_surface(output).points
    assert np.allclose(dots, sparsurf.points(folder / "a.pdb", 60)[0], atol=1e-4)
    assert command.main(["points", str(folder), "-o", str(output)]) == 1
