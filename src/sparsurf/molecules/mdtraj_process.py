"""Run mdtraj's readers in a separate process: its C code and HDF5 overrun their buffers on damaged files.

The process imports mdtraj once and forks for each file. A crash ends only the fork, and becomes an error message.
"""

from __future__ import annotations

import contextlib
import functools
import io
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import warnings
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from multiprocessing import Pipe, reduction
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.errors import InputError
from sparsurf.files import existing_file
from sparsurf.molecules.formats import ONE_FRAME, suffix

if TYPE_CHECKING:
    import mdtraj

OWN_TOPOLOGY = (".h5", ".hdf5")
NETCDF = (".nc", ".ncdf", ".netcdf")
PS_PER_UNIT = {  # names of units of time in NetCDF files, as regular expressions
    "ps|picosec(ond)?s?|": 1.0, "fs|femtosec(ond)?s?": 1e-3, "ns|nanosec(ond)?s?": 1e3, "(us|microsec(ond)?s?)": 1e6,
}  # fmt: skip
WRONG_N_ATOMS = re.compile(r"xyz must be shape .* You supplied +\(\d+, (\d+), 3\)")
DIFFERENT_ATOMS = "might not contain the same atoms"  # mdtraj's error for files of one frame

AtomRow = tuple[str, str, str, int, str, int]

_one_request_at_a_time = threading.Lock()


def load_atoms(path: str | os.PathLike[str]) -> list[AtomRow]:
    """Load the atoms of a topology file.

    Returns
    -------
    list of (atom name, residue name, chain id or segment, residue number, element, index of the residue)

    Raises
    ------
    InputError
        The file cannot be read.
    """
    return [tuple(row) for row in json.loads(_run(path, "atoms"))]


