"""A few points of a structure or of a folder: exact, spread, the same bytes however they are asked for."""

import json
import pickle
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree

import sparsurf
from conftest import ROOT
from peptides import peptide, write
from sparsurf.api import checkpoints
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
    many = sparsurf.points(folder / "a.pdb", 9 * len(dots) // 10, fields="roughness")
    gap = cKDTree(many.points).query(many.points, 2)[0][:, 1]
    assert gap.min() > 0.65 * np.sqrt(dots.area.sum() / len(many.points))  # 0.58 of the dots alone
    nearest = cKDTree(dots.points).query(many.points)[1]  # whatever was placed to choose from
    assert many.fields["roughness"] == pytest.approx(sparsurf.roughness(dots)[nearest], abs=1e-6)
    with pytest.raises(InputError, match="100 per"):
        sparsurf.points(folder / "a.pdb", 10_000_000)
    with pytest.raises(InputError, match="either n_dots"):
        sparsurf.points(folder / "a.pdb", 10, density=1.0)


PROTEIN = ROOT / "data/tdp43/topology.pdb"
LABELS = ["chain", "residue", "residue_name", "atom_name", "atom"]
POSITIONS = ["x", "y", "z", "nx", "ny", "nz", "area"]


@pytest.fixture(scope="module")
def dots():
    return sparsurf.surface(PROTEIN, cavities="remove")


@pytest.fixture(scope="module")
def few():
    return sparsurf.points(PROTEIN, 1024, fields=["roughness", "hydropathy"])


def test_points_have_what_the_dots_have_that_they_are(dots, few):
    rows = {row.tobytes(): n for n, row in enumerate(dots.points.astype(np.float32))}
    chosen = [rows[row.tobytes()] for row in few.points]
    assert np.array_equal(few.atom, dots.atom[chosen]) and np.array_equal(few.kind, dots.kind[chosen])
    assert np.array_equal(few.fields["roughness"], sparsurf.roughness(dots)[chosen].astype(np.float32))
    hydropathy = sparsurf.fields(dots, "hydropathy")["hydropathy"].to_numpy()[chosen]
    assert few.fields["hydropathy"] == pytest.approx(hydropathy, abs=1e-5)
    nearest = cKDTree(dots.points[chosen]).query(dots.points)[1]
    area = np.bincount(nearest, dots.area, 1024)
    assert (
        np.abs(few.area - area) < 1e-4
    ).mean() > 0.99  # a dot halfway between two points counts for one of them
    table = few.to_frame()
    assert list(table) == [*POSITIONS, "kind", *LABELS, "roughness", "hydropathy"]
    assert (table[[*POSITIONS, "roughness", "hydropathy"]].dtypes == np.float32).all()
    named = dots.to_frame().loc[chosen, LABELS[:4]].reset_index(drop=True)
    pd.testing.assert_frame_equal(table[LABELS[:4]], named)
    points, normals = few
    assert points is few.points and normals is few.normals


def test_functions_take_points_for_dots(few, tmp_path):
    table = sparsurf.fields(few, ["hydropathy", "potential"])
    assert np.array_equal(table["hydropathy"].astype(np.float32), few.fields["hydropathy"])
    assert len(sparsurf.recover(few)) > 10_000 and "hydropathy" in sparsurf.recover(few).fields
    again = pickle.loads(pickle.dumps(few))
    pd.testing.assert_frame_equal(again.to_frame(), few.to_frame())
    mesh = sparsurf.mesh(few, 500)  # the surface recovered from them
    assert set(mesh.vertices.fields) == {"roughness", "hydropathy"}
    atoms = few.molecule.xyz[0][mesh.vertices.atom]
    assert np.linalg.norm(atoms - mesh.vertices.points, axis=1).max() < 6


def by_residue(table, weight):
    """Means of the fields and sums of the area, by residue."""
    groups = table.assign(residue_=table["residue"].astype(int)).groupby("residue_")
    return groups[weight].sum(), groups["roughness"].mean(), groups.size()


def test_a_table_by_residue_agrees_with_that_of_the_dense_surface(dots, few):
    """Within its sampling error: a residue has a share of the points, and a mean of n of them varies as 1 / sqrt(n)."""
    dense = sparsurf.residues(dots)
    dense = dense.set_index(dense["residue"].astype(int))
    area, roughness, count = by_residue(few.to_frame(), "area")
    exposed = dense.loc[area.index]
    assert area.sum() == pytest.approx(dots.area.sum(), rel=1e-5)
    spacing = np.sqrt(dense["area"].sum() / 1024)
    border = np.sqrt(exposed["area"])  # its length falls in half a spacing, up or down
    assert (np.abs(area - exposed["area"]) < spacing * border).all()
    assert np.corrcoef(area, exposed["area"])[0, 1] > 0.98
    spread = pd.Series(sparsurf.roughness(dots)).groupby(dots.to_frame()["residue"].astype(int)).std()
    z = (roughness - exposed["mean_roughness"]) / (spread.loc[roughness.index] / np.sqrt(count))
    assert np.sqrt((z**2).mean()) < 1.0 and np.abs(z).max() < 4
    ours = sparsurf.residues(few)
    ours = ours.set_index(ours["residue"].astype(int)).loc[area.index]
    assert ours["area"].to_numpy() == pytest.approx(area.to_numpy(), rel=1e-5)
    outside = sparsurf.residues(sparsurf.surface(PROTEIN, cavities="remove")).set_index(dense.index)
    assert np.array_equal(ours["mean_roughness"], outside.loc[area.index, "mean_roughness"])
    mesh = sparsurf.mesh(PROTEIN, 1024, fields="roughness")
    vertices = sparsurf.residues(mesh).set_index(dense.index).loc[area.index]
    assert np.corrcoef(vertices["area"], exposed["area"])[0, 1] > 0.95
    assert np.abs(vertices["mean_roughness"] - exposed["mean_roughness"]).mean() < 0.05


def test_points_of_spheres_have_atoms_and_no_labels():
    few = sparsurf.points(([[0.0, 0, 0], [3, 0, 0]], [1.5, 1.5]), 50, fields="roughness")
    assert np.array_equal(few.atom, few.points[:, 0] > 1.5) and list(few.to_frame())[7:] == [
        "kind",
        "atom",
        "roughness",
    ]
    with pytest.raises(InputError, match="field hydropathy follows"):
        sparsurf.points(([[0.0, 0, 0]], [1.5]), 5, fields="hydropathy")


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_folder_gives_the_points_of_each_structure(folder, jobs, tmp_path, monkeypatch):
    monkeypatch.setattr(checkpoints, "WAITING_PER_JOB", 1)  # so that few structures make a queue
    (tmp_path / "c.pdb").write_text("nothing")
    for path in folder.iterdir():
        (tmp_path / path.name).write_text(path.read_text())
    results = list(sparsurf.points_of(tmp_path, 50, jobs=jobs, seed=3))
    assert [name for name, *_ in results] == ["a", "b"]
    for result in results:
        name, points, normals = result
        alone = sparsurf.points(folder / f"{name}.pdb", 50, seed=3)
        assert np.array_equal(alone[0], points) and np.array_equal(alone[1], normals)
        assert result.points is points and result.normals is normals
        pd.testing.assert_frame_equal(result.to_frame(), alone.to_frame())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"radii": "vdw"}, "radii is 'vdw'"),
        ({"n_dots": -16}, "n_dots is -16"),
        ({"n_dots": 16, "density": 1.0}, "either n_dots"),
        ({"fields": "rougness"}, "no field 'rougness'; did you mean 'roughness'"),
        ({"cavities": "drop"}, "cavities is 'drop'"),
        ({"jobs": 0}, "jobs is 0"),
        ({"jobs": 1.5}, "jobs is 1.5"),
    ],
)
def test_arguments_are_checked_before_any_structure_is_read(folder, arguments, words):
    with pytest.raises(InputError, match=words):
        sparsurf.points_of(folder, **arguments)


