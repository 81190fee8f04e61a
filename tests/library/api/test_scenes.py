"""Files for PyMOL and ChimeraX: what they hold, as those programs read it."""

import os
import shutil
import subprocess
from dataclasses import replace
from types import SimpleNamespace

import gemmi
import numpy as np
import pytest

import sparsurf
from conftest import ROOT
from peptides import peptide
from sparsurf import Surface
from sparsurf.errors import InputError
from sparsurf.surfaces.formats.colours import KIND_COLOURS, scale_of
from sparsurf_study.report.scenes import script_text

PEPTIDE = ROOT / "data" / "tdp43" / "topology.pdb"


@pytest.fixture(scope="module")
def few():
    return sparsurf.minimal(sparsurf.read_molecule(PEPTIDE, residues="209-214"), n_dots=40)


def in_pymol(path):
    """Run a script as PyMOL runs it: its Python blocks with `cmd`; return what they load, by name, and the other lines."""
    loaded, lines, block = {}, [], None
    cmd = SimpleNamespace(
        load_cgo=lambda objects, name: loaded.setdefault(name, objects),
        read_pdbstr=lambda text, name: loaded.setdefault(name, text),
    )
    names = ("COLOR", "SPHERE", "BEGIN", "TRIANGLES", "NORMAL", "VERTEX", "END")
    cgo = SimpleNamespace(**{name: name.lower() for name in names})
    for line in path.read_text().splitlines():
        if line == "python":
            block = []
        elif line == "python end":
            exec("\n".join(block).replace("from pymol import cgo", ""), {"cmd": cmd, "cgo": cgo})
            block = None
        elif block is None:
            lines.append(line)
        else:
            block.append(line)
    return loaded, lines


def test_pymol_opens_the_dots_on_their_molecule(few, tmp_path):
    sparsurf.write(few, tmp_path / "few.pml")
    loaded, lines = in_pymol(tmp_path / "few.pml")
    spheres = np.array(loaded["dots"]).reshape(40, -1)
    assert spheres[0, :4].tolist() == ["color", "0.84", "0.37", "0.0"] and spheres[0, 8] == "0.3"
    assert np.abs(spheres[:, 5:8].astype(float) - few.points).max() <= 0.0005
    structure = gemmi.read_pdb_string(loaded["structure"])
    assert structure[0].count_atom_sites() == few.surface.origin.molecule.n_atoms
    assert lines == ["hide everything, structure", "show cartoon, structure", "bg_color white", "orient"]


def test_a_real_pymol_opens_names_that_mean_something_to_it(tmp_path):
    if shutil.which("pymol") is None:
        pytest.skip("the program pymol is not installed")
    text = peptide(["GLY", "ALA"]).replace("  CB  ALA A", '  """ ALA A').replace(" A  ", " \\  ")
    (tmp_path / "named.pdb").write_text(text + "END\n")
    molecule = sparsurf.read_molecule(tmp_path / "named.pdb")
    sparsurf.write(sparsurf.minimal(molecule, n_dots=40), tmp_path / "few.pml")
    dots = sparsurf.surface(molecule)
    coloured = replace(dots, fields={"potential": dots.points[:, 0]})
    sparsurf.write(coloured, tmp_path / "coloured.pml")
    molecule.write_pdb(tmp_path / "structure_roughness.pdb")
    (tmp_path / "minimal.csv").write_text("x,y,z\n1,2,3\n")
    (tmp_path / "residues.csv").write_text(
        "chain,residue,mean_roughness,mean_all,mean_structure\n\\,1,1,1,1\n"
    )
    (tmp_path / "open.pml").write_text(script_text("open.pml"))
    seen = "print('SEEN', sorted(cmd.get_names()), cmd.count_atoms('{}'), cmd.get_chains('{}'))"
    path = os.pathsep.join(["/usr/bin", os.environ["PATH"]])  # Debian's own python runs it
    environment = {"env": os.environ | {"PATH": path}, "cwd": tmp_path}
    for script, name, names in (
        ("few.pml", "structure", ["dots", "structure"]),
        ("coloured.pml", "structure", ["dots", "potential", "structure"]),
        ("open.pml", "mean_all", ["mean_all", "mean_structure", "minimal", "structure"]),
    ):
        command = ["pymol", "-ckq", script, "-d", seen.replace("{}", name)]
        said = subprocess.run(command, **environment, capture_output=True, text=True, timeout=100, check=True)
        assert f"SEEN {names} {molecule.n_atoms} ['\\\\']\n" in said.stdout


