"""Atoms that determine a surface: none is missing, none is spared, and what is said of them is computed."""

import os
import subprocess
from dataclasses import replace
from shutil import which

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import sparsurf
from conftest import ROOT, sphere
from peptides import peptide, write
from sparsurf.cli import command
from sparsurf.errors import InputError
from sparsurf.surfaces.spheres import read_spheres

PEPTIDE = ROOT / "data" / "tdp43" / "topology.pdb"  # with hydrogens and four cavities
EXACT = 1e-6  # Å


@pytest.fixture(scope="module")
def molecule():
    return sparsurf.read_molecule(PEPTIDE)


@pytest.fixture(scope="module")
def few(molecule):
    return sparsurf.surface_atoms(molecule)


def heap(n=120, seed=3):
    """A heap of spheres of four radii, with some hidden in others."""
    rng = np.random.default_rng(seed)
    return (rng.normal(size=(n, 3)) * 4).round(3), rng.choice([1.2, 1.5, 1.7, 1.9], n)


def is_same_surface(some, whole):
    """Whether dots lie on both surfaces within EXACT, both ways, and the areas agree; each has the same dots."""
    ways = [cKDTree(a.points).query(b.points)[0].max() for a, b in ((some, whole), (whole, some))]
    return max(ways) < EXACT and abs(some.area.sum() / whole.area.sum() - 1) < EXACT


@pytest.mark.parametrize("probe", [0.8, 1.4, 3.0])
@pytest.mark.parametrize("atoms", ["peptide", "heap"])
def test_the_surface_of_the_atoms_is_that_of_all(molecule, atoms, probe):
    source = molecule if atoms == "peptide" else heap()
    some = sparsurf.surface_atoms(source, probe_radius=probe)
    assert some.is_exact and len(some) < len(some.spheres.radii)
    placed = [sparsurf.surface(each, probe_radius=probe, density=4.0) for each in (some, source)]
    assert is_same_surface(*placed)
    # an independent reading: just beside the probe, on the atom that the dot touches, no atom is closer
    assert set(placed[1].atom[placed[1].kind == 0].tolist()) <= set(some.atom[some.touched].tolist())


def test_each_touched_atom_owns_a_position_of_the_probe():
    """Positions around each atom, tried against every atom: those without one that is free are not touched."""
    xyz, radii = heap(60)
    some = sparsurf.surface_atoms((xyz, radii))
    directions = np.concatenate([sphere(4000)[0] @ Rotation.random(rng=k).as_matrix() for k in range(4)])
    free = []
    for atom in range(len(xyz)):
        centres = xyz[atom] + (radii[atom] + 1.4) * directions
        distance = np.linalg.norm(centres[:, None] - xyz, axis=2) - radii - 1.4
        distance[:, atom] = np.inf
        free.append((distance > 0).all(axis=1).any())
    assert some.atom[some.touched].tolist() == np.flatnonzero(free).tolist()


def test_nothing_can_be_left_out_or_changed(few):
    """The certificate is computed: it fails without any touched atom, without plugs, and with another radius or place."""
    assert few.is_exact and not few.touched.all() and few[::-1].is_exact
    every = np.arange(len(few))
    for touched in np.flatnonzero(few.touched)[::90].tolist():
        assert not few[every != touched].is_exact
    needed = [bool(few[every != plug].is_exact) for plug in np.flatnonzero(~few.touched).tolist()]
    assert not all(needed) and not few[few.touched].is_exact
    assert not sparsurf.surface_atoms(few.molecule, plugs=False).is_exact
    wider, moved = few.radii.copy(), few.centres.copy()
    wider[few.touched.argmax()] += 0.1
    moved[0] += 0.01
    assert not replace(few, radii=wider).is_exact and not replace(few, centres=moved).is_exact
    assert replace(few, radii=few.radii.copy()).is_exact
    with pytest.raises(ValueError, match="read-only"):
        few.radii[0] = 2.0


def test_larger_probes_have_their_surface_on_the_same_atoms(few, molecule):
    for probe in (1.8, 4.0):
        placed = [sparsurf.surface(each, probe_radius=probe, density=3.0) for each in (few, molecule)]
        assert is_same_surface(*placed)
    with pytest.raises(InputError, match=r"1.4 Å .*"):
        sparsurf.surface(few, probe_radius=1.2)


