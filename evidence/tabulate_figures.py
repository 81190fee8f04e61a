"""The paper's Figures 1 to 4 from A1, the numbers behind their statements, and the best combination of each range."""

import json
from pathlib import Path

import pandas as pd

from measures import paper_figures
from measures.pictures import reduce_figure
from measures.tables import write_tables
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    paths, output = snakemake.input, snakemake.output
    bins = pd.read_csv(paths.bins)
    numbers = paper_figures.numbers(
        pd.read_csv(paths.grid),
        json.loads(Path(paths.best).read_text(encoding="utf-8")),
        pd.read_csv(paths.roughness)["roughness"],
        bins,
        pd.read_csv(paths.gathering),
    )
    ranges = paper_figures.ranges_of(pd.read_csv(paths.ranges))
    write_tables({output.table: numbers, output.bins: bins, output.ranges: ranges})
    for figure, copy in zip(paths.figures, output.figures, strict=True):
        reduce_figure(figure, copy)
