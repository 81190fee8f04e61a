"""Trajectories in text formats that end within a frame."""

import logging

import mdtraj
import numpy as np
import pytest

from conftest import ROOT
from sparsurf import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.molecules.trajectory import whole_frames

TOPOLOGY = ROOT / "data" / "tdp43" / "topology.pdb"


@pytest.fixture(scope="module")
def frames():
    one = mdtraj.load(str(TOPOLOGY))
    frames = mdtraj.join([one, one, one])
    frames.xyz = frames.xyz + 0.0121 * np.arange(3)[:, None, None]  # so that no number ends in a 0
    return frames


@pytest.fixture(scope="module", params=["xyz", "lammpstrj", "gro", "mdcrd", "box.mdcrd"])
def trajectory(request, frames, tmp_path_factory):
    """Three frames in a file, and the bytes of the last one."""
    path = tmp_path_factory.mktemp("torn") / f"whole.{request.param}"
    box = request.param not in ("mdcrd", "xyz")
    frames.unitcell_vectors = np.repeat(5.4321 * np.eye(3)[None], 3, axis=0) if box else None
    frames.save(str(path))
    lines = path.read_bytes().splitlines(keepends=True)
    title = path.suffix == ".mdcrd"
    return path, b"".join(lines[title + 2 * (len(lines) - title) // 3 :])


def cut(path, folder, missing):
    """Copy of a file without its last bytes."""
    torn = folder / path.name
    torn.write_bytes(path.read_bytes()[: path.stat().st_size - missing])
    return torn


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_a_torn_frame_is_noticed(trajectory, frames, tmp_path, share):
    path, last = trajectory
    lines = last.splitlines(keepends=True)
    behind = len(
        b"".join(lines[round(share * len(lines)) :])
    )  # at the end of a line, where readers say nothing
    assert whole_frames(cut(path, tmp_path, behind), frames.n_atoms) == (2, True)
    assert whole_frames(cut(path, tmp_path, behind + 3), frames.n_atoms) == (2, True)
    assert whole_frames(cut(path, tmp_path, behind + len(last)), frames.n_atoms) == (1, True)


def test_a_last_number_without_its_last_digit_is_no_number(trajectory, frames, tmp_path):
    """The file ends in 12.34 instead of 12.345: all numbers are there, the last one is wrong."""
    assert whole_frames(cut(trajectory[0], tmp_path, 2), frames.n_atoms) == (2, True)


def test_whole_files_are_whole(trajectory, frames, tmp_path):
    path, last = trajectory
    assert whole_frames(path, frames.n_atoms) == (3, False)
    assert whole_frames(cut(path, tmp_path, 1), frames.n_atoms) == (3, False)  # without the last newline
    assert whole_frames(cut(path, tmp_path, len(last)), frames.n_atoms) == (2, False)
    longer = tmp_path / path.name
    longer.write_bytes(path.read_bytes() + b"\n \n\n")
    assert whole_frames(longer, frames.n_atoms) == (3, False)
    assert whole_frames(path.with_suffix(".xtc"), frames.n_atoms) is None


def test_lines_are_counted_across_chunks(trajectory, frames, monkeypatch):
    monkeypatch.setattr("sparsurf.molecules.trajectory.CHUNK", 1000)
    assert whole_frames(trajectory[0], frames.n_atoms) == (3, False)


@pytest.mark.parametrize(("count", "stride", "read"), [(3, 1, [0, 1]), (3, 2, [0]), (4, 2, [0, 2])])
def test_a_torn_last_frame_is_left_out_and_told(frames, tmp_path, caplog, count, stride, read):
    """mdtraj takes the last frame for whole where only a digit is missing."""
    path = tmp_path / "a.xyz"
    mdtraj.join([frames, frames[1:]])[:count].save(str(path))
    path.write_bytes(path.read_bytes()[:-2])
    with caplog.at_level(logging.WARNING, "sparsurf"):
        molecule = read_molecule(TOPOLOGY, path, stride=stride)
    assert molecule.frame_number.tolist() == read
    assert np.abs(molecule.xyz - 10 * frames.xyz[read]).max() < 1e-3
    assert f"a.xyz is cut short: the frame in which it ends is left out, {len(read)} were read" in caplog.text


def test_nothing_but_a_torn_frame_is_refused(frames, tmp_path):
    path = tmp_path / "a.xyz"
    frames[0].save(str(path))
    path.write_bytes(path.read_bytes()[:-2])
    with pytest.raises(InputError, match=r"a\.xyz is cut short within its first frame"):
        read_molecule(TOPOLOGY, path)


@pytest.mark.parametrize(("stride", "found"), [(1, 3), (2, 2)])
def test_a_dcd_file_with_fewer_frames_than_its_header_says(frames, tmp_path, caplog, stride, found):
    path = tmp_path / "a.dcd"
    mdtraj.join([frames, frames[:2]]).save(str(path))
    frame = (path.stat().st_size - 276) // 5  # below a header of 276 bytes
    path.write_bytes(path.read_bytes()[: 276 + 3 * frame])
    with caplog.at_level(logging.WARNING, "sparsurf"):
        assert read_molecule(TOPOLOGY, path, stride=stride).n_frames == found
    assert f"its header announces 5 frames, {found} were read (stride {stride})" in caplog.text


def test_a_dcd_file_with_a_frame_more_than_its_header_says(frames, tmp_path, caplog):
    path = tmp_path / "a.dcd"
    mdtraj.join([frames, frames[:2]]).save(str(path))
    content = path.read_bytes()
    for announced, told in ((5, False), (4, True)):
        path.write_bytes(content[:8] + announced.to_bytes(4, "little") + content[12:])
        with caplog.at_level(logging.WARNING, "sparsurf"):
            assert read_molecule(TOPOLOGY, path).n_frames == 5
        assert (f"goes on after the {announced} frames that its header announces" in caplog.text) == told
