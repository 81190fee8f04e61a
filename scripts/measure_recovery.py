"""Recover surfaces from subsets of many proteins: `python scripts/measure_recovery.py structures docs/tables`.

Reads every structure of a folder (first model, all its polymers), writes recover.csv (a row per protein, sampler and
n_S), recover_floors.csv, recover_means.csv and recover_pairs.csv, and renders recover.md in the folder above, with
recover.png of the embedded example. Where the package fast-simplification is installed, recover_opponents.csv sets beside
them a mesh decimated by it, a surface laid sparsely and the atoms; the paper's structure A1 (--a1 or $SPARSURF_A1) gives
recover_a1.csv, with the time and the memory of a million recovered dots.
Proteins that are in a table already are not measured again.
"""

import argparse
import math
import os
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.molecules.reading import READERS, read_molecule
from sparsurf.recovery.recovering import recover
from sparsurf.report import recovery_page
from sparsurf.report.figures import recovered
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study import opponents, recovery
from sparsurf.study.evaluator import Evaluator
from sparsurf.surfaces.making import molecular_surface
from sparsurf.surfaces.radii import radii
from sparsurf.threads import available_cores
from sparsurf.workflow.timing import peak_memory

EXAMPLE = Path(__file__).parents[1] / "data" / "tdp43" / "topology.pdb"
MOST_ATOMS = 20_000  # beyond, farthest dots alone, and the settled ones
MOST_ATOMS_OF_MESHES = 3_000  # beyond, they take minutes each
TESTS = 1000


def main(structures, tables, threads, a1):
    """Measure what is missing, then write the tables and the page."""
    tables = Path(tables)
    tables.mkdir(parents=True, exist_ok=True)
    simplify = simplifier()
    for name, xyz, atom_radii in molecules(structures):
        huge, small = len(xyz) > MOST_ATOMS, len(xyz) <= MOST_ATOMS_OF_MESHES
        if name not in known(tables / "recover.csv"):
            names = recovery.NAMES[:1] if huge else recovery.NAMES
            floors, subsets = recovery.measure(name, xyz, atom_radii, TESTS, names=names, threads=threads)
            append(floors, tables / "recover_floors.csv")
            append(subsets, tables / "recover.csv")
        if (simplify or not small) and name not in known(tables / "recover_opponents.csv"):
            found = opponents.measure(
                name, xyz, atom_radii, simplify if small else None, TESTS, threads=threads
            )
            append(found, tables / "recover_opponents.csv")
        print(name, flush=True)
    if a1:
        measure_a1(a1, tables, threads)
    stored = {key: _read(tables / f"recover{key}.csv") for key in ("", "_floors", "_opponents", "_a1")}
    table, beside = stored[""], stored["_opponents"]
    stored["_means"] = recovery.means(table)
    pairs = [(table, "adaptive", "farthest"), (table, "roughness", "uniform")]
    if beside is not None:
        full = set(beside.loc[beside["sampler"] == opponents.MESH, "protein"])  # the others have no mesh
        alike = beside[beside["protein"].isin(full) & (beside["sampler"] != opponents.ATOMS)]
        stored["_opponents_means"] = recovery.means(alike, ("bytes", "Z", "distance", "angle"))
        others = opponents.SETTLED, opponents.SPARSE, opponents.MESH, opponents.CORNERS
        pairs += [(alike, each, opponents.KEPT) for each in others]
    stored["_pairs"] = pd.concat([recovery.paired(*pair) for pair in pairs], ignore_index=True)
    for key in {"_means", "_pairs", "_opponents_means"} & set(stored):
        stored[key].to_csv(tables / f"recover{key}.csv", index=False, float_format="%.4g")
    (tables.parent / "recover.md").write_text(
        recovery_page.page(*recovery_page.read(tables)), encoding="utf-8"
    )
    _draw(tables.parent / "recover.png", threads)


def molecules(structures):
    """Name, places of the atoms and radii of the structures of a folder, the small files first."""
    for path in sorted(Path(structures).iterdir(), key=lambda path: path.stat().st_size):
        if not any(end in READERS for end in path.suffixes):
            continue
        try:
            molecule = read_molecule(path, selection=None)
        except InputError as error:
            print(f"{path.name}: left out, {error}")
            continue
        yield path.name.split(".")[0], molecule.xyz[0], radii(molecule, "dms")


