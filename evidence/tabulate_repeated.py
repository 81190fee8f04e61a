"""Where the published values of Table I lie among runs made as published, and whether they could be those of one more run."""

import pandas as pd

from measures import fragments
from measures.tables import write_tables
from sparsurf_study.paper.published_runs import place_published_values, tests_of_table_1
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    output, again = snakemake.output, pd.read_csv(snakemake.input.repeated)  # winners of the runs
    places, centres = place_published_values(again), again.groupby("run")["centres"].first().to_numpy()
    tests = tests_of_table_1(places, centres)
    write_tables({output.places: places, output.verdict: fragments.verdict_of(places), output.tests: tests})
