"""Atoms that users hold in other libraries give the same surface as the file, wherever a molecule is taken."""

import shutil
import subprocess
import sys
from dataclasses import replace

import gemmi
import numpy as np
import pytest

import sparsurf
from conftest import ROOT
from peptides import peptide
from sparsurf.api.inputs import as_molecule
from sparsurf.errors import InputError

PEPTIDE = ROOT / "data" / "tdp43" / "topology.pdb"
TRAJECTORY = ROOT / "data" / "tdp43" / "trajectory.xtc"


def of_biotite():
    pytest.importorskip("biotite", reason="biotite is installed by the extra `interop`")
    from biotite.structure.io.pdb import PDBFile

    return PDBFile.read(str(PEPTIDE)).get_structure(model=1, extra_fields=["b_factor"])


@pytest.fixture(scope="module")
def dots():
    return sparsurf.surface(PEPTIDE)


def test_every_function_takes_them(dots, tmp_path):
    atoms = gemmi.read_structure(str(PEPTIDE))
    assert np.array_equal(sparsurf.roughness(atoms), sparsurf.roughness(dots))
    assert np.array_equal(sparsurf.descriptors(atoms, [0, 9]), sparsurf.descriptors(dots, [0, 9]))
    kept = sparsurf.sample(atoms, percent=5)
    assert np.array_equal(kept, sparsurf.sample(dots, percent=5))
    assert np.array_equal(sparsurf.minimal(atoms, percent=5).dots, kept)
    assert sparsurf.components(atoms)[1].equals(sparsurf.components(dots)[1])
    table = sparsurf.fields(atoms, dots, ["hydropathy"])
    assert np.allclose(table, sparsurf.fields(dots, ["hydropathy"]), atol=1e-4)
    assert len(sparsurf.residues(atoms)) == 61
    sparsurf.write(sparsurf.surface((dots.points[:1], [1.9])), tmp_path / "one.csv")
    assert sparsurf.prepare(atoms).patches.d_link == 0.5


def test_models_and_frames_of_another_library(dots, tmp_path):
    mdanalysis = pytest.importorskip("MDAnalysis", reason="MDAnalysis is installed by the extra `interop`")
    copy = shutil.copy(TRAJECTORY, tmp_path)  # MDAnalysis writes a file of offsets next to it
    universe = mdanalysis.Universe(str(PEPTIDE), str(copy))
    universe.trajectory[500]
    molecule = sparsurf.read_molecule(PEPTIDE, TRAJECTORY, stride=500)
    surface = sparsurf.surface(universe)  # the current frame
    assert np.array_equal(surface.points, sparsurf.surface(molecule, frame=1).points)
    assert surface.origin.molecule.time_ps == molecule.time_ps[1]
    biotite = pytest.importorskip("biotite.structure", reason="biotite is installed by the extra `interop`")
    stack = biotite.stack([of_biotite(), of_biotite()])
    assert np.array_equal(sparsurf.surface(stack, frame=1).points, dots.points)
    with pytest.raises(InputError, match="the molecule has the frames 0 to 1: there is no frame 2"):
        sparsurf.surface(stack, frame=2)


MODEL = """\
MODEL        {}
ATOM      1  N  AALA     5A     {}1.000  12.000  13.000  0.40  7.00           N
ATOM      2  N  BALA     5A     {}1.500  12.000  13.000  0.60  8.00           N
ATOM      3  CA  ALA     5A     {}2.400  12.400  13.200  1.00  9.00           C
HETATM    4  O   HOH     6      40.000  12.400  13.200  1.00  9.00           O
ENDMDL
"""
MODELS = MODEL.format(1, 1, 1, 1) + MODEL.format(2, 2, 2, 2) + "END\n"


@pytest.mark.parametrize("library", ["gemmi", "Biopython"])
def test_models_locations_and_labels_of_gemmi_and_biopython(library, tmp_path):
    path = tmp_path / "models.pdb"
    path.write_text(MODELS)
    if library == "gemmi":
        structure = gemmi.read_structure(str(path))
    else:
        parser = pytest.importorskip(
            "Bio.PDB", reason="Biopython is installed by the extra `interop`"
        ).PDBParser
        structure = parser(QUIET=True).get_structure("models", str(path))
    molecule, expected = as_molecule(structure), sparsurf.read_molecule(path)
    assert molecule.xyz.shape == (2, 2, 3) and np.allclose(molecule.xyz, expected.xyz, atol=1e-5)
    assert molecule.xyz[0, 0, 0] == 11 and molecule.b_factor.tolist() == [7, 9]  # the first location
    for name in ("name", "residue_name", "chain", "element", "residue", "kind"):
        assert getattr(molecule, name).tolist() == getattr(expected, name).tolist(), name
    assert molecule.chain.tolist() == ["", ""] and molecule.residue[0] == "5A"
    assert as_molecule(structure[0]).n_frames == 1
    with pytest.raises(InputError, match="has no atoms"):
        as_molecule(gemmi.Structure() if library == "gemmi" else structure.__class__("empty"))


METHANOL = """

  of a library
  2  1  0  0  0  0  0  0  0  0999 V2000
    0.0000    0.0000    0.0000 C   0  0  0  0  0  0  0  0  0  0  0  0
    1.4300    0.0000    0.0000 O   0  0  0  0  0  0  0  0  0  0  0  0
  1  2  1  0
M  END
"""