def test_without_cavities_their_walls_are_left_out():
    """A shell, lined with atoms that the probe touches only in the cavity; an atom floats in it."""
    inner = 5.6 * sphere(60)[0]
    xyz = np.concatenate([9.0 * sphere(200)[0], inner, [[0, 0, 0]]])
    radii = np.concatenate([np.full(260, 1.9), [1.0]])
    kept, removed = (sparsurf.surface_atoms((xyz, radii), cavities=each) for each in ("keep", "remove"))
    assert set(range(200, 260)) <= set(kept.atom.tolist())
    assert removed.atom[removed.touched].tolist() == [*range(200), 260][: removed.touched.sum()]
    assert kept.is_exact and removed.is_exact
    for few in (kept, removed):
        placed = [sparsurf.surface(each, density=4.0, cavities="remove") for each in (few, (xyz, radii))]
        # the dots of narrow saddles, and all areas, also depend on dots that are removed
        first, second = (cKDTree(dots.points[dots.kind != 1]) for dots in placed)
        assert first.n == second.n and first.query(second.data)[0].max() < EXACT
    with pytest.raises(InputError, match="cavities; pass cavities='remove'"):
        sparsurf.surface(removed)


def test_the_dots_of_the_atoms_carry_the_molecule(few, molecule):
    dots, whole = sparsurf.surface(few), sparsurf.surface(molecule)
    assert dots.molecule is molecule and dots.atom.max() > len(few)
    table = sparsurf.components(dots)[1]
    assert table["cavity"].tolist() == sparsurf.components(whole)[1]["cavity"].tolist()
    at = cKDTree(whole.points).query(dots.points)[1]
    assert (dots.atom == whole.atom[at]).mean() > 0.95  # dots in the middle of two atoms belong to either
    assert len(sparsurf.recover(few, density=3.0)) == len(sparsurf.surface(few, density=3.0))
    assert "roughest residues" in sparsurf.show(few, open_browser=False).html
    assert few.to_frame()["residue_name"].tolist() == molecule.residue_name[few.atom].tolist()
    with pytest.raises(InputError, match="reach, steps"):
        sparsurf.recover(few, reconstruction="interpolant")


def test_a_frame_and_a_selection_choose_the_atoms(tmp_path):
    trajectory = [str(ROOT / "data" / "tdp43" / name) for name in ("topology.pdb", "trajectory.xtc")]
    molecule = sparsurf.read_molecule(*trajectory, stride=500, residues="209-230")
    first, second = (sparsurf.surface_atoms(molecule, frame=frame) for frame in range(2))
    assert np.array_equal(second.centres, molecule.xyz[1][second.atom].round(3))
    assert first.atom.tolist() != second.atom.tolist() and second.frame == 1
    with pytest.raises(InputError, match="frame 9"):
        sparsurf.surface_atoms(molecule, frame=9)
    name = tmp_path / "few.xyzr"
    assert (
        command.main(
            ["atoms", *trajectory[:1], "--trajectory", trajectory[1], "--frame", "500", "-o", str(name)]
        )
        == 0
    )
    whole = sparsurf.read_molecule(*trajectory).frame(500)
    assert np.array_equal(read_spheres(name).xyz, sparsurf.surface_atoms(whole).centres)


@pytest.mark.parametrize("suffix", [".xyzr", ".pqr", ".pdb"])
def test_files_hold_the_same_atoms_and_say_their_probe(few, tmp_path, suffix):
    path = tmp_path / f"few{suffix}"
    few.write(path)
    assert "Probe radius 1.4" in path.read_text()
    assert is_same_surface(sparsurf.surface(path, density=4.0), sparsurf.surface(few, density=4.0))
    if suffix == ".pdb":
        assert np.array_equal(sparsurf.read_molecule(path).b_factor, few.radii)
    else:
        assert np.array_equal(read_spheres(path).radii, few.radii)


