"""Draw the frames of a trajectory in the plane of its first principal components."""

import pandas as pd

from sparsurf_study.workflow.jobs import job
from sparsurf.views import layout
from sparsurf_study.report.figures.frames import figure_of_tables

with job(snakemake) as s:
    tables = {name: pd.read_csv(path) for name, path in s.input.items()}
    drawn = figure_of_tables(**tables, name=s.wildcards.protein)
    for path in s.output:
        layout.save(drawn, path)
