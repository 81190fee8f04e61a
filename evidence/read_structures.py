"""What is read from the structures: a checksum of each, so that the other tables count as older only where it differs."""

import hashlib
from dataclasses import fields
from pathlib import Path
from tempfile import TemporaryDirectory

import pandas as pd

from sparsurf.molecules.read_molecule import read_molecule, read_own
from sparsurf.workflow.jobs import run

TRAJECTORY = "trajectory"  # the row of the example's frames
WAYS = ({}, {"hydrogens": "keep", "model": 1}, {"hydrogens": "remove", "model": 1})  # in which chains read


def main(inputs, outputs, names, studied):
    """Write number of atoms, checksum and `revision`, how often it has changed, of each structure and of the example's frames.

    Of those that are `studied` the checksum holds, too, what is read from the file that a study writes of them.
    """
    path = Path(outputs["structures_read"])
    before = pd.read_csv(path).set_index("name").to_dict("index") if path.is_file() else {}
    paths = {name: (WAYS, each) for name, each in zip(names, inputs["structures"], strict=True)}
    paths[TRAJECTORY] = WAYS[:1], inputs["topology"], inputs["trajectory"]
    rows = []
    for name, own in paths.items():
        atoms, found = _read(name in (*studied, TRAJECTORY), *own)
        known = before.get(name, {"sha256": found, "revision": 0})
        rows.append((name, atoms, found, known["revision"] + (known["sha256"] != found)))
    pd.DataFrame(rows, columns=["name", "atoms", "sha256", "revision"]).to_csv(path, index=False)


def _read(studied, ways, *paths):
    """Number of atoms, and a checksum of what all `ways` to read give, and a study's own file of the same."""
    content = hashlib.sha256()
    with TemporaryDirectory() as folder:
        own = Path(folder, "structure.pdb")
        for way in ways:
            molecule = read_molecule(*paths, **way)
            molecule.write_pdb(own)
            for one in (molecule, read_own(own)) if studied else (molecule,):
                content.update(repr([getattr(one, each.name).tolist() for each in fields(one)]).encode())
    return molecule.n_atoms, content.hexdigest()[:16]


if __name__ == "__main__":
    run(main, snakemake)
