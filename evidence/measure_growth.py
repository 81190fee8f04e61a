"""Measure how time, memory and files grow: `python evidence/measure_growth.py [--quick] [--out FILE]`.

Three things grow: the atoms of one molecule, the structures of a study, and the frames of a trajectory. Times are CPU seconds of
one process on one core, after all kernels are loaded. Molecules are copies of the embedded one on a lattice, and the largest is
a ribosome where its file is there. Structures and frames are planned and not run.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
import yaml

import bench
from measures.timing import peak_memory
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.patches.index import build_index
from sparsurf.patches.roughness import roughness_of_patches
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import radii

COPIES = (1, 4, 16, 64)  # of the embedded structure of 953 atoms
STRUCTURES = (1, 10, 100, 1000, 5000)
STUDIED = 100  # structures at most that are planned with pages of their own
FRAMES = (100, 1000, 10_000)
PIECE = "209-240"  # residues of the smallest molecule: 500 atoms


def print_surface(copies: int, residues: str | None = None) -> None:
    """Print, in a process of its own, atoms, dots, seconds and peak memory of surface and roughness of some copies."""
    bench.warm_up()
    before = peak_memory()
    if copies:
        xyz, r = bench.embedded(residues)
        xyz, r = bench.lattice(xyz, copies), bench.np.tile(r, copies)
    else:
        molecule = read_molecule(bench.RIBOSOME, selection="all", whole=False)
        xyz, r = molecule.xyz[0], radii(molecule)
    begin = time.process_time()
    surface = molecular_surface(xyz, r)
    placed = time.process_time()
    roughness_of_patches(build_index(surface.points, surface.normals))
    spent = placed - begin, time.process_time() - placed
    content = {"atoms": len(xyz), "dots": len(surface), "bytes": peak_memory() - before, "seconds": spent}
    print(json.dumps(content))


def of_molecules(quick: bool) -> list[dict]:
    """Return a row for each molecule, from 500 atoms to the ribosome."""
    calls = [f"1, {PIECE!r}", *(str(copies) for copies in (COPIES[:1] if quick else COPIES))]
    if not quick and bench.RIBOSOME.is_file():
        calls.append("0")
    rows = []
    for call in calls:
        command = [sys.executable, "-c", f"import measure_growth; measure_growth.print_surface({call})"]
        found = json.loads(
            subprocess.run(command, cwd=Path(__file__).parent, capture_output=True, check=True).stdout
        )
        dots = found["dots"]
        rows.append(
            {"grows": "atoms of a molecule", "n": found["atoms"], "dots": dots}
            | {"surface_us_a_dot": 1e6 * found["seconds"][0] / dots}
            | {"roughness_us_a_dot": 1e6 * found["seconds"][1] / dots, "bytes_a_dot": found["bytes"] / dots}
        )
    return rows


def planned(config: dict) -> dict[str, float]:
    """Return CPU seconds and files of planning a study, of which nothing is run."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "config.yaml")
        path.write_text(yaml.safe_dump(config), encoding="utf-8")
        program = [
            sys.executable,
            "-m",
            "snakemake",
            "--snakefile",
            bench.ROOT / "Snakefile",
            "--configfile",
            path,
        ]
        command = [*map(str, program), "--directory", folder, "--cores", "1", "--nolock", "--summary"]
        before = os.times()
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        after = os.times()
    spent = after.children_user + after.children_system - before.children_user - before.children_system
    return {"planning_s": spent, "files": len(done.stdout.splitlines()) - 1}


def of_structures(quick: bool) -> list[dict]:
    """Return a row for each number of structures, in batches, and in a study with a folder for each."""
    rows = []
    for n in STRUCTURES[:2] if quick else STRUCTURES:
        proteins = {f"p{k:05d}": {"structure": str(bench.EMBEDDED)} for k in range(n)}
        study = {"run": "growth", "sampling": False, "proteins": proteins}
        rows.append({"grows": "structures in batches", "n": n} | planned(study | {"pages": []}))
        if n <= STUDIED:
            row = {"grows": "structures with pages of their own", "n": n}
            rows.append(row | planned(study | {"pages": list(proteins)}))
    return rows


def print_frames(n: int) -> None:
    """Print, in a process of its own, the seconds of reading n frames, and the bytes of their coordinates."""
    import mdtraj

    bench.warm_up()
    with tempfile.TemporaryDirectory() as folder:
        one = mdtraj.load(str(bench.TRAJECTORY), top=str(bench.EMBEDDED))
        long, count = Path(folder, "long.xtc"), one.n_frames
        with mdtraj.formats.XTCTrajectoryFile(str(long), "w") as file:
            for begin in range(0, n, count):
                file.write(one.xyz[: n - begin], step=bench.np.arange(begin, min(begin + count, n)))
        begin_cpu = time.process_time()
        molecule = read_molecule(bench.EMBEDDED, long)
        spent = time.process_time() - begin_cpu
    print(json.dumps({"frames": molecule.n_frames, "bytes": molecule.xyz.nbytes, "seconds": spent}))


def of_frames(quick: bool) -> list[dict]:
    """Return a row for each number of frames: reading them, and planning the study of their trajectory."""
    protein = {"structure": str(bench.EMBEDDED), "trajectory": str(bench.TRAJECTORY)}
    plan = planned(
        {"run": "growth", "sampling": False, "ensemble": {"run": True}, "proteins": {"p": protein}}
    )
    rows = []
    for n in FRAMES[:1] if quick else FRAMES:
        command = [sys.executable, "-c", f"import measure_growth; measure_growth.print_frames({n})"]
        found = json.loads(
            subprocess.run(command, cwd=Path(__file__).parent, capture_output=True, check=True).stdout
        )
        row = {"grows": "frames of a trajectory", "n": found["frames"], "reading_s": found["seconds"]}
        rows.append(row | {"kB_a_frame": found["bytes"] / found["frames"] / 1000} | plan)
    return rows


def command(arguments: Sequence[str] | None = None) -> None:
    """Measure what the command line asks for, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], allow_abbrev=False)
    parser.add_argument("--quick", action="store_true", help="the smallest ones: to see that all runs")
    out = bench.ROOT / "evidence" / "tables" / "growth.csv"
    parser.add_argument("--out", default=out, help="CSV file to write")
    args = parser.parse_args(arguments)
    rows = []
    for measure in (of_molecules, of_structures, of_frames):
        rows += measure(args.quick)
        print(pd.DataFrame(rows).to_string(), flush=True)
    pd.DataFrame(rows).to_csv(args.out, index=False, float_format="%.4g")


if __name__ == "__main__":
    command()