@pytest.mark.parametrize("jobs", [1, 2])
def test_warnings_of_a_folder_are_summed_up_at_its_end(folder, jobs, tmp_path, caplog):
    (tmp_path / "c.pdb").write_text("nothing")
    water = "HETATM 9999  O   HOH A 999      80.000  80.000  80.000  1.00  0.00           O\n"
    for name in ("a", "b", "d"):
        atoms = (folder / f"{'a' if name == 'd' else name}.pdb").read_text()
        cut = [line for line in atoms.splitlines(True) if " CB " not in line] if name != "b" else [atoms]
        (tmp_path / f"{name}.pdb").write_text(water + "".join(cut))
    results = sparsurf.points_of(tmp_path, 20, jobs=jobs)
    assert len(list(results)) == 3 and list(results.failures) == ["c"]
    lines = [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]
    assert len(lines) == 2
    assert lines[0].startswith("2 of 4")
    assert lines[-1].startswith("1 of 4") and "c.pdb" in lines[-1]


def test_a_structure_counts_once_for_all_its_warnings_of_a_kind(tmp_path, caplog):
    parts = [peptide(chain=chain, origin=(0, 9.0 * k, 0)) for k, chain in enumerate("AABB")]
    for name in ("a", "b"):
        write(tmp_path / f"{name}.pdb", "TER\n".join(parts) + "END\n")
    assert len(list(sparsurf.points_of(tmp_path, 20))) == 2
    assert "2 of 2" in caplog.text


