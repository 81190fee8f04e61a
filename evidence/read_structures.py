"""What is read from the structures: a checksum of each, so that the other tables count as older only where it differs."""

import hashlib
import runpy
from dataclasses import fields
from pathlib import Path
from tempfile import TemporaryDirectory

import pandas as pd

from sparsurf.molecules.read_molecule import read_molecule, read_own
from sparsurf.workflow.jobs import run

TRAJECTORY = "trajectory"  # the row of the example's frames
CONFORMATIONS = "conformations"  # the row of what studies choose among them
FRAMES = {"clusters": "auto", "use": "clusters", "pca_atoms": "auto", "stride": 1}  # as all chains choose
WAYS = ({}, {"hydrogens": "keep", "model": 1}, {"hydrogens": "remove", "model": 1})  # in which chains read


def main(inputs, outputs, names, studied):
    """Write number of atoms, checksum and `revision`, how often it has changed, of each structure and of the example's frames.

    Of those that are `studied` the checksum holds, too, what is read from the file that a study writes of them. A last row is
    about what a study chooses among the frames of each and of the example.
    """
    path = Path(outputs["structures_read"])
    before = pd.read_csv(path).set_index("name").to_dict("index") if path.is_file() else {}
    paths = {name: (WAYS, each) for name, each in zip(names, inputs["structures"], strict=True)}
    paths[TRAJECTORY] = WAYS[:1], inputs["topology"], inputs["trajectory"]
    rows = []
    for name, own in paths.items():
        rows.append((name, *_read(name in (*studied, TRAJECTORY), *own)))
    files = [own[1:] for name, own in paths.items() if name in (*studied, TRAJECTORY)]
    rows.append((CONFORMATIONS, *_choose(runpy.run_path(inputs["chooses"])["main"], files)))
    for k, (name, atoms, found) in enumerate(rows):
        known = before.get(name, {"sha256": found, "revision": 0})
        rows[k] = name, atoms, found, known["revision"] + (known["sha256"] != found)
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


def _choose(choose, files):
    """Number of atoms of all conformations, and a checksum of every file that a study's first script writes of each."""
    content, atoms = hashlib.sha256(), 0
    for paths in files:
        with TemporaryDirectory() as folder:
            outputs = {
                key: Path(folder, key)
                for key in ("frames", "silhouette", "projection", "explained", "structures")
            }
            inputs = dict(zip(("structure", "trajectory"), paths, strict=False))
            choose(inputs, outputs, {}, {"frames": FRAMES, "seed": 1}, "p")
            for path in sorted(each for each in Path(folder).rglob("*") if each.is_file()):
                content.update(path.read_bytes())
                if path.suffix == ".pdb":
                    atoms += sum(
                        line.startswith(("ATOM", "HETATM")) for line in path.read_text().splitlines()
                    )
    return atoms, content.hexdigest()[:16]


if __name__ == "__main__":
    run(main, snakemake)
