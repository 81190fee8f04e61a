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
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sparsurf.errors import InputError
from sparsurf.files import StrPath
from sparsurf.molecules.atom_table import AtomTable, atom_table
from sparsurf.molecules.source import Source, open_source

if TYPE_CHECKING:
    import mdtraj

# Extensions of the formats whose files are treated differently here; every request has the usual one of its format
OWN_TOPOLOGY, NETCDF, ONE_FRAME = ".h5", ".nc", ".ncrst"
PS_PER_UNIT = {  # names of units of time in NetCDF files, as regular expressions
    "ps|picosec(ond)?s?|": 1.0, "fs|femtosec(ond)?s?": 1e-3, "ns|nanosec(ond)?s?": 1e3, "(us|microsec(ond)?s?)": 1e6,
}  # fmt: skip
WRONG_N_ATOMS = re.compile(r"xyz must be shape .* You supplied +\(\d+, (\d+), 3\)")
MAX_REASON = 120  # characters
NM_PER_ANGSTROM = 0.1
MIN_CELL_ANGLE = 30.0  # degrees; the angles of all cells of simulations are larger
# The variables of NetCDF files that may be scaled.
SCALED_VARIABLES = ("coordinates", "cell_lengths", "cell_angles", "time")
NO_COORDINATES = "it has no variable called coordinates"  # What is said of such a NetCDF file.
DIFFERENT_ATOMS = "might not contain the same atoms"  # mdtraj's error for files of one frame

# Name of the atom and its residue, chain identifier, segment, number of the residue, element, index of residue and chain
AtomRow = tuple[str, str, str, str, int, str, int, int]
PartOfTrajectory = tuple[np.ndarray, np.ndarray, np.ndarray]  # xyz, time, box

BYTES_OF_A_PART = 2**22  # The positions in one part of a trajectory take so much memory.

_one_request_at_a_time = threading.Lock()


def load_atoms(path: StrPath) -> list[AtomRow]:
    """Load the atoms of an HDF5 file of mdtraj; raise InputError if it cannot be read."""
    [rows] = _run(path, "atoms")
    return rows


def table_of_rows(rows: Sequence[AtomRow]) -> AtomTable:
    """Return the table of `atom_table`, with coordinates nan, from rows of `atom_rows`."""
    columns = ("name", "residue_name", "chain", "segid", "residue", "element", "unit", "molecule")
    table = dict(zip(columns, map(list, zip(*rows, strict=True)), strict=True))
    table["chain"] = [chain.strip() for chain in table["chain"]]
    return atom_table(**table)


class FrameSelection(NamedTuple):
    """Which frames of a trajectory are loaded, and which of their atoms."""

    atoms: np.ndarray | None = None  # indices, ascending; all of them by default
    span: slice = slice(0, None, 1)  # positions of frames in the file
    only: np.ndarray | Sequence[int] = ()  # positions of frames in the file, in place of these
    first: bool = False  # the first frame alone, whose number of atoms may differ from that of the topology


EVERY_FRAME = FrameSelection()


def iterate_frames(
    path: StrPath, n_atoms: int, chosen: FrameSelection = EVERY_FRAME
) -> Iterator[PartOfTrajectory]:
    """Load frames of a trajectory in parts: xyz (F, A, 3) float32, nm; time (F,), ps; box (F, 3, 3), nm, or (0, 3, 3)."""
    atoms = np.arange(n_atoms) if chosen.atoms is None else np.asarray(chosen.atoms)
    only = np.asarray(chosen.only, int)
    # The values alone, since the class would have to be imported in the other process
    return _run(path, "frames", n_atoms, *chosen._replace(atoms=atoms, only=only))


def _run(path: StrPath, task: str, *arguments: Any) -> Iterator[Any]:
    """Yield the answers of the other process to a request."""
    source = open_source(path)
    if source.format.name == "hdf5" and find_spec("tables") is None:
        raise InputError(f"{source} needs PyTables: run pip install tables.")
    reason, code = "", -1
    with _one_request_at_a_time, _readable(source) as readable:
        try:
            request = _request(_server(os.getpid())[0], task, str(readable), *arguments)
            with contextlib.closing(request):
                for answer in request:
                    if isinstance(answer, str):
                        reason = answer.replace(str(readable), readable.name)[:MAX_REASON]
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
            f"{source} and its topology have different numbers of atoms: give the topology that it was written with."
        )
    if NO_COORDINATES in reason:
        raise InputError(
            f"{source} is no trajectory of AMBER: {NO_COORDINATES}; give the file with coordinates."
        )
    reason = reason if code == 1 and reason else "its reader crashed"
    raise InputError(f"{source} cannot be read ({reason}): it is damaged or cut short; copy it again.")


