"""Run mdtraj's readers in a separate process: its C code and HDF5 overrun their buffers on damaged files.

The process imports mdtraj once and forks for each file. A crash ends only the fork, and becomes an error message.
"""

from __future__ import annotations

import contextlib
import functools
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import warnings
from collections.abc import Generator, Iterator, Sequence
from importlib.util import find_spec
from multiprocessing import Pipe, reduction
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.errors import InputError
from sparsurf.files import StrPath, existing_file
from sparsurf.molecules.formats import ONE_FRAME, suffix

if TYPE_CHECKING:
    import mdtraj

OWN_TOPOLOGY = (".h5", ".hdf5")
NETCDF = (".nc", ".ncdf", ".netcdf")
PS_PER_UNIT = {  # names of units of time in NetCDF files, as regular expressions
    "ps|picosec(ond)?s?|": 1.0, "fs|femtosec(ond)?s?": 1e-3, "ns|nanosec(ond)?s?": 1e3, "(us|microsec(ond)?s?)": 1e6,
}  # fmt: skip
WRONG_N_ATOMS = re.compile(r"xyz must be shape .* You supplied +\(\d+, (\d+), 3\)")
MAX_REASON = 120  # characters
NM_PER_ANGSTROM = 0.1
MIN_CELL_ANGLE = 30.0  # degrees; the angles of all cells of simulations are larger
SCALED, UNSCALED = {"xs", "ys", "zs"}, {"x", "y", "z"}  # columns of a LAMMPS dump
DIFFERENT_ATOMS = "might not contain the same atoms"  # mdtraj's error for files of one frame

# Name of the atom and its residue, chain identifier, segment, number of the residue, element, index of residue and chain
AtomRow = tuple[str, str, str, str, int, str, int, int]
Part = tuple[np.ndarray, np.ndarray, np.ndarray]  # xyz, time, box

BYTES_AT_ONCE = 2**22  # of the positions in one part of a trajectory

_one_request_at_a_time = threading.Lock()


def load_atoms(path: StrPath) -> list[AtomRow]:
    """Load the atoms of a topology file; raise InputError if it cannot be read."""
    [rows] = _run(path, "atoms")
    return rows


def iterate_frames(
    path: StrPath,
    n_atoms: int,
    atoms: np.ndarray | None = None,
    stride: int = 1,
    first: bool = False,
    only: np.ndarray | Sequence[int] = (),
) -> Iterator[Part]:
    """Load frames of a trajectory in parts: xyz (F, A, 3) float32, nm; time (F,), ps; box (F, 3, 3), nm, (0, 3, 3) without one.

    `atoms`, ascending, are those to return; `only` are positions of frames, by default every `stride`-th. With `first`,
    the first frame alone is loaded, whose number of atoms may differ from `n_atoms`.
    """
    atoms = np.arange(n_atoms) if atoms is None else np.asarray(atoms)
    return _run(path, "frames", n_atoms, atoms, stride, first, np.asarray(only, int))


def load_frames(path: StrPath, *arguments: Any, **keys: Any) -> Part:
    """Load frames as `iterate_frames` does, in one part."""
    parts = zip(*iterate_frames(path, *arguments, **keys), strict=True)
    xyz, time, box = (np.concatenate(arrays) for arrays in parts)
    return xyz, time, box


def _run(path: StrPath, task: str, *arguments: Any) -> Iterator[Any]:
    """Yield the answers of the other process to a request."""
    if existing_file(path).suffix.lower() in OWN_TOPOLOGY and find_spec("tables") is None:
        raise InputError(f"{path} needs PyTables: run pip install tables.")
    reason, code = "", -1
    with _one_request_at_a_time, _readable(Path(path).absolute()) as readable:
        try:
            request = _request(_server(os.getpid())[0], task, str(readable), *arguments)
            with contextlib.closing(request):
                for answer in request:
                    if isinstance(answer, str):
                        reason = answer[:MAX_REASON]
                    elif isinstance(answer, int):
                        code = answer
                    else:
                        yield answer
        except (OSError, EOFError):  # the process was killed; the next file starts a new one
            _server.cache_clear()
    if code == 0:
        return
    if DIFFERENT_ATOMS in reason:
        raise InputError(
            f"{path} and its topology have different numbers of atoms: give the topology that it was written with."
        )
    reason = reason if code == 1 and reason else "its reader crashed"
    raise InputError(
        f"{path} cannot be read ({reason}): it is damaged, cut short, or has the wrong extension."
    )


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


def _request(server: Connection, *request: Any) -> Generator[Any]:
    """Send a request; yield the answers of the fork, the reason of a failure as a string, and its exit code."""
    answers, sink = Pipe(duplex=False)
    with sink:
        server.send(request)
        reduction.send_handle(server, sink.fileno(), None)
    try:
        # the fork has ended, or crashed within an answer
        with answers, contextlib.suppress(EOFError, OSError):
            while True:
                yield answers.recv()
    finally:
        code = server.recv()  # the fork ends where nobody listens
    yield code


def atom_rows(topology: mdtraj.Topology) -> list[AtomRow]:
    """Return the atoms of an mdtraj.Topology as `load_atoms` does; a topology without chains has its segments."""
    return [
        (
            atom.name, residue.name, (residue.segment_id if chain is None else chain) or "", residue.segment_id or "",
            int(residue.resSeq), atom.element.symbol.upper() if atom.element else "", residue.index, residue.chain.index,
        )
        for residue in topology.residues for chain in [residue.chain.chain_id] for atom in residue.atoms
    ]  # fmt: skip


