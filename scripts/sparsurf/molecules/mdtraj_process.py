"""mdtraj's readers in a process of their own: on damaged files its C code and HDF5 overrun their buffers.

A crash becomes an exit code and a sentence instead of the end of the run. What is read travels through a pipe:
`python -m sparsurf.molecules.mdtraj_process names path`, or `frames path n_atoms stride first` with the indices of the
atoms on standard input, and those of the frames behind them.
"""

import io
import json
import os
import re
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np

from sparsurf import InputError
from sparsurf.molecules.formats import ONE_FRAME

OWN_TOPOLOGY = (".h5", ".hdf5")
OTHER_ATOMS = re.compile(r"xyz must be shape .* You supplied +\(\d+, (\d+), 3\)")


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
    indices = io.BytesIO()
    for chosen in (np.arange(n_atoms) if atoms is None else atoms, np.asarray(only, int)):
        np.save(indices, chosen)
    answer = io.BytesIO(_run(path, "frames", n_atoms, stride, int(first), given=indices.getvalue()))
    return tuple(np.load(answer, allow_pickle=False) for _ in range(3))


def _run(path, task, *arguments, given=b""):
    """Bytes that the other process answers."""
    if not Path(path).is_file():
        raise InputError(f"{path} does not exist: check the path.")
    command = [sys.executable, "-m", __name__, task, str(Path(path).absolute()), *map(str, arguments)]
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    done = subprocess.run(command, input=given, capture_output=True, env=environment, check=False)
    if done.returncode:
        lines = done.stderr.decode(errors="replace").strip().splitlines()
        reason = lines[-1][:120] if done.returncode == 1 and lines else "its reader crashed"
        raise InputError(
            f"{path} cannot be read ({reason}): it is damaged, cut short or not what its name says."
        )
    return done.stdout


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


def _frames(path, n_atoms, stride, first):
    given = io.BytesIO(sys.stdin.buffer.read())
    atoms, only = (np.load(given, allow_pickle=False) for _ in range(2))
    try:
        read = _load(path, int(n_atoms), atoms, int(stride), first == "1", only)
        arrays = read.xyz, np.asarray(read.time, float), read.unitcell_vectors
    except ValueError as error:
        other = OTHER_ATOMS.search(str(error))
        if not (other and first == "1"):
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


def main(task, *arguments):
    """Write the answer to standard output, or the reason why there is none to standard error."""
    warnings.simplefilter("ignore")
    with os.fdopen(os.dup(1), "wb") as pipe:
        os.dup2(2, 1)  # the readers print
        try:
            pipe.write({"names": _names, "frames": _frames}[task](*arguments))
        except Exception as error:
            sys.exit("\n" + (next(iter(str(error).splitlines()), "") or type(error).__name__))


if __name__ == "__main__":
    main(*sys.argv[1:])
