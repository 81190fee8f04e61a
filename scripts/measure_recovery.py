"""Recover surfaces from subsets of many proteins: `python scripts/measure_recovery.py structures docs/tables`.

Reads every structure of a folder (first model, all its polymers), writes recover.csv (a row per protein, sampler and
n_S), recover_floors.csv, recover_means.csv and recover_pairs.csv, and renders recover.md in the folder above, with
recover.png of the embedded example.
Proteins that are in recover.csv already are not measured again.
"""

import argparse
from pathlib import Path

import pandas as pd

from sparsurf import InputError
from sparsurf.molecules.reading import READERS, read_molecule
from sparsurf.recovery.recovering import recover
from sparsurf.report import recovery_page
from sparsurf.report.figures import recovered
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study import recovery
from sparsurf.study.evaluator import Evaluator
from sparsurf.surfaces.making import molecular_surface
from sparsurf.surfaces.radii import radii
from sparsurf.threads import available_cores

EXAMPLE = Path(__file__).parents[1] / "data" / "tdp43" / "topology.pdb"
MOST_ATOMS = 20_000
TESTS = 1000


def main(structures, tables, threads):
    """Measure what is missing, then write the tables."""
    tables = Path(tables)
    tables.mkdir(parents=True, exist_ok=True)
    done = {key: _read(tables / f"recover{key}.csv") for key in ("", "_floors")}
    known = set() if done[""] is None else set(done[""]["protein"])
    for path in sorted(Path(structures).iterdir(), key=lambda path: path.stat().st_size):
        name = path.name.split(".")[0]
        if name in known or not any(end in READERS for end in path.suffixes):
            continue
        try:
            molecule = read_molecule(path, selection=None)
        except InputError as error:
            print(f"{name}: left out, {error}")
            continue
        if molecule.n_atoms > MOST_ATOMS:
            print(f"{name}: left out, {molecule.n_atoms} atoms")
            continue
        floors, subsets = recovery.measure(
            name, molecule.xyz[0], radii(molecule, "dms"), TESTS, threads=threads
        )
        known.add(name)
        for key, part in (("_floors", floors), ("", subsets)):
            done[key] = part if done[key] is None else pd.concat([done[key], part], ignore_index=True)
            done[key].to_csv(tables / f"recover{key}.csv", index=False, float_format="%.5g")
        print(name, flush=True)
    table = pd.read_csv(tables / "recover.csv")
    recovery.means(table).to_csv(tables / "recover_means.csv", index=False, float_format="%.4g")
    pairs = [("adaptive", "farthest"), ("roughness", "uniform")]
    changes = pd.concat([recovery.paired(table, *pair) for pair in pairs], ignore_index=True)
    changes.to_csv(tables / "recover_pairs.csv", index=False, float_format="%.4g")
    stored = (pd.read_csv(tables / f"recover{key}.csv") for key in ("", "_floors", "_means", "_pairs"))
    (tables.parent / "recover.md").write_text(recovery_page.page(*stored), encoding="utf-8")
    _draw(tables.parent / "recover.png", threads)


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
    parser.add_argument("--threads", type=int, default=available_cores())
    wish = parser.parse_args()
    main(wish.structures, wish.tables, wish.threads)
