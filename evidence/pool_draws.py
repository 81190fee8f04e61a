"""Many draws of the combinations of one surface that may be the best: the population that intervals are tested on."""

import numpy as np
import pandas as pd

from measures import coverage
from sparsurf.patches.readings import GRID_READINGS
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import job


def main(
    surface: str,
    roughness: str,
    grid: str,
    pool: str,
    protein: str,
    draws: int,
    test_dots: int,
    threads: int,
) -> None:
    """Write d of every contender, draw and test dot, and the range of each contender."""
    prepared = PreparedSurface(
        read_npz(surface),
        roughness_values=pd.read_csv(roughness)["roughness"].to_numpy(),
        seed=1,
        name=f"coverage of {protein}",
        threads=threads,
    )
    d, member = coverage.pool(prepared, pd.read_csv(grid), GRID_READINGS, draws, test_dots)
    np.savez(pool, d=d, member=member)


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface=snakemake.input.surface,
            roughness=snakemake.input.roughness,
            grid=snakemake.input.grid,
            pool=snakemake.output.pool,
            protein=snakemake.wildcards.protein,
            draws=snakemake.params.draws,
            test_dots=snakemake.params.test_dots,
            threads=snakemake.threads,
        )
