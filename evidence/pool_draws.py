"""Many draws of the combinations of one surface that may be the best: the population that intervals are tested on."""

import numpy as np
import pandas as pd

from measures import coverage
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.patches.readings import GRID_READINGS
from sparsurf.streams import Streams
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    prepared = PreparedSurface(
        read_npz(snakemake.input.surface),
        roughness=pd.read_csv(snakemake.input.roughness)["roughness"].to_numpy(),
        streams=Streams(1, f"coverage of {snakemake.wildcards.protein}"),
        threads=snakemake.threads,
    )
    grid, params = pd.read_csv(snakemake.input.grid), snakemake.params
    d, member = coverage.pool(prepared, grid, GRID_READINGS, params.draws, params.test_dots)
    np.savez(snakemake.output.pool, d=d, member=member)
