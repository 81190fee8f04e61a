"""mdtraj's readers in a process of their own: on damaged files its C code and HDF5 overrun their buffers.

That process imports mdtraj once and forks for each file, so that a crash ends the fork: it becomes a sentence
instead of the end of the run.
"""

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
from importlib.util import find_spec
from multiprocessing import Pipe, reduction
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from sparsurf import InputError
from sparsurf.files import existing_file
from sparsurf.molecules.formats import ONE_FRAME, suffix

OWN_TOPOLOGY = (".h5", ".hdf5")
OTHER_ATOMS = re.compile(r"xyz must be shape .* You supplied +\(\d+, (\d+), 3\)")
NOT_THE_SAME = "might not contain the same atoms"  # of files of one frame

_one_by_one = threading.Lock()


def names(path):
    """Atoms of a topology file.

    Returns
    -------
    list of [atom name, residue name, chain id or segment, residue number, element, index of the residue]

    Raises
    ------
    InputError : the file cannot be read
    """
    return json.loads(_run(path, "names"))


def frames(path, n_atoms, atoms=None, stride=1, first=False, only=()):
    """Frames of a trajectory in mdtraj's units.

    Parameters
    ----------
    path : file
    n_atoms : int, atoms of the topology
    atoms : (A,) int, those to return; default all
    stride : int
    first : bool, read the first frame only
    only : (F,) int, positions in the file of the frames to read; default every `stride`-th

    Returns
    -------
    xyz : (F, A, 3) float32, nm, where A may differ from `n_atoms` if `first`
    time : (F,) float, ps
    box : (F, 3, 3) float32, nm ; or (0, 3, 3)

    Raises
    ------
    InputError : the file cannot be read
    """
    atoms = np.arange(n_atoms) if atoms is None else np.asarray(atoms)
    answer = io.BytesIO(_run(path, "frames", n_atoms, atoms, stride, first, np.asarray(only, int)))
    return tuple(np.load(answer, allow_pickle=False) for _ in range(3))


def _run(path, task, *arguments):
    """Bytes that the other process answers."""
    if existing_file(path).suffix.lower() in OWN_TOPOLOGY and find_spec("tables") is None:
        raise InputError(f"{path} needs PyTables: run pip install tables.")
    with _one_by_one, _readable(Path(path).absolute()) as readable:
        try:
            answer, code = _ask(_server(os.getpid())[0], task, str(readable), *arguments)
        except (OSError, EOFError):  # it was killed; the next file has a new one
            _server.cache_clear()
            answer, code = b"", None
    if code != 0:
        reason = answer.decode()[:120] if code == 1 and answer else "its reader crashed"
        if NOT_THE_SAME in reason:
            raise InputError(
                f"{path} has another number of atoms than its topology: give the topology that it was written with."
            )
        raise InputError(
            f"{path} cannot be read ({reason}): it is damaged, cut short or not what its name says."
        )
    return answer


@contextlib.contextmanager
def _readable(path):
    """A path of the same file that every reader takes: those of binary trajectories know letters of ASCII only."""
    if str(path).isascii():
        yield path
        return
    with tempfile.TemporaryDirectory(dir=None if tempfile.gettempdir().isascii() else "/tmp") as folder:
        link = Path(folder, "file" + suffix(path))
        link.symlink_to(path)
        yield link


@functools.cache
def _server(_process):
    """Connection to the other process, and that process; a fork of this one has its own."""
    ours, theirs = Pipe()
    command = [sys.executable, "-m", __name__, str(theirs.fileno())]
    one_thread = {"OPENBLAS_NUM_THREADS": "1"}  # others would not survive a fork
    environment = os.environ | one_thread | {"PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    silent = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL)  # the readers print
    other = subprocess.Popen(command, env=environment, pass_fds=[theirs.fileno()], **silent)
    theirs.close()
    return ours, other  # which ends with the connection


def _ask(server, *request):
    """What the server's fork writes, and its exit code."""
    source, sink = os.pipe()
    with open(source, "rb") as pipe:
        try:
            server.send(request)
            reduction.send_handle(server, sink, None)
        finally:
            os.close(sink)
        return pipe.read(), server.recv()


def _names(path):
    import mdtraj  # here: only the other process needs it

    return json.dumps(rows_of(mdtraj.load_topology(path))).encode()


def rows_of(topology):
    """Atoms of an mdtraj.Topology as `names` gives them."""
    return [
        (
            atom.name, atom.residue.name, atom.residue.chain.chain_id or atom.residue.segment_id or "",
            int(atom.residue.resSeq), atom.element.symbol.upper() if atom.element else "", atom.residue.index,
        )
        for atom in topology.atoms
    ]  # fmt: skip


def _frames(path, n_atoms, atoms, stride, first, only):
    try:
        read = _load(path, n_atoms, atoms, stride, first, only)
        arrays = read.xyz, np.asarray(read.time, float), read.unitcell_vectors
    except ValueError as error:
        other = OTHER_ATOMS.search(str(error))
        if not (other and first):
            raise
        arrays = np.zeros((1, int(other[1]), 3)), np.zeros(1), None  # the caller says what does not fit
    answer = io.BytesIO()
    for array in (*arrays[:2], np.empty((0, 3, 3)) if arrays[2] is None else arrays[2]):
        np.save(answer, array, allow_pickle=False)
    return answer.getbuffer()


def _load(path, n_atoms, atoms, stride, first, only):
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
    every = mdtraj.load(path, stride=stride, atom_indices=atoms, **topology)
    return every[only] if len(only) else every


def _topology(n_atoms):
    """What mdtraj asks for as `top`; only its number of atoms matters."""
    import mdtraj

    topology = mdtraj.Topology()
    residue = topology.add_residue("X", topology.add_chain())
    for _ in range(n_atoms):
        topology.add_atom("X", mdtraj.element.carbon, residue)
    return topology


def _answer(sink, task, *arguments):
    """Write the answer to `sink`, or the reason why there is none; the exit code."""
    with open(sink, "wb") as pipe:
        try:
            pipe.write({"names": _names, "frames": _frames}[task](*arguments))
        except Exception as error:
            told = isinstance(
                error, OSError | ValueError | RuntimeError | ImportError
            )  # others speak of Python
            reason = (told and next(iter(str(error).splitlines()), "")) or "its reader failed"
            pipe.write(reason.encode(errors="replace"))
            return 1
    return 0


def main(handle):
    """Answer, each request in a fork, until the connection ends."""
    with contextlib.suppress(ImportError):  # which is told where a file is read
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