def test_a_molecule_that_is_given_is_drawn_where_the_dots_know_none(tmp_path):
    molecule = sparsurf.read_molecule(PEPTIDE, residues="209-214")
    dots = sparsurf.surface(molecule)
    few = sparsurf.minimal((dots.points, dots.normals), n_dots=40)
    assert few.surface.origin is None
    for result in (few, sparsurf.mesh(few)):
        sparsurf.write(result, tmp_path / "few.pml", molecule=molecule)
        structure = gemmi.read_pdb_string(in_pymol(tmp_path / "few.pml")[0]["structure"])
        assert structure[0].count_atom_sites() == molecule.n_atoms
        with pytest.raises(InputError, match=r"written as '\.dms'"):
            sparsurf.write(result, tmp_path / "few.dms", molecule=molecule)


def test_a_mesh_has_its_triangles_in_pymol_and_chimerax(tmp_path):
    mesh = sparsurf.mesh(([[0.0, 0, 0], [3, 0, 0]], [1.5, 1.5]), density=1)
    sparsurf.write(mesh, tmp_path / "mesh.pml")
    loaded, _ = in_pymol(tmp_path / "mesh.pml")
    assert loaded["mesh"][:2] == ["begin", "triangles"] and loaded["mesh"][-1] == "end"
    corners = np.array(loaded["mesh"][2:-1]).reshape(-1, 12)
    expected = mesh.vertices.points[mesh.triangles.ravel()]
    assert np.abs(corners[:, 9:].astype(float) - expected).max() <= 0.0005
    normals = mesh.vertices.normals[mesh.triangles.ravel()]
    assert np.abs(corners[:, 5:8].astype(float) - normals).max() <= 0.005
    assert len(np.unique(corners[:, 1:4], axis=0)) == 1  # one colour without a field
    with_field = replace(mesh, vertices=replace(mesh.vertices, fields={"height": mesh.vertices.points[:, 0]}))
    sparsurf.write(with_field, tmp_path / "field.pml")
    coloured = np.array(in_pymol(tmp_path / "field.pml")[0]["mesh"][2:-1]).reshape(-1, 12)
    shades = scale_of("height", mesh.vertices.points[:, 0]).colours[mesh.triangles.ravel()] / 255
    assert np.abs(coloured[:, 1:4].astype(float) - shades).max() <= 0.005
    sparsurf.write(with_field, tmp_path / "field.bild")
    assert (tmp_path / "field.bild").read_text().count(".color") > 10
    sparsurf.write(mesh, tmp_path / "mesh.bild")
    lines = (tmp_path / "mesh.bild").read_text().splitlines()
    polygons = np.array([line.split()[1:] for line in lines[1:]], float)
    assert np.abs(polygons.reshape(-1, 3) - expected).max() <= 0.0005


def test_chimerax_opens_what_lies_next_to_the_script(few, tmp_path):
    sparsurf.write(few, tmp_path / "few.cxc")
    sparsurf.write(few, tmp_path / "so few.cxc")
    assert '\nopen "so few_molecule.pdb"\n' in (tmp_path / "so few.cxc").read_text()
    opened = [
        line.split()[1] for line in (tmp_path / "few.cxc").read_text().splitlines() if line.startswith("open")
    ]
    assert opened == ["few_molecule.pdb", "few_dots.bild"]
    assert (
        gemmi.read_structure(str(tmp_path / "few_molecule.pdb"))[0].count_atom_sites()
        == few.surface.origin.molecule.n_atoms
    )
    lines = (tmp_path / "few_dots.bild").read_text().splitlines()
    assert lines[0] == ".color 0.84 0.37 0" and len(lines) == 41  # the colour once
    assert lines[1] == ".sphere {:.3f} {:.3f} {:.3f} 0.3".format(*few.points[0])


