"""Reading a trajectory in a process of its own: mdtraj's C readers overrun their buffers on damaged files.

A crash becomes an exit code and a sentence instead of the end of the run. The arrays travel through a pipe.
Run as `python -m sparsurf.isolated path n_atoms stride first`, the indices of the atoms on standard input.
"""

import io
import os
import re
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np

from sparsurf import InputError

ONE_FRAME = (".rst7", ".restrt", ".inpcrd", ".ncrst")
OWN_TOPOLOGY = (".h5", ".hdf5")
OTHER_ATOMS = re.compile(r"xyz must be shape .* You supplied +\(\d+, (\d+), 3\)")


def load(path, n_atoms, atoms=None, stride=1, first=False):
    """Frames of a trajectory in mdtraj's units.

    Parameters
    ----------
    path : file
    n_atoms : int, atoms of the topology
    atoms : (A,) int, those to return; default all
    stride : int
    first : bool, read the first frame only

    Returns
    -------
    xyz : (F, A, 3) float32, nm, where A may differ from `n_atoms` if `first`
    time : (F,) float, ps
    box : (F, 3, 3) float32, nm ; or (0, 3, 3)

    Raises
    ------
    InputError : the file cannot be read
    """
    command = [sys.executable, "-m", __name__, str(path), str(n_atoms), str(stride), str(int(first))]
    atoms_in = io.BytesIO()
    np.save(atoms_in, np.arange(n_atoms) if atoms is None else atoms)
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[1])}
    done = subprocess.run(
        command, input=atoms_in.getvalue(), capture_output=True, env=environment, check=False
    )
    if done.returncode:
        lines = done.stderr.decode(errors="replace").strip().splitlines()
        reason = lines[-1][:120] if done.returncode == 1 and lines else "its reader crashed"
        raise InputError(
            f"{path} cannot be read ({reason}): it is damaged, cut short or not what its name says."
        )
    stream = io.BytesIO(done.stdout)
    return tuple(np.load(stream, allow_pickle=False) for _ in range(3))


def _read(path, n_atoms, atoms, stride, first):
    import mdtraj  # here: the importing process does not need it

    extension = Path(path).suffix.lower()
    topology = {} if extension in OWN_TOPOLOGY else {"top": _topology(n_atoms)}
    if first and extension not in ONE_FRAME:
        return next(mdtraj.iterload(path, chunk=1, **topology))[0]
    every = {} if extension in ONE_FRAME else {"stride": stride}
    if extension == ".trr" or first:  # mdtraj 1.11 crashes on TRR with stride and atoms together
        whole = mdtraj.load(path, **every, **topology)
        return whole if first else whole.atom_slice(atoms)
    return mdtraj.load(path, atom_indices=atoms, **every, **topology)


def _topology(n_atoms):
    """What mdtraj asks for as `top`; only its number of atoms matters."""
    import mdtraj

    topology = mdtraj.Topology()
    residue = topology.add_residue("X", topology.add_chain())
    for _ in range(n_atoms):
        topology.add_atom("X", mdtraj.element.carbon, residue)
    return topology


def main(path, n_atoms, stride, first):
    """Write xyz, time and box to standard output, or a reason to standard error."""
    pipe = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # the readers print
    warnings.simplefilter("ignore")
    try:
        atoms = np.load(io.BytesIO(sys.stdin.buffer.read()), allow_pickle=False)
        read = _read(path, int(n_atoms), atoms, int(stride), first == "1")
        arrays = read.xyz, np.asarray(read.time, float), read.unitcell_vectors
    except Exception as error:
        other = OTHER_ATOMS.search(str(error)) if first == "1" else None
        if not other:
            sys.exit("\n" + (next(iter(str(error).splitlines()), "") or type(error).__name__))
        arrays = np.zeros((1, int(other[1]), 3)), np.zeros(1), None
    for array in (*arrays[:2], np.empty((0, 3, 3)) if arrays[2] is None else arrays[2]):
        buffer = io.BytesIO()  # numpy cannot save into a pipe
        np.save(buffer, array, allow_pickle=False)
        pipe.write(buffer.getbuffer())
    pipe.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
