"""Table I on all surfaces of the paper: published values next to ours, and whether its choices carry over."""

import pandas as pd

from measures import fragments
from measures.tables import read_tables, write_tables
from sparsurf.views import layout
from sparsurf_study.report.figures.table1 import table1_figure
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    output = snakemake.output
    rows, choices = read_tables(snakemake.input.rows), read_tables(snakemake.input.choices)
    places = pd.read_csv(snakemake.input.places)
    of_study = fragments.rows_of_study(pd.read_csv(snakemake.input.paper_rows))  # of `make paper`
    drawn = table1_figure(places, fragments.rows_to_draw(rows, snakemake.params.repeated))
    layout.save(drawn, output.figure)
    write_tables(
        {
            output.rows: rows,
            output.table1: fragments.table1_of(rows),
            output.inside: fragments.inside_of(pd.concat([rows, of_study], ignore_index=True)),
            output.choices: choices,
            output.surfaces: fragments.surfaces_of(rows, choices),
            output.gathering: pd.read_csv(snakemake.input.gathering),
        }
    )