def load_frames(
    path: str | os.PathLike[str],
    n_atoms: int,
    atoms: np.ndarray | None = None,
    stride: int = 1,
    first: bool = False,
    only: np.ndarray | Sequence[int] = (),
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Load frames of a trajectory in mdtraj's units.

    Parameters
    ----------
    path : file
    n_atoms : int, atoms of the topology
    atoms : (A,) int, the atoms to return; default all
    stride : int
    first : bool, load the first frame only
    only : (F,) int, positions in the file of the frames to load; default every `stride`-th

    Returns
    -------
    xyz : (F, A, 3) float32, nm, where A may differ from `n_atoms` if `first`
    time : (F,) float, ps
    box : (F, 3, 3) float32, nm; (0, 3, 3) without a box

    Raises
    ------
    InputError
        The file cannot be read.
    """
    atoms = np.arange(n_atoms) if atoms is None else np.asarray(atoms)
    answer = io.BytesIO(_run(path, "frames", n_atoms, atoms, stride, first, np.asarray(only, int)))
    xyz, time, box = (np.load(answer, allow_pickle=False) for _ in range(3))
    return xyz, time, box


def _run(path: str | os.PathLike[str], task: str, *arguments: Any) -> bytes:
    """Return the answer of the other process to a request."""
    if existing_file(path).suffix.lower() in OWN_TOPOLOGY and find_spec("tables") is None:
        raise InputError(f"{path} needs PyTables: run pip install tables.")
    with _one_request_at_a_time, _readable(Path(path).absolute()) as readable:
        try:
            answer, code = _request(_server(os.getpid())[0], task, str(readable), *arguments)
        except (OSError, EOFError):  # the process was killed; the next file starts a new one
            _server.cache_clear()
            answer, code = b"", -1
    if code != 0:
        reason = answer.decode()[:120] if code == 1 and answer else "its reader crashed"
        if DIFFERENT_ATOMS in reason:
            raise InputError(
                f"{path} and its topology have different numbers of atoms: give the topology that it was written with."
            )
        raise InputError(
            f"{path} cannot be read ({reason}): it is damaged, cut short, or has the wrong extension."
        )
    return answer


@contextlib.contextmanager
def _readable(path: Path) -> Iterator[Path]:
    """Give a path to the file that every reader accepts: readers of binary trajectories need ASCII characters."""
    if str(path).isascii():
        yield path
        return
    with tempfile.TemporaryDirectory(dir=None if tempfile.gettempdir().isascii() else "/tmp") as folder:
        link = Path(folder, "file" + suffix(path))
        link.symlink_to(path)
        yield link


@functools.cache
def _server(_process_id: int) -> tuple[Connection, subprocess.Popen]:
    """Start the other process, and return the connection to it; a fork of this process starts its own."""
    ours, theirs = Pipe()
    command = [sys.executable, "-m", __name__, str(theirs.fileno())]
    one_thread = {"OPENBLAS_NUM_THREADS": "1"}  # more threads do not survive a fork
    environment = os.environ | one_thread | {"PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    other = subprocess.Popen(
        command,
        env=environment,
        pass_fds=[theirs.fileno()],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,  # the readers print
        stderr=subprocess.DEVNULL,
    )
    theirs.close()
    return ours, other  # the process ends with the connection


def _request(server: Connection, *request: Any) -> tuple[bytes, int]:
    """Send a request, and return the output of the fork and its exit code."""
    source, sink = os.pipe()
    with open(source, "rb") as pipe:
        try:
            server.send(request)
            reduction.send_handle(server, sink, None)
        finally:
            os.close(sink)
        return pipe.read(), server.recv()


def _atoms(path: str) -> bytes:
    """Load the atoms of a topology, in the other process."""
    import mdtraj  # only the other process needs it

    return json.dumps(atom_rows(mdtraj.load_topology(path))).encode()


def atom_rows(topology: mdtraj.Topology) -> list[AtomRow]:
    """Return the atoms of an mdtraj.Topology as `load_atoms` does."""
    return [
        (
            atom.name, atom.residue.name, atom.residue.chain.chain_id or atom.residue.segment_id or "",
            int(atom.residue.resSeq), atom.element.symbol.upper() if atom.element else "", atom.residue.index,
        )
        for atom in topology.atoms
    ]  # fmt: skip


def _frames(
    path: str, n_atoms: int, atoms: np.ndarray, stride: int, first: bool, only: np.ndarray
) -> memoryview:
    """Load frames, in the other process."""
    try:
        loaded = _load(path, n_atoms, atoms, stride, first, only)
        time_ps = np.asarray(loaded.time, float) * _ps_per_unit(path)
        arrays = loaded.xyz, time_ps, loaded.unitcell_vectors
    except ValueError as error:
        mismatch = WRONG_N_ATOMS.search(str(error))
        if not (mismatch and first):
            raise
        arrays = np.zeros((1, int(mismatch[1]), 3)), np.zeros(1), None  # the caller compares the numbers
    answer = io.BytesIO()
    for array in (*arrays[:2], np.empty((0, 3, 3)) if arrays[2] is None else arrays[2]):
        np.save(answer, array, allow_pickle=False)
    return answer.getbuffer()


def _ps_per_unit(path: str) -> float:
    """Return the unit of the times of a NetCDF file in ps, which mdtraj does not read."""
    if Path(path).suffix.lower() not in NETCDF:
        return 1.0
    from scipy.io import netcdf_file

    with netcdf_file(path, mmap=False) as file:
        unit = getattr(file.variables.get("time"), "units", b"picosecond").decode("ascii", "replace").strip()
    known = next((ps for name, ps in PS_PER_UNIT.items() if re.fullmatch(name, unit.lower())), None)
    if known is None:
        raise ValueError(f"its times are in {unit[:20]!r}")
    return known


def _load(
    path: str, n_atoms: int, atoms: np.ndarray, stride: int, first: bool, only: np.ndarray
) -> mdtraj.Trajectory:
    """Load frames with mdtraj, see `load_frames`."""
    import mdtraj

    extension = Path(path).suffix.lower()
    topology = {} if extension in OWN_TOPOLOGY else {"top": _topology(n_atoms)}
    if extension in ONE_FRAME:
        whole = mdtraj.load(path, **topology)
        return whole if first else whole.atom_slice(atoms)
    if first:
        return next(mdtraj.iterload(path, chunk=1, **topology))[0]
    if len(only) and extension != ".gro":  # its reader cannot go to a frame
        return mdtraj.join(
            [mdtraj.load(path, frame=k, atom_indices=atoms, **topology) for k in only.tolist()]
        )
    if extension == ".trr" and stride > 1:  # mdtraj 1.11 crashes on TRR with stride and atoms together
        return mdtraj.load(path, stride=stride, **topology).atom_slice(atoms)
    frames = mdtraj.load(path, stride=stride, atom_indices=atoms, **topology)
    return frames[only] if len(only) else frames


def _topology(n_atoms: int) -> mdtraj.Topology:
    """Return a topology for mdtraj's `top`, of which only the number of atoms matters."""
    import mdtraj

    topology = mdtraj.Topology()
    residue = topology.add_residue("X", topology.add_chain())
    for _ in range(n_atoms):
        topology.add_atom("X", mdtraj.element.carbon, residue)
    return topology


def _answer(sink: int, task: str, *arguments: Any) -> int:
    """Write the answer to `sink`, or the reason of a failure, and return the exit code."""
    with open(sink, "wb") as pipe:
        try:
            pipe.write(_atoms(*arguments) if task == "atoms" else _frames(*arguments))
        except Exception as error:
            # the message of any other exception is about Python, not about the file
            about_file = isinstance(error, OSError | ValueError | RuntimeError | ImportError)
            reason = (about_file and next(iter(str(error).splitlines()), "")) or "its reader failed"
            pipe.write(reason.encode(errors="replace"))
            return 1
    return 0


def main(handle: str) -> None:
    """Answer requests, each in a fork, until the connection ends."""
    with contextlib.suppress(ImportError):  # the error is raised again when a file is read
        import mdtraj  # noqa: F401, once for all forks
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    warnings.simplefilter("ignore")
    client = Connection(int(handle))
    with contextlib.suppress(EOFError):
        while request := client.recv():
            sink = reduction.recv_handle(client)
            fork = os.fork()
            if not fork:
                os._exit(_answer(sink, *request))
            os.close(sink)
            client.send(os.waitstatus_to_exitcode(os.waitpid(fork, 0)[1]))


if __name__ == "__main__":
    main(sys.argv[1])