def test_pymol_reads_the_files(few, tmp_path):
    if which("pymol") is None:
        pytest.skip("PyMOL is not installed")
    few.write(tmp_path / "few.pdb")
    few.write(tmp_path / "few.pqr")
    script = 'load few.pdb, labelled; load few.pqr, charged; print("ATOMS", *map(cmd.count_atoms, ["labelled", "charged"]))'
    path = os.pathsep.join(["/usr/bin", os.environ["PATH"]])  # Debian's own python runs it
    environment = {"env": os.environ | {"PATH": path}, "cwd": tmp_path}
    done = subprocess.run(["pymol", "-cq", "-d", script], capture_output=True, text=True, **environment)
    assert f"ATOMS {len(few)} {len(few)}" in done.stdout, done.stdout + done.stderr


ONE, TWICE = ([[0, 0, 0]], [1.7]), ([[0, 0, 0], [0, 0, 0], [3, 0, 0]], [1.2, 1.7, 1.7])
APART = ([[0, 0, 0], [40, 0, 0], [41, 0, 0]], [1.7, 1.7, 1.7])
HIDDEN = ([[0, 0, 0], [0.3, 0, 0], [0, 0.4, 0]], [3.0, 1.2, 1.2])


@pytest.mark.parametrize(
    ("spheres", "options", "atoms"),
    [
        (ONE, {}, [0]),
        (TWICE, {}, [1, 2]),  # the larger of two at one place
        (APART, {}, [0, 1, 2]),
        (HIDDEN, {}, [0]),
        (HIDDEN, {"probe_radius": 10}, [0]),
        (ONE, {"probe_radius": 10}, [0]),
        (ONE, {"cavities": "remove"}, [0]),
        (APART, {"cavities": "remove", "plugs": False}, [0, 1, 2]),
    ],
)
def test_odd_spheres_are_right(spheres, options, atoms):
    some = sparsurf.surface_atoms(spheres, **options)
    assert some.atom.tolist() == atoms and some.touched.all() and some.is_exact


def test_a_lattice_in_special_position_is_determined_or_said_not_to_be(caplog):
    """Four and eight atoms touch each probe between them."""
    steps = 3.2 * np.arange(-2, 3)
    lattice = np.array(np.meshgrid(steps, steps, steps)).reshape(3, -1).T, np.full(125, 1.7)
    some = sparsurf.surface_atoms(lattice)
    assert some.is_exact != ("four or more atoms" in caplog.text)
    placed = [sparsurf.surface(each, density=4.0) for each in (some, lattice)]
    assert abs(placed[0].area.sum() / placed[1].area.sum() - 1) < EXACT


@pytest.mark.parametrize(
    ("source", "options", "sentence"),
    [
        (ONE, {"probe_radius": 0}, "probe_radius is 0; it must be a number, more than 1e-06 and at most 10"),
        (ONE, {"cavities": "drop"}, "cavities is 'drop';"),
        (ONE, {"plugs": 1}, "plugs is 1;"),
        (ONE, {"frame": 1}, "frame 1"),
        (([], []), {}, "surface: needs"),
        ("dots", {}, "dots hold"),
    ],
)
def test_what_cannot_be_is_refused(source, options, sentence):
    source = sparsurf.surface(ONE) if source == "dots" else source
    with pytest.raises(InputError, match=sentence):
        sparsurf.surface_atoms(source, **options)


def test_the_command_says_what_it_found(tmp_path, capsys):
    write(tmp_path / "small.pdb", peptide(("GLY",)) + "END\n")  # the probe touches every atom
    assert command.main(["atoms", str(tmp_path / "small.pdb"), "-o", str(tmp_path / "few.pdb")]) == 0
    n = sparsurf.read_molecule(tmp_path / "small.pdb").n_atoms
    said = capsys.readouterr().err
    assert f"{n} of {n} atoms" in said and "0 plugs" in said and "The surface is the same" in said
    sparsurf.surface(tmp_path / "small.pdb").write(tmp_path / "dots.csv")
    assert command.main(["atoms", str(tmp_path / "dots.csv"), "-o", str(tmp_path / "x.pdb")]) == 1
    assert "holds dots" in capsys.readouterr().err
    assert not (tmp_path / "x.pdb").exists()
