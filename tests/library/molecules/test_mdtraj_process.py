"""What mdtraj reads in a process of its own is what it reads in this one; what it cannot read is a sentence."""

import os
import subprocess
import sys
import time
from multiprocessing import Pipe

import mdtraj
import numpy as np
import pytest

from conftest import ROOT
from sparsurf.errors import InputError
from sparsurf.molecules import mdtraj_process
from sparsurf.molecules.mdtraj_process import FrameSelection, iterate_frames, load_atoms

TOPOLOGY = ROOT / "data" / "tdp43" / "topology.pdb"


def load_frames(path, n_atoms, *atoms, **keys):
    """Load frames in one part."""
    parts = iterate_frames(path, n_atoms, FrameSelection(*atoms, **keys))
    return tuple(np.concatenate(arrays) for arrays in zip(*parts, strict=True))


@pytest.fixture(scope="module")
def whole():
    """Five frames with their times and boxes."""
    some = mdtraj.load_frame(str(ROOT / "data" / "tdp43" / "trajectory.xtc"), 0, top=str(TOPOLOGY))
    rng = np.random.default_rng(0)
    xyz = some.xyz + rng.normal(scale=0.01, size=(5, *some.xyz.shape[1:])).astype(np.float32)
    return mdtraj.Trajectory(
        xyz, some.topology, time=10.0 * np.arange(5), unitcell_lengths=np.full((5, 3), [7.0, 8.0, 9.0]),
        unitcell_angles=np.full((5, 3), 90.0),
    )  # fmt: skip


def test_names_are_those_of_the_topology(whole, tmp_path):
    whole[0].save_gro(str(tmp_path / "a.gro"))
    rows, atoms = load_atoms(tmp_path / "a.gro"), list(whole.topology.atoms)
    assert len(rows) == len(atoms)
    for k in (0, 1, 400, len(atoms) - 1):
        atom = atoms[k]
        residue = atom.residue
        assert rows[k] == (
            atom.name, residue.name, "", "", residue.resSeq, atom.element.symbol, residue.index, 0,
        )  # fmt: skip
    chain = mdtraj.Topology()
    residue = chain.add_residue("ALA", chain.add_chain(chain_id="Q"), resSeq=-3, segment_id="SEG")
    chain.add_atom("CA", None, residue)
    other = chain.add_residue("ALA", chain.add_chain(), resSeq=4, segment_id="SEG")
    chain.add_atom("CL", mdtraj.element.chlorine, other)
    assert mdtraj_process.atom_rows(chain) == [
        ("CA", "ALA", "Q", "SEG", -3, "", 0, 0),
        ("CL", "ALA", "SEG", "SEG", 4, "CL", 1, 1),
    ]


@pytest.mark.parametrize("ending", ["xtc", "trr", "dcd", "h5"])
def test_frames_are_those_of_the_trajectory(whole, tmp_path, ending):
    path, n, some = tmp_path / f"a.{ending}", whole.n_atoms, np.array([3, 7, 20])
    whole.save(str(path))
    xyz, time, box = load_frames(path, n)
    np.testing.assert_allclose(xyz, whole.xyz, atol=0.0006)
    if ending != "dcd":  # which has no times
        np.testing.assert_allclose(time, whole.time)
    np.testing.assert_allclose(box, whole.unitcell_vectors, atol=1e-5)
    xyz, time, box = load_frames(path, n, some, span=slice(0, None, 2))
    assert xyz.shape == (3, 3, 3) and len(time) == len(box) == 3
    np.testing.assert_allclose(xyz, whole.xyz[::2][:, some], atol=0.0006)
    xyz, time, box = load_frames(path, n, some, only=[1, 4])
    assert xyz.shape == (2, 3, 3) and len(time) == len(box) == 2
    np.testing.assert_allclose(xyz, whole.xyz[[1, 4]][:, some], atol=0.0006)
    xyz, time, _ = load_frames(path, n, some, first=True)
    assert len(xyz) == len(time) == 1  # all of its atoms, whichever are asked for
    np.testing.assert_allclose(xyz[:, some], whole.xyz[:1][:, some], atol=0.0006)


def test_one_frame_of_some_atoms(whole, tmp_path):
    path = tmp_path / "a.ncrst"
    whole[2].save_netcdfrst(str(path))
    xyz, _, _ = load_frames(path, whole.n_atoms, np.array([2, 5]))
    np.testing.assert_allclose(xyz, whole.xyz[2:3, [2, 5]], atol=1e-5)
    assert load_frames(path, whole.n_atoms, np.array([5]), first=True)[0].shape == (1, whole.n_atoms, 3)


def test_a_trajectory_of_other_atoms_says_how_many_it_has(whole, tmp_path):
    whole.save_dcd(str(tmp_path / "a.dcd"))
    xyz, _, box = load_frames(tmp_path / "a.dcd", 3, first=True)
    assert xyz.shape == (1, whole.n_atoms, 3) and len(box) == 0


def test_one_frame_of_other_atoms_is_refused(whole, tmp_path):
    path = tmp_path / "a.ncrst"
    whole[0].save(str(path))
    with pytest.raises(InputError, match="different numbers"):
        load_frames(path, 7, first=True)


@pytest.mark.parametrize("kind", ["xtc", "dcd", "trr", "nc", "h5"])
def test_a_path_with_letters_beyond_ascii_is_read(whole, tmp_path, kind):
    (tmp_path / "Körper å").mkdir()
    path = tmp_path / "Körper å" / f"lauf.{kind}"
    whole.save(str(tmp_path / path.name))
    (tmp_path / path.name).rename(path)
    xyz, _, _ = load_frames(path, whole.n_atoms, first=True)
    np.testing.assert_allclose(xyz[0], whole.xyz[0], atol=6e-4)  # xtc rounds to 0.001 nm
    with pytest.raises(InputError, match=f"Körper å/kurz.{kind} cannot be read"):
        path.with_stem("kurz").write_bytes(b"nothing of the kind")
        load_frames(path.with_stem("kurz"), whole.n_atoms)


