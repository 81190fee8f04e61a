"""Compare the descriptors: `python scripts/measure_descriptors.py docs A1=A1.pdb c1=results/default/tdp43/structures/c1.pdb`.

For each structure, by name: how far a turn and fresh dots move each descriptor, by order; Table I, the whole grid and
the samplers under each. Writes docs/tables/descriptors_*.csv, docs/descriptors.md and its two figures.
"""

import sys
from pathlib import Path

import pandas as pd

from sparsurf import InputError
from sparsurf.molecules.reading import read_molecule
from sparsurf.patches.index import D_LINK
from sparsurf.report.descriptors_page import TABLES, descriptors_markdown
from sparsurf.report.figures import descriptors_figures
from sparsurf.streams import stream
from sparsurf.study import steadiness
from sparsurf.study.evaluator import Evaluator
from sparsurf.surfaces.making import DENSITY, molecular_surface
from sparsurf.surfaces.radii import radii
from sparsurf.threads import available_cores
from sparsurf.workflow.config import check

SEED, N_TESTS = 20261120, 400
DENSITIES = (DENSITY, 20.0)
LONGER = (0.55, 0.6, 0.8)  # Å, D_link beside the published one


def measure(name, path, threads):
    """Dict of tables of one structure."""
    molecule = read_molecule(path)
    xyz, r = molecule.xyz[0], radii(molecule)
    surface = molecular_surface(xyz, r)
    tests = surface.points[stream(SEED, name, "tests").permutation(len(surface))[:N_TESTS]]
    moved = [
        steadiness.steadiness(xyz, r, tests, stream(SEED, name, "turns"), density, threads=threads)
        for density in DENSITIES
    ]
    linked = {D_LINK: moved[0][0]}
    for link in LONGER:
        turns = stream(SEED, name, "turns")
        linked[link], _ = steadiness.steadiness(xyz, r, tests, turns, d_link=link, threads=threads)
    evaluator = Evaluator(surface, seed=SEED, name=name, threads=threads)
    law = check({"proteins": {name: {"structure": str(path)}}})["sampling"]
    tables = {
        "changes": pd.concat([changes for changes, _ in moved]),
        "orders": pd.concat([orders for _, orders in moved]),
        "linked": pd.concat([changes.assign(D_link=link) for link, changes in linked.items()]),
        "rows": steadiness.rows_of_paper(evaluator, N_TESTS),
        "samplers": steadiness.of_samplers(evaluator, N_TESTS),
        "grid": steadiness.whole_grid(evaluator, [law[key] for key in ("alpha", "beta", "gamma", "delta")]),
    }
    return {key: table.assign(surface=name) for key, table in tables.items()}


def main(path_to_docs, *structures):
    """Measure every NAME=FILE and write tables, page and figures; without any, write page and figures anew."""
    docs = Path(path_to_docs)
    (docs / "tables").mkdir(parents=True, exist_ok=True)
    found = [measure(*each.split("=", 1), available_cores()) for each in structures]
    for key in TABLES if found else ():
        table = pd.concat([tables[key] for tables in found])
        table.to_csv(docs / "tables" / f"descriptors_{key}.csv", index=False, float_format="%.5g")
    stored = {key: pd.read_csv(docs / "tables" / f"descriptors_{key}.csv") for key in TABLES}
    (docs / "descriptors.md").write_text(descriptors_markdown(stored), encoding="utf-8")
    save_png(descriptors_figures.steadiness(stored), docs / "descriptors_steadiness.png")
    save_png(descriptors_figures.samplers(stored), docs / "descriptors_samplers.png")


def save_png(figure, path):
    """Write a figure for the page."""
    figure.savefig(path, dpi=200, metadata={"Software": None})


if __name__ == "__main__":
    if not sys.argv[1:]:
        sys.exit(__doc__.splitlines()[0])
    try:
        main(*sys.argv[1:])
    except InputError as error:
        sys.exit(str(error))
