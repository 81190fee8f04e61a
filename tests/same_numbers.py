"""The same numbers on every machine: the library's calls under other processors, threads, hash seeds and Pythons.

    python tests/same_numbers.py            every setting below, each with kernels compiled afresh (about ten minutes)
    python tests/same_numbers.py --quick    two settings with the kernels that are there (a minute), as tests/test_same_numbers.py
    python tests/same_numbers.py --study    the tables of the small study instead, under all of them at once (ten minutes)
    python tests/same_numbers.py --python PATH ...   also these interpreters, which have the packages of this one

Choices (dots, combinations, subsets, hits) must be equal, and numbers agree to 1e-9. Exits with 1 if they do not.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TOLERANCE = 1e-9  # relative to the larger number, or absolute below 1
BASE = {"OPENBLAS_CORETYPE": "Haswell", "OPENBLAS_NUM_THREADS": "1", "PYTHONHASHSEED": "0"}
ALL = {
    "OPENBLAS_CORETYPE": "Prescott",
    "OPENBLAS_NUM_THREADS": "2",
    "PYTHONHASHSEED": "12",
    "NUMBA_CPU_NAME": "generic",
    "NUMBA_CPU_FEATURES": "",
}
OTHERS = {
    "Zen": {"OPENBLAS_CORETYPE": "Zen"},
    "Nehalem": {"OPENBLAS_CORETYPE": "Nehalem"},
    "Prescott": {"OPENBLAS_CORETYPE": "Prescott"},
    "two threads": {"OPENBLAS_NUM_THREADS": "2"},
    "hash seed 12": {"PYTHONHASHSEED": "12"},
    "generic processor": {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""},
    "numpy without AVX": {"NPY_DISABLE_CPU_FEATURES": "AVX512F AVX512CD AVX512_SKX AVX2 FMA3"},
    "all of these": ALL,
}
TIMES = ["choosing", "comparing", "describing", "smoothing", "seconds"]  # columns of tables that measure them
QUICK = {"two threads of an older processor": {"OPENBLAS_CORETYPE": "Prescott", "OPENBLAS_NUM_THREADS": "2"}}


def main(arguments=None):
    """Compare the settings with the first one; return the number that differ."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--study", action="store_true")
    parser.add_argument("--python", nargs="*", default=[])
    parser.add_argument("--measure", action="store_true", help="print the results in this process and end")
    given = parser.parse_args(arguments)
    if given.measure:
        print(json.dumps(tables_of_study() if given.study else measured()))
        return 0
    what = ["--measure", "--study"] if given.study else ["--measure"]
    chosen = QUICK if given.quick else {"all of these": ALL} if given.study else OTHERS
    settings = [(name, sys.executable, each) for name, each in chosen.items()]
    settings += [(path, path, {}) for path in given.python]
    with tempfile.TemporaryDirectory() as kernels:
        base = results(sys.executable, what, {}, None if given.quick else Path(kernels, "base"))
        differ = 0
        for k, (name, python, environment) in enumerate(settings):
            fresh = environment.keys() & {"PYTHONHASHSEED", "NUMBA_CPU_NAME"} or python != sys.executable
            folder = None if given.quick else Path(kernels, str(k) if fresh else "base")
            lines = differences(base, results(python, what, environment, folder))
            differ += bool(lines)
            print(name, "differs:" if lines else "agrees", *lines, sep="\n  " if lines else " ", flush=True)
    return differ


def results(python, what, environment, kernels):
    """Run this file in a process of its own; return what it measured.

    Parameters
    ----------
    python : path of the interpreter
    what : list of str, options of this file
    environment : dict, variables besides those of BASE
    kernels : folder of the compiled kernels, or None for the usual one
    """
    variables = os.environ | BASE | environment | {"PYTHONPATH": str(ROOT / "src")}
    variables |= {} if kernels is None else {"NUMBA_CACHE_DIR": str(kernels)}
    run = subprocess.run(
        [python, __file__, *what], env=variables, capture_output=True, text=True, check=False
    )
    if run.returncode:
        raise SystemExit(f"{python} {environment}: exit code {run.returncode}\n{run.stderr[-3000:]}")
    return json.loads(run.stdout.splitlines()[-1])


def differences(first, second):
    """Return a line for each result that is not the same; whole numbers and words are choices."""
    lines = []
    for name in sorted(first.keys() | second.keys()):
        value, other = first.get(name, []), second.get(name, [])
        if len(value) != len(other):
            lines.append(f"{name}: {len(value)} and {len(other)} values")
            continue
        gaps = [_gap(a, b) for a, b in zip(value, other, strict=True)]
        if gaps and max(gaps) > TOLERANCE:
            worst = gaps.index(max(gaps))
            lines.append(
                f"{name}: {value[worst]} and {other[worst]} at {worst}, {sum(gap > TOLERANCE for gap in gaps)} in all"
            )
    return lines


def _gap(a, b):
    """Return the relative difference of two numbers; infinite if one is a choice and they are not equal."""
    if isinstance(a, float) and isinstance(b, float) and a == a and b == b:
        return abs(a - b) / max(1.0, abs(a), abs(b))
    return 0.0 if a == b or (a != a and b != b) else float("inf")