def test_frames_are_read_in_parts_and_reading_may_end_early(whole, tmp_path, monkeypatch):
    whole.save(str(tmp_path / "a.dcd"))
    monkeypatch.setattr(mdtraj_process, "BYTES_OF_A_PART", 2 * 12 * whole.n_atoms)
    mdtraj_process._server.cache_clear()  # a new process does not know of it, but the file is short
    for part in mdtraj_process.iterate_frames(tmp_path / "a.dcd", whole.n_atoms):
        assert len(part[0]) == 5
        break
    frames = [
        part.xyz
        for part in mdtraj_process._load(
            str(tmp_path / "a.dcd"),
            whole.n_atoms,
            FrameSelection(np.arange(9), slice(0, None, 2), np.array([])),
        )
    ]
    assert [len(xyz) for xyz in frames] == [2, 1]
    np.testing.assert_allclose(np.concatenate(frames), whole.xyz[::2, :9], atol=1e-6)
    assert len(load_frames(tmp_path / "a.dcd", whole.n_atoms)[0]) == 5


@pytest.mark.parametrize(("ending", "stride", "only"), [("trr", 2, []), ("trr", 1, [1, 4])])
def test_frames_are_counted_over_all_parts(whole, tmp_path, monkeypatch, ending, stride, only):
    """In parts of two of the five frames a second part does not begin with a frame that the stride chooses."""
    whole.save(str(tmp_path / f"a.{ending}"))
    monkeypatch.setattr(mdtraj_process, "BYTES_OF_A_PART", (3 if stride > 1 else 2) * 12 * whole.n_atoms)
    given = (
        str(tmp_path / f"a.{ending}"),
        whole.n_atoms,
        FrameSelection(np.arange(9), slice(0, None, stride), np.array(only)),
    )
    xyz = np.concatenate([part.xyz for part in mdtraj_process._load(*given)])
    np.testing.assert_allclose(xyz, whole.xyz[only or slice(None, None, stride), :9], atol=6e-4)


def test_what_cannot_be_read_is_a_sentence(tmp_path, monkeypatch):
    with pytest.raises(InputError, match="exist: check"):
        load_frames(tmp_path / "no.xtc", 3)
    (tmp_path / "bad.gro").write_text("one\ntwo\n")
    with pytest.raises(InputError, match=r"bad.gro cannot be read \(\w.*\): it is damaged"):
        load_atoms(tmp_path / "bad.gro")
    for answers, reason in (
        ((["half an answer"], -11), "its reader crashed"), ((1,), "its reader crashed"), ((130 * "x", 1), 120 * "x"),
    ):  # fmt: skip
        monkeypatch.setattr(
            mdtraj_process, "_request", lambda *_, answers=answers: (answer for answer in answers)
        )
        with pytest.raises(InputError, match=rf"\({reason}\)"):
            load_atoms(tmp_path / "bad.gro")


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (ValueError("first\nsecond"), "first"), (OSError(), "its reader failed"),
        (KeyError("x"), "its reader failed"), (None, ["rows"]),
    ],
)  # fmt: skip
def test_the_reason_is_the_first_line_of_what_a_reader_says(monkeypatch, error, reason):
    def read(path):
        if error:
            raise error
        return ["rows"]

    monkeypatch.setattr(mdtraj_process, "_atoms", read)
    answers, sink = Pipe(duplex=False)
    assert mdtraj_process._answer(os.dup(sink.fileno()), "atoms", "a.gro") == bool(error)
    assert answers.recv() == reason


@pytest.mark.parametrize("ending", ["h5", "HDF5"])
def test_hdf5_without_pytables_is_a_sentence(tmp_path, monkeypatch, ending):
    path = tmp_path / f"t.{ending}"
    path.touch()
    monkeypatch.setattr(mdtraj_process, "find_spec", lambda name: None)
    with pytest.raises(InputError, match="pip install tables"):
        load_frames(path, 3)


def test_one_process_reads_every_file_and_another_follows_where_it_is_killed(whole, tmp_path, monkeypatch):
    path, started, start = tmp_path / "a.gro", [], subprocess.Popen
    whole[0].save_gro(str(path))
    monkeypatch.setattr(
        mdtraj_process.subprocess, "Popen", lambda *a, **b: started.append(start(*a, **b)) or started[-1]
    )
    mdtraj_process._server.cache_clear()
    for _ in range(2):
        assert len(load_atoms(path)) == load_frames(path, whole.n_atoms)[0].shape[1] == whole.n_atoms
    assert len(started) == 1
    started[0].kill()
    started[0].wait()
    with pytest.raises(InputError, match=r"\(its reader crashed\)"):
        load_atoms(path)
    assert len(load_atoms(path)) == whole.n_atoms and len(started) == 2


def test_the_process_that_reads_ends_with_its_program(whole, tmp_path):
    path = tmp_path / "a.gro"
    whole[0].save_gro(str(path))
    code = """
import subprocess, sys
start = subprocess.Popen
def told(*arguments, **more):
    process = start(*arguments, **more)
    print(process.pid)
    return process
subprocess.Popen = told
from sparsurf.molecules.mdtraj_process import load_atoms
load_atoms(sys.argv[1])
"""
    command = [sys.executable, "-c", code, path]
    done = subprocess.run(command, cwd=ROOT / "src", capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and done.stderr == ""
    with pytest.raises(ProcessLookupError):
        for _ in range(50):
            os.kill(int(done.stdout), 0)
            time.sleep(0.1)