def test_a_list_of_files_gives_the_points_of_each_in_its_order(folder, tmp_path, capfd):
    parquet = pytest.importorskip("pyarrow.parquet")
    files = [folder / "b.pdb", folder / "a.pdb"]
    results = list(sparsurf.points_of(files, 40))
    assert [few.name for few in results] == ["b", "a"]
    of_folder = {few.name: few for few in sparsurf.points_of(folder, 40)}
    assert all(np.array_equal(few.points, of_folder[few.name].points) for few in results)

    def ended(*words, output="y.parquet"):
        return command.main(["points", *map(str, [*files, *words]), "-n", "40", "-o", str(tmp_path / output)])

    assert ended(output="x.parquet") == 0
    assert parquet.read_table(tmp_path / "x.parquet")["name"].to_pylist() == ["b"] * 40 + ["a"] * 40
    for wrong, output, sentence in (
        ([folder / "no.pdb"], "y.parquet", "no.pdb; name a folder of structures, or a list"),
        (["--trajectory", "A"], "y.parquet", "--trajectory has no meaning for the list of files"),
        ([], "y.npz", "name a file that ends in .parquet"),
    ):
        assert ended(*wrong, output=output) == 1 and sentence in capfd.readouterr().err
    with pytest.raises(InputError, match="files holds"):
        sparsurf.points_of([])


def test_folders_of_structures(folder, tmp_path):
    with pytest.raises(InputError, match="holds no structure"):
        list(sparsurf.points_of(tmp_path))
    pytest.importorskip("pyarrow")
    output = tmp_path / "points.parquet"
    assert command.main(["points", str(folder), "-n", "40", "-o", str(output)]) == 0
    table = pd.read_parquet(output)
    assert (
        list(table) == ["name", *POSITIONS, "kind", *LABELS] and (table[POSITIONS].dtypes == np.float32).all()
    )
    expected = [(name, np.hstack(arrays)) for name, *arrays in sparsurf.points_of(folder, 40)]
    assert np.array_equal(table[POSITIONS[:6]], np.concatenate([rows for _, rows in expected]))
    assert table["name"].tolist() == [name for name, rows in expected for _ in rows]


def test_the_table_of_a_folder_has_the_columns_of_to_frame(folder, tmp_path, monkeypatch, capfd):
    parquet = pytest.importorskip("pyarrow.parquet")
    monkeypatch.setattr(checkpoints, "ROWS_PER_GROUP", 50)  # a group of two structures, and one of the last
    (tmp_path / "c.pdb").write_text("nothing")
    (tmp_path / "d.pdb").write_text((folder / "b.pdb").read_text())
    for path in folder.iterdir():
        (tmp_path / path.name).write_text(path.read_text())
    for jobs in ("1", "2"):
        words = ["-n", "40", "--fields", "roughness,hydropathy", "--jobs", jobs]
        assert command.main(["points", str(tmp_path), *words, "-o", str(tmp_path / f"{jobs}.parquet")]) == 0
        assert ": 3 structures in 1 folder, 120 rows; left out: c\n" in capfd.readouterr().err
    assert (tmp_path / "1.parquet").read_bytes() == (tmp_path / "2.parquet").read_bytes()
    table = pd.read_parquet(tmp_path / "1.parquet")
    expected = [
        few.to_frame() for few in sparsurf.points_of(tmp_path, 40, fields=["roughness", "hydropathy"])
    ]
    pd.testing.assert_frame_equal(
        table.drop(columns="name"), pd.concat(expected, ignore_index=True), check_dtype=False
    )
    assert table["name"].tolist() == [name for name in "abd" for _ in range(40)]
    assert command.main(["points", str(folder / "b.pdb"), *words[:4], "-o", str(tmp_path / "b.parquet")]) == 0
    of_b = table[table["name"] == "b"].reset_index(drop=True)
    pd.testing.assert_frame_equal(pd.read_parquet(tmp_path / "b.parquet"), of_b)  # of one structure alone
    failures = json.loads(parquet.read_metadata(tmp_path / "1.parquet").metadata[b"failures"])
    assert list(failures) == ["c"] and "c.pdb" in failures["c"]