def measure_a1(path, tables, threads):
    """recover_a1.csv: the paper's structure, and what a million dots recovered from copies of its own cost."""
    molecule = read_molecule(path)
    xyz, atom_radii = molecule.xyz[0], radii(molecule, "dms")
    _, subsets = recovery.measure(
        "A1", xyz, atom_radii, TESTS, names=("farthest", "adaptive"), threads=threads
    )
    others = opponents.measure("A1", xyz, atom_radii, n_tests=TESTS, threads=threads)
    others = others[others["sampler"] != opponents.KEPT].drop(columns="bytes")
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:  # whose memory is its own
        paid = pool.submit(cost, *copies_of_a_tenth(xyz, atom_radii)).result()
    rows = pd.concat([subsets, others], ignore_index=True).assign(**paid)
    rows.to_csv(tables / "recover_a1.csv", index=False, float_format="%.5g")


def copies_of_a_tenth(xyz, radii, dots=1_000_000):
    """Points and normals of farthest-point dots, a tenth, of copies of a molecule side by side that have `dots` in all."""
    surface = molecular_surface(xyz, radii)
    evaluator = Evaluator(surface, roughness_values=np.zeros(len(surface)))
    kept = SAMPLERS["farthest"](evaluator, len(surface) // 10, evaluator.stream("cost"))
    points, copies = surface.points[kept], math.ceil(dots / len(surface))
    apart = [np.ptp(points[:, 0]) + 10.0, 0.0, 0.0]
    return np.concatenate([points + np.multiply(k, apart) for k in range(copies)]), np.tile(
        surface.normals[kept], (copies, 1)
    )


def cost(points, normals):
    """CPU seconds for a million recovered dots, and the peak of memory for each, of a process that did nothing before."""
    recover(points[:1000], normals[:1000])
    before, begin = peak_memory(), time.process_time()
    n = len(recover(points, normals)[0])
    seconds = time.process_time() - begin
    return {"a_million_s": 1e6 * seconds / n, "bytes_per_dot": (peak_memory() - before) / n}


def simplifier():
    """Decimation by quadric error of the package fast-simplification, where it is installed."""
    try:
        from fast_simplification import simplify
    except ImportError:
        print("fast-simplification is not installed: no opponents are measured")
        return None

    def fewer(vertices, triangles, n):
        found = simplify(vertices.astype("float32"), triangles.astype("int32"), target_count=n)
        return found[0].astype(float), found[1].astype(int)

    return fewer


def known(path):
    """Names of the proteins of a table."""
    return set() if not path.is_file() else set(pd.read_csv(path)["protein"])


def append(part, path):
    """Add rows to a table."""
    before = [pd.read_csv(path)] if path.is_file() else []
    pd.concat([*before, part], ignore_index=True).to_csv(path, index=False, float_format="%.5g")


def _draw(path, threads):
    """The figure of the page: the embedded example, and what a tenth of its dots gives back."""
    molecule = read_molecule(EXAMPLE)
    atom_radii, xyz = radii(molecule, "dms"), molecule.xyz[0]
    evaluator = Evaluator(molecular_surface(xyz, atom_radii), seed=1, name="example", threads=threads)
    dots = SAMPLERS["farthest"](evaluator, len(evaluator.points) // 10, evaluator.stream("figure"))
    kept = evaluator.points[dots], evaluator.normals[dots]
    dense = recover(*kept, threads=threads)
    gap = recovery.distances(dense[0], recovery.truth(xyz, atom_radii))
    words = [
        f"The surface: {len(evaluator.points)} dots",
        f"A tenth of them, with normals:\n{len(dots)} dots",
        f"The surface recovered from these alone\n(mean distance {gap.mean():.3f} Å)",
    ]
    figure = recovered.figure((evaluator.points, evaluator.normals), kept, dense, gap, words)
    figure.savefig(path, dpi=200)


def _read(path):
    return pd.read_csv(path) if path.is_file() else None


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("structures", help="folder of structures")
    parser.add_argument("tables", nargs="?", default="docs/tables")
    parser.add_argument("--a1", default=os.environ.get("SPARSURF_A1"), help="structure A1 of the paper")
    parser.add_argument("--threads", type=int, default=available_cores())
    wish = parser.parse_args()
    main(wish.structures, wish.tables, wish.threads, wish.a1)