def test_a_scene_of_chimerax_replaces_no_file_but_its_own(tmp_path):
    molecule = sparsurf.read_molecule(PEPTIDE, residues="209-214")
    for name in ("mine.pdb", "mine.bild", "other_molecule.pdb"):
        sparsurf.write(molecule, tmp_path / "all.pdb")
        (tmp_path / "all.pdb").rename(tmp_path / name)
    before = (tmp_path / "mine.pdb").read_bytes()
    few = sparsurf.minimal(sparsurf.read_molecule(tmp_path / "mine.pdb", residues="209-212"), n_dots=40)
    for _ in range(2):  # its own files are replaced
        sparsurf.write(few, tmp_path / "mine.cxc")
    read = sparsurf.read_molecule(tmp_path / "mine_molecule.pdb")
    assert read.n_atoms == few.surface.origin.molecule.n_atoms < molecule.n_atoms
    (tmp_path / "other.cxc").write_text("# of the user\nopen other_molecule.pdb\n")
    with pytest.raises(InputError, match=r"other_molecule\.pdb, .* exists"):
        sparsurf.write(few, tmp_path / "other.cxc")
    assert {(tmp_path / name).read_bytes() for name in ("mine.pdb", "mine.bild", "other_molecule.pdb")} == {
        before
    }
    assert not (tmp_path / "other_dots.bild").exists()


