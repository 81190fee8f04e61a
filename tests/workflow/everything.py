"""A study in which every rule runs but for the simulation's, on peptides of six residues."""

import hashlib
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

from peptides import peptide, write
from small_study import snakemake
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import radii

SEQUENCE = ("ALA", "LEU", "LYS", "GLY", "SER", "VAL")
RULES = {
    "frames": {"use": "all"},
    "sampling": {"alpha": [0.5, 1.0], "beta": [0.0], "gamma": [0, 6], "delta": [0]},
    "evaluation": {"test_dots": 20, "draws": 2},
    "fields": ["hydropathy", "score"],
    "compare": {"run": True, "percents": [20, 40], "samplers": ["paper", "uniform", "farthest"]},
    "ensemble": {"run": True, "jobs": 2, "test_dots": 20},
    "complementarity": {
        "thinning": {"run": True, "percents": [20], "samplers": ["uniform"], "draws": 1, "recovered": False}
    },
}


def given(folder, address):
    """Write what the study is of; returns its config."""
    models = [peptide(SEQUENCE, origin=(0.02 * k, 0, 0.1 * k)) for k in range(2)]
    text = "".join(f"MODEL {k + 1}\n{atoms}ENDMDL\n" for k, atoms in enumerate(models))
    write(folder / "moving.pdb", text + "END\n")
    for name, chain, y in (("got", "A", 0.0), ("one", "A", 0.0), ("two", "B", 9.0)):
        write(folder / f"{name}.pdb", peptide(SEQUENCE, chain, origin=(0, y, 0)) + "END\n")
    (folder / "scores.csv").write_text("residue,score\n2,1\n5,0\n")
    molecule = read_molecule(folder / "one.pdb")
    write_npz(folder / "a1.npz", molecular_surface(molecule.xyz[0], radii(molecule, "dms"), density=9.0))
    digest = hashlib.sha256((folder / "got.pdb").read_bytes()).hexdigest()
    proteins = {
        "moving": {"structure": "moving.pdb", "residues": "1-6", "table": "scores.csv"},
        "A1": {"surface": "a1.npz"},
        "got": {"url": f"{address}/got.pdb", "sha256": digest},
    }
    pairs = {"both": {"proteins": ["moving", "got"]}, "two": {"files": ["one.pdb", "two.pdb"]}}
    sites = {"turn": {"query": "moving/f1", "residues": "2-4", "targets": ["got"]}}
    sites |= {"back": {"query": "got", "residues": "2-4", "targets": ["moving/f1"]}}
    sites["bend"] = {"changes": ["moving", "got"]}
    return RULES | {"run": "all", "proteins": proteins, "pairs": pairs, "sites": sites, "paper": "A1"}


def run(folder):
    """Run it in a folder; returns the config and the finished process."""
    folder.mkdir(exist_ok=True)
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(SimpleHTTPRequestHandler, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    config = given(folder, f"http://127.0.0.1:{server.server_port}")
    try:
        return config, snakemake(folder, config)
    finally:
        server.shutdown()