def of_prody(path):
    prody = pytest.importorskip("prody", reason="ProDy is not installed")
    prody.confProDy(verbosity="none")
    return prody.parsePDB(str(path)).select("all")


def of_openmm(path):
    app = pytest.importorskip("openmm.app", reason="OpenMM is not installed")
    return app.PDBFile(str(path))


def of_parmed(path):
    return pytest.importorskip("parmed", reason="ParmEd is not installed").load_file(str(path))


def of_rdkit(path):
    chem = pytest.importorskip("rdkit.Chem", reason="RDKit is not installed")
    return chem.MolFromPDBFile(str(path), removeHs=False, sanitize=False)


@pytest.mark.parametrize("held", [of_prody, of_openmm, of_parmed, of_rdkit])
def test_atoms_and_models_of_libraries_that_simulate_and_draw(held, tmp_path):
    path = tmp_path / "models.pdb"
    models = (peptide(["ALA", "LYS", "GLY"], "B", 9, origin=(8 * k, 0, 0)) for k in range(2))
    path.write_text(
        "".join(f"MODEL        {k}\n{model}ENDMDL\n" for k, model in enumerate(models, 1)) + "END\n"
    )
    molecule, expected = as_molecule(held(path)), sparsurf.read_molecule(path)
    assert molecule.xyz.shape == expected.xyz.shape and np.allclose(molecule.xyz, expected.xyz, atol=1e-5)
    for name in ("name", "residue_name", "chain", "element", "residue", "kind"):
        assert getattr(molecule, name).tolist() == getattr(expected, name).tolist(), name


def test_a_mol_without_residues_is_taken_whole_and_without_conformers_refused():
    chem = pytest.importorskip("rdkit.Chem", reason="RDKit is not installed")
    mol = chem.MolFromMolBlock(METHANOL)
    assert as_molecule(mol).name.tolist() == ["C1", "O2"] and sparsurf.areas(mol).accessible.sum() > 100
    mol.RemoveAllConformers()
    with pytest.raises(InputError, match="Mol of RDKit"):
        sparsurf.surface(mol)


def test_parts_and_broken_atoms_of_another_library():
    array = of_biotite()
    part = sparsurf.surface(array[array.res_id < 215])
    assert len(part) == len(sparsurf.surface(sparsurf.read_molecule(PEPTIDE, residues="209-214")))
    with pytest.raises(InputError, match="the AtomArray has 1 frames of 0 atoms"):
        sparsurf.surface(array[:0])
    array.coord[3] = np.nan
    with pytest.raises(InputError, match="AtomArray has coordinates"):
        sparsurf.surface(array)


def test_what_functions_give_is_shown_in_a_line_and_behaves_like_an_array(dots):
    few = sparsurf.minimal(dots, percent=5)
    ready = sparsurf.prepare(dots)
    for value, words in (
        (dots, "Surface of 24,600 dots"),
        (dots.origin.molecule, "Molecule of 953 atoms in 61 residues, 1 frame"),
        (few, "Subset of 1,230 dots of 24,600"),
        (ready, "PreparedSurface of 24,600 dots"),
    ):
        assert repr(value) == words
    assert np.array_equal(np.asarray(dots), dots.points)
    assert np.array(dots, dtype=np.float32).dtype == np.float32 and np.asarray(few).shape == (1230, 3)
    assert np.array_equal(dots[few.dots].points, few.points) and len(few) == 1230
    assert np.array_equal(dots[few.dots].normals, few.normals)
    assert len(dots[5]) == 1 and len(dots[:10]) == 10 and len(dots[dots.points[:, 0] > 50]) < len(dots)
    with pytest.raises(IndexError):
        dots[24_600]


def test_a_subset_is_taken_where_dots_are(dots, tmp_path):
    few = sparsurf.minimal(dots, percent=5)
    table = sparsurf.compare(dots, {"subset": few, "dots": few.dots}, test_dots=20)
    assert table.loc["subset"].equals(table.loc["dots"])
    with pytest.raises(InputError, match="other dots"):
        sparsurf.compare(dots, replace(few, dots=few.dots[::-1]))
    by_dots = sparsurf.residues(dots, kept=few.dots, weight=few.weight)
    assert sparsurf.residues(dots, kept=few).equals(by_dots)
    sparsurf.write(few, tmp_path / "few.csv")
    assert np.allclose(sparsurf.read_surface(tmp_path / "few.csv").points, few.points, atol=1e-4)
    assert len(sparsurf.recover(few)) > len(few)


CHECK = """
import logging, os, sys, warnings
before = dict(os.environ), list(warnings.filters), list(logging.getLogger().handlers), set(sys.modules)
import sparsurf
assert (dict(os.environ), list(warnings.filters), list(logging.getLogger().handlers)) == before[:3]
print(*sorted(name for name in set(sys.modules) - before[3] if "." not in name and not name.startswith("_")))
import inspect, pydoc
assert all(callable(getattr(sparsurf, name)) for name in sparsurf.__all__ if name != "__version__")
text = pydoc.plain(pydoc.render_doc(sparsurf))
assert "sample(surface" in "".join(text.split()) and "Choose a subset of dots by a sampler" in text
"""


def test_the_import_is_cheap_and_changes_nothing():
    run = subprocess.run(
        [sys.executable, "-c", CHECK], cwd=ROOT / "src", capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    assert not {"numpy", "pandas", "numba", "mdtraj", "scipy", "gemmi"} & set(run.stdout.split())
