"""Table I as published, reproduced many times on one surface."""

import numpy as np
import pandas as pd

from sparsurf_study.workflow.jobs import Job, reporter
from measures import fragments
from measures.tables import write_tables
from sparsurf_study.paper.published_runs import (
    centres_in_random_orders,
    place_published_values,
    runs_as_published,
    tests_of_table_1,
)


def measure_repeated(job: Job) -> None:
    """Reproduce Table I as published on one surface: the winners of every run, and the number of centres.

    For each run the centres are counted with the dots in another order.
    """
    params = job.params
    prepared = fragments.prepare(job.input.structure, params, "Table I again", job.threads)
    progress = reporter("Table I", "runs of the grid")
    grid = fragments.published_grid(params.sampling)
    winners = runs_as_published(prepared, grid, params.runs, progress)
    centres = pd.Series(centres_in_random_orders(prepared, params.runs), index=np.arange(1, params.runs + 1))
    winners.assign(centres=winners["run"].map(centres)).to_csv(job.output.runs, index=False)


def tabulate_repeated(job: Job) -> None:
    """Tabulate where the published Table I lies among runs made as published, and whether one more run could have its values."""
    output, again = job.output, pd.read_csv(job.input.repeated)  # winners of the runs
    places, centres = place_published_values(again), again.groupby("run")["centres"].first().to_numpy()
    tests = tests_of_table_1(places, centres)
    write_tables({output.places: places, output.verdict: fragments.verdict_of(places), output.tests: tests})