def read_with_polars(polars, path):
    return polars.read_parquet(path).to_dict(as_series=False)


def read_with_duckdb(duckdb, path):
    columns = duckdb.sql(f"select * from '{path}'").fetchnumpy()
    return {name: np.asarray(values).tolist() for name, values in columns.items()}


@pytest.mark.parametrize("read", [read_with_polars, read_with_duckdb])
def test_other_programs_read_the_table(read, folder, tmp_path):
    """Polars and DuckDB find the columns and the values of pandas."""
    pytest.importorskip("pyarrow")
    reader = pytest.importorskip(read.__name__.removeprefix("read_with_"))
    output = tmp_path / "points.parquet"
    fields = "roughness,mean_curvature,hbond"
    assert command.main(["points", str(folder), "-n", "40", "--fields", fields, "-o", str(output)]) == 0
    found, table = read(reader, output), pd.read_parquet(output)
    assert list(found) == list(table) and found["residue"] == table["residue"].tolist()
    for name in ("x", "nz", "area", "atom", *fields.split(",")):
        assert np.array_equal(np.array(found[name], table[name].dtype), table[name]), name


@pytest.mark.parametrize("suffix", ["npz", "ply"])
def test_the_command_writes_the_points_of_one_structure(folder, suffix, tmp_path):
    output = tmp_path / f"points.{suffix}"
    assert command.main(["points", str(folder / "a.pdb"), "-n", "60", "-o", str(output)]) == 0
    dots, few = sparsurf.read_surface(output), sparsurf.points(folder / "a.pdb", 60)
    assert np.allclose(dots.points, few.points, atol=1e-4)
    if suffix == "npz":
        assert np.array_equal(dots.atom, few.atom) and np.array_equal(dots.area.astype(np.float32), few.area)
        with np.load(output) as held:
            assert held["points"].dtype == held["area"].dtype == np.float32
            assert held["residue"].tolist() == few.to_frame()["residue"].tolist()
            assert not {"x", "nx"} & {*held}
    assert command.main(["points", str(folder), "-o", str(output)]) == 1


@pytest.mark.parametrize("n", [512, 2048])
def test_residues_of_points_agree_with_those_of_the_dense_surface(n):
    """Within the sampling error of n points; measured: deviations of 0.2 to 0.65 standard errors of random points."""
    path, names, residue = (
        ROOT / "data/tdp43/topology.pdb",
        ["hydropathy", "potential", "hbond"],
        ["chain", "residue"],
    )
    dots = sparsurf.surface(path, cavities="remove")
    dots = replace(dots, fields=sparsurf.fields(dots, names).to_dict("series"))
    whole = sparsurf.residues(dots).set_index(residue)
    few = sparsurf.points(path, n, fields=["roughness", *names]).to_frame().groupby(residue)
    assert {*few.groups} == {*whole.index[whole["area"] > 0]}
    deviation = few["area"].sum() - whole["area"]
    error = deviation / np.sqrt(whole["area"] * whole["area"].sum() / n)
    assert error.abs().max() < 2 and error.std() < 0.6
    spread = (
        dots.to_frame().assign(roughness=sparsurf.roughness(dots)).groupby(residue).std(numeric_only=True)
    )
    for name in ("roughness", *names):
        deviation = few[name].mean() - whole[f"mean_{name}"]
        error = (deviation / (spread[name] / np.sqrt(few.size()))).dropna()  # of a constant
        assert deviation.drop(error.index).abs().max() < 1e-6 or len(error) == len(whole)
        assert (error.abs() < 2).mean() > 0.95 and abs(error.mean()) < 0.25 and error.std() < 0.8, name
