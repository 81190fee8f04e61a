"""How far a turn and fresh dots move each descriptor on one structure, and what each makes of the paper's tables."""

import pandas as pd

from measures import steadiness
from measures.molecules import atoms_of
from sparsurf.patches.index import D_LINK
from sparsurf.sampling import law
from sparsurf.streams import stream
from sparsurf.study.evaluator import Evaluator
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, name, threads):
    """Write a table for each question."""
    xyz, r = atoms_of(inputs["structure"])
    seed, n_tests = settings["seed"], settings["test_dots"]
    surface = molecular_surface(xyz, r)
    tests = surface.points[stream(seed, name, "tests").permutation(len(surface))[:n_tests]]

    def moved(density, d_link):
        turns = stream(seed, name, "turns")
        return steadiness.steadiness(xyz, r, tests, turns, density, d_link, threads)

    by_density = [moved(density, D_LINK) for density in settings["densities"]]
    linked = {D_LINK: by_density[0][0]} | {link: moved(DENSITY, link)[0] for link in settings["D_link"]}
    evaluator = Evaluator(surface, seed=seed, name=name, threads=threads)
    tables = {
        "changes": pd.concat([changes for changes, _ in by_density]),
        "orders": pd.concat([orders for _, orders in by_density]),
        "linked": pd.concat([changes.assign(D_link=link) for link, changes in linked.items()]),
        "rows": steadiness.rows_of_paper(evaluator, n_tests),
        "samplers": steadiness.of_samplers(evaluator, n_tests, settings["percents"]),
        "grid": steadiness.whole_grid(
            evaluator, law.grid(**settings["sampling"]), settings["grid_test_dots"]
        ),
    }
    for key, table in tables.items():
        table.assign(surface=name).to_csv(outputs[key], index=False)


if __name__ == "__main__":
    run(main, snakemake)