def tables_of_study():
    """Run the small study; return its tables: dict, file and column -> list of numbers and words."""
    import pandas as pd

    sys.path.insert(0, str(ROOT / "tests"))
    from small_study import output, run_study

    out = {}
    with tempfile.TemporaryDirectory() as folder:
        run = run_study(Path(folder, "study"))
        if run.returncode:
            raise SystemExit(output(run))
        results = Path(folder, "study", "results")
        for path in sorted(results.rglob("*.csv")):
            table = pd.read_csv(path, dtype={"residue": str})
            if "measure" in table:
                table = table[~table["measure"].str.contains("seconds")]
            for column, values in table.drop(columns=TIMES, errors="ignore").items():
                out[f"{path.relative_to(results)} {column}"] = values.tolist()
    return out


def measured():
    """Compute the results: dict, name -> list of numbers and words."""
    import logging

    import numpy as np

    sys.path.insert(0, str(ROOT / "tests"))
    from dataclasses import replace

    from peptides import peptide, write
    from sparsurf.evaluation.floors import floors_table, fresh_dots
    from sparsurf.evaluation.prepared_surface import PreparedSurface
    from sparsurf.molecules.conformations import choose_frames
    from sparsurf.molecules.read_molecule import read_molecule
    from sparsurf.orientation import principal_axes
    from sparsurf.patches import descriptors
    from sparsurf.patches.index import build_index
    from sparsurf.patches.roughness import published as roughness_of
    from sparsurf.recovery.interpolated_surface import interpolate_surface
    from sparsurf.sampling.farthest_point import farthest_point_sampling
    from sparsurf.streams import Streams
    from sparsurf.surfaces.molecular_surface import molecular_surface
    from sparsurf.surfaces.radii import radii
    from sparsurf_study.analysis.best_set import _critical_values, best_set, scatter
    from sparsurf_study.pairs.changes import superpose_forms
    from sparsurf_study.pairs.matching import agreement, maps, match
    from sparsurf_study.pairs.partners import partner_of
    from sparsurf_study.pairs.residue_moments import describe_residues

    logging.disable()
    out = {}

    def note(name, *arrays):
        out[name] = [each for array in arrays for each in np.asarray(array).ravel().tolist()]

    with tempfile.TemporaryDirectory() as folder:
        sequence = ("ALA", "LEU", "LYS", "GLY", "SER", "VAL")
        path = write(Path(folder, "one.pdb"), peptide(sequence) + "END\n")
        one = read_molecule(path)
        second = replace(one, xyz=one.xyz[:, :, [1, 2, 0]] + [3.0, -2.0, 7.0])
        note("superposed forms", superpose_forms(second, one).xyz)
        path = write(Path(folder, "two.pdb"), peptide(sequence, "B", origin=(0, 9.0, 0)) + "END\n")
        other = read_molecule(path)
    pair = [molecular_surface(each.xyz[0], radii(each, "dms"), density=4.0) for each in (one, other)]
    found = match(
        *(partner_of(dots, each, each.chain[0]) for dots, each in zip(pair, (one, other), strict=True))
    )
    note("agreement of equal partners", agreement(found, 0, maps(found, 0)).drop(columns="score"))
    floors = floors_table(fresh_dots(PreparedSurface(pair[1], streams=Streams(1, "ready")), 20, draws=4))
    note("floor of a ready surface", floors.drop(columns="floor"))
    tdp43 = ROOT / "data" / "tdp43"
    moving = read_molecule(tdp43 / "topology.pdb", tdp43 / "trajectory.xtc", residues="209-222")
    choice = choose_frames(moving, rng=np.random.default_rng(0))
    note("frames", choice.index, choice.label)
    note("components", choice.projection, choice.explained[:5])

    molecule = moving.frame(int(choice.index[0]))
    surface = molecular_surface(molecule.xyz[0], radii(molecule, "dms"), density=4.0)
    points, normals = np.ascontiguousarray(surface.points), np.ascontiguousarray(surface.normals)
    note("dots", points, normals)
    note("axes", principal_axes(points))
    index = build_index(points, normals, 1.0)
    dots = farthest_point_sampling(index, len(points) // 5, np.random.default_rng(1))
    note("farthest dots", dots)
    for kind in ("published", "rotation_robust"):
        z, sizes = descriptors.describe_patches(index, points[dots[:40]], 6.0, True, 2, kind)
        note(f"{kind} descriptors", z)
        note(f"{kind} sizes", sizes)
    note("roughness", roughness_of(index, 6.0, 2))
    note("recovered", *interpolate_surface(points[dots], normals[dots], 4.0, threads=2, keep=False)[:2])

    d_of_combinations = (
        np.random.default_rng(2).normal(size=(60, 4, 20)) + np.linspace(0, 0.4, 60)[:, None, None]
    )
    candidates = scatter(d_of_combinations)
    covariance = candidates.by_test @ candidates.by_test.T  # of rank 19
    variance = np.diag(covariance)
    of_tests = np.maximum(variance[:, None] + variance - 2 * covariance, 0)
    pooled = candidates._replace(of_draws=np.full(60, 1e-3))
    note("critical values", _critical_values(pooled, covariance, of_tests, 4))
    note("confidence set of the best", best_set(d_of_combinations))

    residues = describe_residues(surface, molecule, "one", threads=2)
    note("moments of residues", residues.moments)
    note("fields of residues", residues.fields)
    return out


if __name__ == "__main__":
    sys.exit(main())