def _atoms(path: str) -> list[AtomRow]:
    """Load the atoms of a topology, in the other process."""
    import mdtraj  # only the other process needs it

    return atom_rows(mdtraj.load_topology(path))


def _frames(
    path: str, n_atoms: int, atoms: np.ndarray, stride: int, first: bool, only: np.ndarray
) -> Iterator[Part]:
    """Load frames, in the other process."""
    ps_per_unit, no_box, scaled = _ps_per_unit(path), np.empty((0, 3, 3)), _is_scaled(path)
    try:
        for part in _load(path, n_atoms, atoms, stride, first, only):
            box = (
                no_box
                if part.unitcell_lengths is None
                else lattice(part, Path(path).suffix.lower() == ".dcd")
            )
            xyz = part.xyz
            if scaled:  # mdtraj takes the shares for Å
                xyz = np.matmul(xyz.astype(float) / NM_PER_ANGSTROM, box.astype(float)).astype(np.float32)
            yield xyz, np.asarray(part.time, float) * ps_per_unit, box
    except ValueError as error:
        mismatch = WRONG_N_ATOMS.search(str(error))
        if not (mismatch and first):
            raise
        # the caller compares the numbers
        yield np.zeros((1, int(mismatch[1]), 3)), np.zeros(1), no_box


def lattice(part: mdtraj.Trajectory, may_be_matrix: bool = True) -> np.ndarray:
    """Return the lattice vectors (F, 3, 3), nm, of a trajectory with boxes.

    CHARMM writes the symmetric matrix whose rows are the lattice vectors into DCD files, where other programs write lengths
    and angles. mdtraj takes its elements for angles, of which some are then negative or too small for any cell.
    """
    angles, lengths = part.unitcell_angles, part.unitcell_lengths
    if not may_be_matrix or (angles > MIN_CELL_ANGLE).all():
        return part.unitcell_vectors
    matrix = np.empty((len(lengths), 3, 3), np.float32)
    matrix[:, [0, 1, 2], [0, 1, 2]] = lengths
    for place, (row, column) in enumerate([(1, 2), (0, 2), (0, 1)]):
        matrix[:, row, column] = matrix[:, column, row] = angles[:, place] * NM_PER_ANGSTROM
    possible = np.isfinite(matrix).all() and (np.linalg.eigvalsh(matrix) > 0).all()
    return matrix if possible else part.unitcell_vectors


def _is_scaled(path: str) -> bool:
    """Return whether a LAMMPS dump holds coordinates as shares of the box alone, as mdtraj reads it."""
    if Path(path).suffix.lower() != ".lammpstrj":
        return False
    with open(path, encoding="latin-1") as file:
        head = next((line for line in file if line.startswith("ITEM: ATOMS")), "")
    columns = set(head.split())
    return columns >= SCALED and not columns >= UNSCALED


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
) -> Iterator[mdtraj.Trajectory]:
    """Load parts of a trajectory with mdtraj, see `iterate_frames`."""
    import mdtraj

    extension = Path(path).suffix.lower()
    topology = {} if extension in OWN_TOPOLOGY else {"top": _topology(n_atoms)}
    if extension in ONE_FRAME:
        whole = mdtraj.load(path, **topology)
        yield whole if first else whole.atom_slice(atoms)
    elif first:
        part = next(mdtraj.iterload(path, chunk=1, **topology), None)
        if part is None:
            raise OSError("it holds no frames")
        yield part[0]
    elif len(only) and extension not in (".gro", ".trr"):
        for k in only.tolist():
            yield mdtraj.load(path, frame=k, atom_indices=atoms, **topology)
    else:  # the reader of GRO cannot go to a frame; mdtraj 1.11 crashes on TRR with stride and atoms together
        step = 1 if extension == ".trr" or len(only) else stride
        chunk = max(1, BYTES_AT_ONCE // (12 * n_atoms))
        begin = 0
        for part in mdtraj.iterload(path, chunk=chunk, stride=step, atom_indices=atoms, **topology):
            number = begin + np.arange(len(part))
            begin += len(part)
            keep = np.isin(number, only) if len(only) else number % (stride // step) == 0
            if keep.any():
                yield part if keep.all() else part[np.flatnonzero(keep)]


def _topology(n_atoms: int) -> mdtraj.Topology:
    """Return a topology for mdtraj's `top`, of which only the number of atoms matters."""
    import mdtraj

    topology = mdtraj.Topology()
    residue = topology.add_residue("X", topology.add_chain())
    for _ in range(n_atoms):
        topology.add_atom("X", mdtraj.element.carbon, residue)
    return topology


def _answer(sink: int, task: str, *arguments: Any) -> int:
    """Write the answers to `sink`, or the reason of a failure, and return the exit code."""
    with Connection(sink, readable=False) as pipe:
        try:
            for answer in [_atoms(*arguments)] if task == "atoms" else _frames(*arguments):
                pipe.send(answer)
        except Exception as error:
            # the message of any other exception is about Python, not about the file
            about_file = isinstance(error, OSError | ValueError | RuntimeError | ImportError)
            pipe.send((about_file and next(iter(str(error).splitlines()), "")) or "its reader failed")
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
                code = 1
                try:
                    code = _answer(sink, *request)
                finally:
                    os._exit(code)
            os.close(sink)
            client.send(os.waitstatus_to_exitcode(os.waitpid(fork, 0)[1]))


if __name__ == "__main__":
    main(sys.argv[1])