@contextlib.contextmanager
def _readable(source: Source) -> Iterator[Path]:
    """Give a path to the file that every reader accepts: with the usual extension of the format, in ASCII characters."""
    path, extension = Path(source).absolute(), source.format.suffixes[0]
    if str(path).isascii() and path.suffix == extension:
        yield path
        return
    with tempfile.TemporaryDirectory(dir=None if tempfile.gettempdir().isascii() else "/tmp") as folder:
        link = Path(folder, "file" + extension)
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
    rows = []
    for residue in topology.residues:
        segment, chain = residue.segment_id or "", residue.chain.chain_id
        chain_or_segment = segment if chain is None else chain or ""
        number, of_chain = int(residue.resSeq), residue.chain.index
        for atom in residue.atoms:
            element = atom.element.symbol.upper() if atom.element else ""
            row = (
                atom.name,
                residue.name,
                chain_or_segment,
                segment,
                number,
                element,
                residue.index,
                of_chain,
            )
            rows.append(row)
    return rows


def _atoms(path: str) -> list[AtomRow]:
    """Load the atoms of a topology, in the other process."""
    import mdtraj  # only the other process needs it

    return atom_rows(mdtraj.load_topology(path))


def _frames(path: str, n_atoms: int, *values: Any) -> Iterator[PartOfTrajectory]:
    """Load frames, in the other process, which gets the values of a FrameSelection."""
    chosen = FrameSelection(*values)
    sys.modules["netCDF4"] = None  # type: ignore[assignment]  # mdtraj reads the same with scipy, and never scales
    ps_per_unit, scale, no_box = *_units_of_netcdf(path), np.empty((0, 3, 3))
    try:
        for part in _load(path, n_atoms, chosen):
            if part.unitcell_lengths is None:
                box = no_box
            else:
                if scale["cell_lengths"] != 1 or scale["cell_angles"] != 1:
                    part.unitcell_lengths *= scale["cell_lengths"]
                    part.unitcell_angles *= scale["cell_angles"]
                box = lattice(part, Path(path).suffix == ".dcd")
            xyz = part.xyz if scale["coordinates"] == 1 else part.xyz * np.float32(scale["coordinates"])
            yield xyz, np.asarray(part.time, float) * scale["time"] * ps_per_unit, box
    except ValueError as error:
        mismatch = WRONG_N_ATOMS.search(str(error))
        if not (mismatch and chosen.first):
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


def _units_of_netcdf(path: str) -> tuple[float, dict[str, float]]:
    """Return the unit of the times of a NetCDF file in ps, and the factors of its variables: mdtraj reads neither."""
    scale = dict.fromkeys(SCALED_VARIABLES, 1.0)
    if Path(path).suffix not in (NETCDF, ONE_FRAME):
        return 1.0, scale
    from scipy.io import netcdf_file

    with netcdf_file(path, mmap=False) as file:
        if "coordinates" not in file.variables:
            raise ValueError(NO_COORDINATES)
        unit = getattr(file.variables.get("time"), "units", b"picosecond").decode("ascii", "replace").strip()
        for name in SCALED_VARIABLES:
            scale[name] = float(getattr(file.variables.get(name), "scale_factor", 1.0))
    ps_per_unit = next((ps for name, ps in PS_PER_UNIT.items() if re.fullmatch(name, unit.lower())), None)
    if ps_per_unit is None:
        raise ValueError(f"its times are in {unit[:20]!r}")
    return ps_per_unit, scale


def _load(path: str, n_atoms: int, chosen: FrameSelection) -> Iterator[mdtraj.Trajectory]:
    """Load parts of a trajectory with mdtraj, see `iterate_frames`."""
    import mdtraj

    atoms, span, only, first = chosen
    extension = Path(path).suffix
    topology = {} if extension == OWN_TOPOLOGY else {"top": _topology(n_atoms)}
    if extension == ONE_FRAME:
        whole = mdtraj.load(path, **topology)
        yield whole if first else whole.atom_slice(atoms)
    elif first:
        part = next(mdtraj.iterload(path, chunk=1, **topology), None)
        if part is None:
            raise OSError("it holds no frames")
        yield part[0]
    elif len(only) and extension != ".trr":
        for k in np.asarray(only).tolist():
            yield mdtraj.load(path, frame=k, atom_indices=atoms, **topology)
    else:  # mdtraj 1.11 crashes on TRR with stride and atoms together
        step = 1 if extension == ".trr" or len(only) or span.start % span.step else span.step
        begin = 0  # mdtraj 1.11 reads frames beyond the end of XTC with skip and stride together
        chunk = max(1, BYTES_OF_A_PART // (12 * n_atoms))
        for part in mdtraj.iterload(path, chunk=chunk, stride=step, atom_indices=atoms, **topology):
            number = begin + step * np.arange(len(part))
            begin = number[-1] + step
            keep = np.isin(number, only if len(only) else range(begin)[span])
            if span.stop is not None and number[0] >= span.stop and not len(only):
                break
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
