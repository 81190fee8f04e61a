"""Table I reproduced as published on one surface: the winners of every run, and the number of centres.

For each run the centres are counted with the dots in another order.
"""

import numpy as np
import pandas as pd

from measures import fragments
from sparsurf_study.paper.published_runs import centres_in_random_orders, runs_as_published
from sparsurf_study.workflow.jobs import job, reporter

with job(snakemake):
    params = snakemake.params
    prepared = fragments.prepare(snakemake.input.structure, params, "Table I again", snakemake.threads)
    progress = reporter("Table I", "runs of the grid")
    grid = fragments.published_grid(params.sampling)
    winners = runs_as_published(prepared, grid, params.runs, progress)
    centres = pd.Series(centres_in_random_orders(prepared, params.runs), index=np.arange(1, params.runs + 1))
    winners.assign(centres=winners["run"].map(centres)).to_csv(snakemake.output.runs, index=False)
