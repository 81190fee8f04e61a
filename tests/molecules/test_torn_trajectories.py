"""Trajectories in text formats that end within a frame."""

import logging
import struct

import mdtraj
import numpy as np
import pytest

from conftest import ROOT
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.molecules.trajectory import (
    count_complete_frames,
    count_usable_frames,
    table_of_rows,
    warn_of_repeats,
)

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
    assert count_complete_frames(cut(path, tmp_path, behind), frames.n_atoms) == (2, True)
    assert count_complete_frames(cut(path, tmp_path, behind + 3), frames.n_atoms) == (2, True)
    assert count_complete_frames(cut(path, tmp_path, behind + len(last)), frames.n_atoms) == (1, True)


def test_a_last_number_without_its_last_digit_is_no_number(trajectory, frames, tmp_path):
    """The file ends in 12.34 instead of 12.345: all numbers are there, the last one is wrong."""
    assert count_complete_frames(cut(trajectory[0], tmp_path, 2), frames.n_atoms) == (2, True)


def test_whole_files_are_whole(trajectory, frames, tmp_path):
    path, last = trajectory
    assert count_complete_frames(path, frames.n_atoms) == (3, False)
    assert count_complete_frames(cut(path, tmp_path, 1), frames.n_atoms) == (
        3,
        False,
    )  # without the last newline
    assert count_complete_frames(cut(path, tmp_path, len(last)), frames.n_atoms) == (2, False)
    longer = tmp_path / path.name
    longer.write_bytes(path.read_bytes() + b"\n \n\n")
    assert count_complete_frames(longer, frames.n_atoms) == (3, False)
    assert count_complete_frames(path.with_suffix(".xtc"), frames.n_atoms) is None


def test_lines_are_counted_across_chunks(trajectory, frames, monkeypatch):
    monkeypatch.setattr("sparsurf.molecules.trajectory.BYTES_AT_ONCE", 1000)
    assert count_complete_frames(trajectory[0], frames.n_atoms) == (3, False)


@pytest.mark.parametrize(("n_atoms", "box"), [(1, False), (3, False), (5, True), (5, False)])
def test_a_line_of_three_numbers_is_a_box_only_behind_a_longer_one(tmp_path, n_atoms, box):
    numbers = [f"{k:8.3f}" for k in range(3 * n_atoms)]
    lines = ["".join(numbers[k : k + 10]) for k in range(0, len(numbers), 10)] + box * ["".join(numbers[:3])]
    (tmp_path / "a.mdcrd").write_text("title\n" + 4 * ("\n".join(lines) + "\n"))
    assert count_complete_frames(tmp_path / "a.mdcrd", n_atoms) == (4, False)


@pytest.mark.parametrize(("count", "stride", "read"), [(3, 1, [0, 1]), (3, 2, [0]), (4, 2, [0, 2])])
def test_a_torn_last_frame_is_left_out_and_reported(frames, tmp_path, caplog, count, stride, read):
    """mdtraj takes the last frame for whole where only a digit is missing."""
    path = tmp_path / "a.xyz"
    mdtraj.join([frames, frames[1:]])[:count].save(str(path))
    path.write_bytes(path.read_bytes()[:-2])
    with caplog.at_level(logging.WARNING, "sparsurf"):
        molecule = read_molecule(TOPOLOGY, path, stride=stride)
    assert molecule.frame_number.tolist() == read
    assert np.abs(molecule.xyz - 10 * frames.xyz[read]).max() < 1e-3
    assert f"a.xyz is cut short: its incomplete last frame is left out, {len(read)} were read" in caplog.text


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
        assert (f"continues after the {announced} frames that its header announces" in caplog.text) == told


def dcd(path, order, announced, count, cell):
    """A DCD file of four atoms and `count` frames."""

    def record(content):
        return (length := struct.pack(order + "i", len(content))) + content + length

    head = b"CORD" + struct.pack(order + "i", announced) + bytes(76)
    frame = (record(bytes(48)) if cell else b"") + 3 * record(bytes(16))
    path.write_bytes(record(head) + record(bytes(84)) + record(struct.pack(order + "i", 4)) + count * frame)
    return path


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("cell", [False, True])
def test_frames_of_a_dcd_file_are_counted_by_its_size(tmp_path, caplog, order, cell):
    for announced, count, stride, words in (
        (100, 100, 1, ""), (99, 100, 1, "continues after the 99"), (1, 2, 1, "continues after the 1 "), (0, 2, 1, ""),
        (101, 100, 1, "cut short"), (100, 100, 2, ""), (103, 100, 2, "its header announces 103 frames, 50 were read"),
    ):  # fmt: skip
        caplog.clear()
        path, found = dcd(tmp_path / "a.dcd", order, announced, count, cell), -(-count // stride)
        assert count_usable_frames(path, 4, found, stride) == found
        assert words in caplog.text and bool(words) == bool(caplog.text), (announced, count, stride)


@pytest.mark.parametrize(
    ("order", "told"),
    [
        ("abab", True),
        ("aabaab", True),
        ("abaaba", True),
        ("ababb", True),
        ("aaaa", False),
        ("abba", False),
        ("aa", False),
    ],
)
def test_a_second_half_that_repeats_the_first_is_reported_where_anything_moves(caplog, order, told):
    places = {"a": [[0, 0, 0], [1, 0, 0]], "b": [[0, 0, 0], [1, 1, 0]]}
    xyz = np.array([places[each] for each in order])
    warn_of_repeats("a.dcd", xyz, np.full(len(order), np.nan))
    assert ("its second half repeats the first" in caplog.text) == told


def test_time_that_stands_still_and_then_goes_back(caplog):
    xyz = np.arange(12.0).reshape(4, 1, 3)
    warn_of_repeats("a.xtc", xyz, np.array([0, 5, 5, 3.0]))
    warn_of_repeats("a.dcd", xyz, np.array([0, 5, 5, 3.0]))  # whose times mean nothing
    assert caplog.messages == ["a.xtc: time goes back to 3 ps at frame 3; were two trajectories joined?"]


def test_the_table_of_a_topology():
    rows = [
        ("N", "ALA", "A", "S", 4, "N", 0, 0), ("CA", "ALA", "", "S", 4, "C", 0, 0), ("N", "ALA", "", "", 5, "N", 1, 1),
    ]  # fmt: skip
    table = table_of_rows(rows, first_number=1)
    assert table.residue.tolist() == ["5", "5", "6"] and table.segid.tolist() == ["S", "S", ""]
    assert table.unit.tolist() == table.molecule.tolist() == [0, 0, 1]
    assert table[["x", "y", "z", "b_factor"]].isna().all(axis=None)
    same = table[["model", "hetero", "altloc", "occupancy"]].drop_duplicates().to_numpy().tolist()
    assert same == [[1, False, "", 1.0]] and table_of_rows(rows).residue[0] == "4"
