"""The page on networks: its code runs as typed, and its files have what the readers of other programs need."""

import gzip
import os
import re
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree

import sparsurf
from conftest import ROOT
from peptides import peptide
from sparsurf.dot_fields.named_fields import HYDROPATHY
from sparsurf.surfaces.read_surface import read_surface

pytest.importorskip("pyarrow")
CHAINS = Path(os.environ.get("SPARSURF_SHARED", ROOT.parent / "shared")) / "data" / "chains"
N_CHAINS = 3
SAVE = """
import pickle
pickle.dump([data[k] for k in range(len(data))], open("data.pickle", "wb"))
assert all(part.flags.writeable for part in data[0])  # of a read-only array, PyTorch warns
by_residue.rename("mean").to_csv("by_residue.csv")
"""


def structures():
    """Small chains where they are at hand, else the structure of the repository."""
    chains = sorted(CHAINS.glob("*.gz"), key=lambda path: (path.stat().st_size, path.name))
    return chains[:N_CHAINS] or [ROOT / "data" / "tdp43" / "topology.pdb"]


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """The folder in which all code of the page was run, with chains L, H and G that lie side by side in this order."""
    folder = tmp_path_factory.mktemp("learning")
    (folder / "chains").mkdir()
    for path in structures():
        shutil.copy(path, folder / "chains")
    first = sorted((folder / "chains").iterdir())[0]
    content = first.read_bytes()
    (folder / "protein.pdb").write_bytes(gzip.decompress(content) if first.suffix == ".gz" else content)
    text = (ROOT / "docs" / "learning.md").read_text(encoding="utf-8")
    code = re.findall(r"^```python\n(.*?)^```", text, re.M | re.S)
    code = [block for block in code if "torch" not in block or find_spec("torch")]
    chains = (peptide(chain=chain, origin=(0, 5 * k, 0)) for k, chain in enumerate("LHG"))
    (folder / "fab_antigen.pdb").write_text("TER\n".join(chains) + "END\n", encoding="utf-8")
    two = (peptide(chain=chain, origin=(0, 5 * k, 0)) for k, chain in enumerate("AB"))
    (folder / "dimer.pdb").write_text("TER\n".join(two) + "END\n", encoding="utf-8")
    commands = re.findall(r"^```bash\nsparsurf (.*?)^```", text, re.M | re.S)
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    calls = [["-m", "sparsurf", *command.split()] for command in commands]
    for words in (*calls, ["-c", "\n".join([*code, SAVE])]):
        run = subprocess.run(
            [sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True, check=False
        )
        assert run.returncode == 0, run.stdout + run.stderr
    return folder


def test_the_data_set_has_the_points_of_the_first_group_with_labels_of_the_interface(done):
    names = ["roughness", "hydropathy", "potential", "hbond", "mean_curvature"]
    examples = pd.read_pickle(done / "data.pickle")
    assert len(examples) == 2
    for (position, features, label), (file, chains, groups) in zip(
        examples, (("fab_antigen.pdb", "H,L", "H,L+G"), ("dimer.pdb", "A", "A+B")), strict=True
    ):
        assert position.dtype == features.dtype == label.dtype == np.float32
        few = sparsurf.points(sparsurf.read_molecule(done / file, chains=chains), 1024, fields=names)
        assert np.array_equal(position, few.points) and np.array_equal(features[:, :3], few.normals)
        for k, name in enumerate(names):
            assert np.array_equal(features[:, 3 + k], few.fields[name]), name
        areas = sparsurf.areas(done / file, groups=groups)
        untouched = np.flatnonzero(areas.buried[: len(few.molecule.name)] == 0)
        on_contact = (few.surface.kind == 0) & np.isin(few.atom, untouched)
        assert on_contact.any() and not label[on_contact].any() and 0.02 < label.mean() < 0.5
    first = sparsurf.points(
        sparsurf.read_molecule(done / "fab_antigen.pdb", chains="H,L"), 1024, fields=names
    )
    mean = first.to_frame().groupby(["chain", "residue"], sort=False)["roughness"].mean()
    assert pd.read_csv(done / "by_residue.csv")["mean"].to_numpy() == pytest.approx(mean, abs=1e-5)
    table = pd.read_parquet(done / "points.parquet")
    assert table["name"].nunique() == len(structures()) and len(table) == 1024 * len(structures())


def test_the_ply_follows_the_rules_of_the_readers_of_masif_and_dmasif(done):
    """Text; every number of a vertex belongs to a property of the type float; single blanks; triangles of three numbers."""
    head, body = (done / "fab.ply").read_text(encoding="ascii").split("end_header\n")
    lines = head.splitlines()
    assert lines[:2] == ["ply", "format ascii 1.0"] and "property list uchar int vertex_indices" in lines
    n, f = (int(line.split()[2]) for line in lines if line.startswith("element"))
    names = [line.split(" ")[2] for line in lines if line.startswith("property float ")]
    assert len(names) == sum(line.startswith("property") for line in lines) - 1
    assert names[:6] == ["x", "y", "z", "nx", "ny", "nz"]
    rows = body.splitlines()
    assert len(rows) == n + f
    values = np.array([[float(number) for number in row.split(" ")] for row in rows[:n]])
    triangles = np.array([[int(number) for number in row.split(" ")] for row in rows[n:]])
    vertices = dict(zip(names, values.T, strict=True))
    assert (triangles[:, 0] == 3).all() and {*triangles[:, 1:].ravel()} == {*range(n)}
    dots = sparsurf.surface(done / "fab_antigen.pdb", groups="H,L+G", cavities="remove")
    mesh = sparsurf.mesh(dots, 4096, fields=["potential", "hbond", "hydropathy", "burial"])
    for field, name, unit in (
        ("potential", "charge", 0.1),
        ("hbond", "hbond", 1),
        ("hydropathy", "hphob", 1),
    ):
        expected = unit * mesh.vertices.fields[field]
        assert vertices[name] == pytest.approx(expected, rel=1e-5, abs=1e-5)
    clipped = np.mean(
        np.abs(vertices["charge"]) > 3
    )  # as both programs do, which must not flatten the potential
    assert clipped < 0.1
    assert np.abs(vertices["hbond"]).max() == 1 and {*vertices["iface"]} == {0, 1}
    assert np.array_equal(vertices["iface"], mesh.vertices.fields["burial"] > 1e-6)


def test_values_have_the_units_and_ranges_of_masif(done):
    """MaSIF's hydropathy is that of the residue of the nearest atom; its charge is clipped at 3 and its hbond lies within 1."""
    molecule = sparsurf.read_molecule(done / "protein.pdb")
    mesh = sparsurf.mesh(molecule, density=1.0, fields=["potential", "hbond", "hydropathy"])
    fields, atom = mesh.vertices.fields, mesh.vertices.atom
    own = np.array([HYDROPATHY.get(name, 0.0) for name in molecule.residue_name])[atom]
    assert 0.75 < np.corrcoef(fields["hydropathy"], own)[0, 1] < 0.95
    assert np.abs(fields["hydropathy"]).max() <= 4.5 and np.abs(fields["hbond"]).max() <= 1
    assert (np.abs(fields["potential"] / 10) > 3).mean() < 0.1 < (np.abs(fields["potential"]) > 3).mean()


def test_no_mesh_of_the_page_has_the_wall_of_a_cavity(done):
    """On a structure that has cavities, by the call of the page."""
    protein = ROOT / "data" / "tdp43" / "topology.pdb"
    mesh = sparsurf.mesh(protein, n_vertices=4096)
    dots = sparsurf.surface(protein)
    component, table = sparsurf.components(dots)
    assert table["cavity"].sum() == 4
    walls = dots.points[(component == 1) & (dots.kind == 0)]  # of the largest cavity
    assert cKDTree(mesh.vertices.points).query(walls)[0].min() > 1
    with np.load(done / "fab.npz") as held:
        assert len(held["verts"]) == 4096


def test_plyfile_finds_what_dmasif_asks_for(done):
    plyfile = pytest.importorskip("plyfile")
    found = plyfile.PlyData.read(done / "fab.ply")
    assert np.vstack(found["face"].data["vertex_indices"]).shape[1] == 3
    for name in ("nx", "ny", "nz", "iface", "charge", "hbond", "hphob"):
        assert np.isfinite(found["vertex"][name]).all()


def test_burial_labels_the_points_that_the_antigen_covers(done):
    """Chains lie side by side in the order L, H, G: points of L, and those of H that face L, are not buried."""
    with np.load(done / "points.npz") as held:
        y, burial = held["points"][:, 1], held["burial"]
    covered = burial > 1e-6
    assert burial.min() >= 0 and 0.02 < covered.mean() < 0.5
    assert y[covered].min() > np.median(y)


def test_the_npz_is_a_closed_mesh_with_exact_normals(done):
    with np.load(done / "fab.npz") as held:
        verts, faces, normals = held["verts"], held["faces"], held["normals"]
    assert verts.dtype == normals.dtype == np.float32 and faces.dtype == np.int32
    assert verts.shape == normals.shape and faces.shape[1] == 3
    edges = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    back = {*map(tuple, edges[:, ::-1].tolist())}
    assert back == {*map(tuple, edges.tolist())} and len(back) == len(edges)
    again = read_surface(done / "fab.ply")
    assert again.points == pytest.approx(verts, abs=6e-5) and again.normals == pytest.approx(
        normals, abs=6e-5
    )
