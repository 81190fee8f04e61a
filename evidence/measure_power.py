"""Runs of Table I with one changed rule."""

import numpy as np
import pandas as pd

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.paper.published_runs import centres_in_random_orders, runs_as_published
from sparsurf.sampling import published
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.molecular_surface import surface_of_frame
from sparsurf.surfaces.radii import radii
from sparsurf.workflow.jobs import job, reporter


def main(
    structure: str,
    table: str,
    variant: str,
    surface: dict,
    patches: dict[str, float],
    sampling: dict[str, list[float]],
    rules: dict[str, float],
    runs: int,
    seed: int,
    threads: int,
) -> None:
    """Write the winners of every run and, for each run, the number of centres with the dots in another order.

    `rules` are the changed ones: parameters of the patches, or alpha, a factor on every alpha of the grid.
    """
    molecule = read_molecule(structure)
    dots = surface_of_frame(molecule, 0, radii(molecule, "dms"), surface)
    changed = {key.lower(): value for key, value in rules.items()}
    alpha_factor = changed.pop("alpha", 1.0)
    prepared = PreparedSurface(dots, **patches | changed, seed=seed, name=f"power {variant}", threads=threads)
    combinations = published.parameter_grid(**sampling)
    winners = runs_as_published(
        prepared, combinations, runs, reporter(variant, "runs of the grid"), alpha_factor
    )
    centres = pd.Series(centres_in_random_orders(prepared, runs), index=np.arange(1, runs + 1))
    winners.assign(centres=winners["run"].map(centres)).to_csv(table, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            table=snakemake.output.table,
            variant=snakemake.wildcards.variant,
            surface=snakemake.params.surface,
            patches=snakemake.params.patches,
            sampling=snakemake.params.sampling,
            rules=snakemake.params.rules,
            runs=snakemake.params.runs,
            seed=snakemake.params.seed,
            threads=snakemake.threads,
        )
