"""Table I made again as published on one surface: the winners of every run, and the number of centres."""

import numpy as np
import pandas as pd

from measures import fragments
from sparsurf.paper.published_runs import centres_in_random_orders, runs_as_published
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.workflow.jobs import job, reporter


def main(
    structure: str,
    runs: str,
    dots: str,
    surface: dict,
    patches: dict[str, float],
    sampling: dict[str, list[float]],
    n_runs: int,
    seed: int,
    threads: int,
) -> None:
    """Write the winners of every run and, for each run, the number of centres with the dots in another order."""
    settings = {key.lower(): value for key, value in patches.items()}
    prepared = PreparedSurface(
        fragments.dots_of(structure, dots, surface),
        **settings,
        seed=seed,
        name="Table I again",
        threads=threads,
    )
    progress = reporter("Table I", "runs of the grid")
    winners = runs_as_published(prepared, fragments.published_grid(sampling), n_runs, progress)
    centres = pd.Series(centres_in_random_orders(prepared, n_runs), index=np.arange(1, n_runs + 1))
    winners.assign(centres=winners["run"].map(centres)).to_csv(runs, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            runs=snakemake.output.runs,
            dots=snakemake.params.dots,
            surface=snakemake.params.surface,
            patches=snakemake.params.patches,
            sampling=snakemake.params.sampling,
            n_runs=snakemake.params.runs,
            seed=snakemake.params.seed,
            threads=snakemake.threads,
        )
