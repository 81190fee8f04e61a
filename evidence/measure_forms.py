"""Places of both partners of a complex, described on their bound and on their unbound forms."""

import numpy as np
import pandas as pd

import sparsurf
from measures import sites
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.pairs.interface import interface
from sparsurf.streams import stream
from sparsurf.workflow.jobs import job

COSTS = ["protein", "atoms", "percent", "dots", "places", "bytes", "seconds"]


def main(
    bound: list[str],
    unbound: list[str],
    numbers_paths: list[str],
    target_paths: list[str],
    site_paths: list[str],
    costs_path: str,
    form: str,
    percents: list[float],
    places: int,
    learned: int,
    seed: int,
) -> None:
    """Write the numbers, the Sites of the unbound forms and of the bound interfaces, and the cost of describing them."""
    bound_molecules = [read_molecule(path) for path in bound]
    unbound_molecules = [read_molecule(path) for path in unbound]
    dots = [sparsurf.surface(molecule) for molecule in bound_molecules]
    rows = []
    for side in (0, 1):
        name = f"{form}_{'rl'[side]}"
        arrays, costs, target, site = sites.forms(
            bound_molecules[side],
            dots[side],
            interface(dots[side].points, dots[1 - side].points),
            unbound_molecules[side],
            percents,
            places,
            learned,
            stream(seed, "sites", name),
        )
        np.savez(numbers_paths[side], **arrays)
        target.save(target_paths[side])
        (target.take([]) if site is None else site).save(site_paths[side])
        rows += [(name, unbound_molecules[side].n_atoms, *cost) for cost in costs]
    pd.DataFrame(rows, columns=COSTS).to_csv(costs_path, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            bound=snakemake.input.bound,
            unbound=snakemake.input.unbound,
            numbers_paths=snakemake.output.numbers,
            target_paths=snakemake.output.targets,
            site_paths=snakemake.output.sites,
            costs_path=snakemake.output.costs,
            form=snakemake.wildcards.form,
            percents=snakemake.params.percents,
            places=snakemake.params.places,
            learned=snakemake.params.learned,
            seed=snakemake.params.seed,
        )