def test_dots_are_atoms_of_a_pdb_with_their_weight_or_field(few, tmp_path):
    sparsurf.write(few, tmp_path / "few.pdb")
    atoms = [site.atom for site in gemmi.read_structure(str(tmp_path / "few.pdb"))[0].all()]
    assert [atom.b_iso for atom in atoms] == few.weight.tolist()
    assert np.abs([atom.pos.tolist() for atom in atoms] - few.points).max() <= 0.0005
    n = 10_001  # more residues than four digits number
    normals = np.tile([0.0, 0, 1], (n, 1))
    points = np.column_stack([np.arange(n) % 100, np.arange(n) // 100, np.zeros(n)]).astype(float)
    dots = Surface(points, normals, fields={"height": np.linspace(-500, 5000, n)})
    sparsurf.write(dots, tmp_path / "dots.pdb")
    residues = gemmi.read_structure(str(tmp_path / "dots.pdb"))[0]["X"]
    assert [residue.seqid.num for residue in residues] == list(range(1, n + 1))
    assert [residues[k][0].b_iso for k in (0, n - 1)] == pytest.approx([-99.99, 999.99])  # the most that fits
    sparsurf.write(dots, tmp_path / "dots.bild")
    assert (
        len(set((tmp_path / "dots.bild").read_text().splitlines()) & {".color 0.27 0.00 0.33"}) == 1
    )  # viridis


@pytest.mark.parametrize("shift", [-1500, 20_000])
def test_positions_far_from_the_origin_stay_in_their_columns(tmp_path, shift):
    molecule = sparsurf.read_molecule(PEPTIDE, residues="209-212")
    far = replace(molecule, xyz=molecule.xyz + shift)
    dots = Surface(*(array[:50] for array in (sparsurf.surface(far).points, sparsurf.surface(far).normals)))
    for result, points in ((dots, dots.points), (far, far.xyz[0])):
        sparsurf.write(result, tmp_path / "far.pdb")
        atoms = [site.atom.pos.tolist() for site in gemmi.read_structure(str(tmp_path / "far.pdb"))[0].all()]
        assert np.abs(np.array(atoms) - points).max() <= 0.01
    for result in (
        replace(dots, points=dots.points - 12_000 - shift),
        replace(far, xyz=molecule.xyz - 12_000),
    ):
        with pytest.raises(
            InputError, match=r"does not fit into a PDB file, which holds -9999\.99 to 99999\.99"
        ):
            sparsurf.write(result, tmp_path / "farther.pdb")
    assert not (tmp_path / "farther.pdb").exists()


def test_dots_have_the_colour_of_their_kind_and_the_atoms_of_their_frame(tmp_path):
    data = PEPTIDE.parent
    molecule = sparsurf.read_molecule(PEPTIDE, data / "trajectory.xtc", residues="209-212", stride=700)
    dots = sparsurf.surface(molecule, frame=1)
    sparsurf.write(dots, tmp_path / "dots.pml")
    loaded, _ = in_pymol(tmp_path / "dots.pml")
    spheres = np.array(loaded["dots"]).reshape(len(dots), -1)
    wanted = KIND_COLOURS[dots.kind] / 255
    assert np.abs(spheres[:, 1:4].astype(float) - wanted).max() < 0.001 and len(np.unique(dots.kind)) == 3
    sparsurf.write(dots, tmp_path / "dots.cxc")
    for text in (loaded["structure"], (tmp_path / "dots_molecule.pdb").read_text()):
        atoms = [site.atom.pos.tolist() for site in gemmi.read_pdb_string(text)[0].all()]
        assert np.abs(np.array(atoms) - molecule.xyz[1]).max() < 0.001
    sparsurf.write(sparsurf.minimal(dots, n_dots=20), tmp_path / "few.pml")
    sparsurf.write(sparsurf.mesh(dots, 100), tmp_path / "mesh.pml")
    for name in ("few", "mesh"):
        text = in_pymol(tmp_path / f"{name}.pml")[0]["structure"]
        atoms = [site.atom.pos.tolist() for site in gemmi.read_pdb_string(text)[0].all()]
        assert np.abs(np.array(atoms) - molecule.xyz[1]).max() < 0.001
    sparsurf.write(molecule, tmp_path / "second.pdb", frame=1)
    atoms = [site.atom.pos.tolist() for site in gemmi.read_structure(str(tmp_path / "second.pdb"))[0].all()]
    assert np.abs(np.array(atoms) - molecule.xyz[1]).max() < 0.001
    shown = {"height": dots.points[:, 2], "other": dots.points[:, 0]}
    sparsurf.write(replace(dots, fields=shown), tmp_path / "fields.bild")
    lines = (tmp_path / "fields.bild").read_text().splitlines()
    first = next(
        k
        for k, line in enumerate(lines)
        if "{:.3f} {:.3f} {:.3f}".format(*dots.points[dots.points[:, 2].argmax()]) in line
    )
    colour = next(line for line in lines[first::-1] if line.startswith(".color"))
    assert np.abs(np.array(colour.split()[1:], float) - [0.99, 0.91, 0.14]).max() < 0.02  # the end of viridis
    flat = replace(dots, fields={"roughness": np.full(len(dots), 0.9)})
    sparsurf.write(flat, tmp_path / "flat.bild")
    key, colour, *_ = (tmp_path / "flat.bild").read_text().splitlines()
    assert key.startswith(".comment roughness: 0.2") and key.endswith(", 0.9 #fde724")
    assert np.abs(np.array(colour.split()[1:], float) - [0.99, 0.91, 0.14]).max() < 0.02  # as on all surfaces


def test_a_molecule_is_a_pdb_and_nothing_else(tmp_path):
    molecule = sparsurf.read_molecule(PEPTIDE)
    sparsurf.write(molecule, tmp_path / "molecule.pdb")
    assert np.allclose(sparsurf.read_molecule(tmp_path / "molecule.pdb").xyz, molecule.xyz)
    with pytest.raises(InputError, match=r"\.pdb, \.xyzr, \.xyzrn"):
        sparsurf.write(molecule, tmp_path / "molecule.csv")
    with pytest.raises(InputError, match="there is no folder"):
        sparsurf.write(sparsurf.surface(([[0.0, 0, 0]], [1.5])), tmp_path / "no" / "dots.bild")
