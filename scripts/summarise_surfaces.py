"""Summarise all surfaces of a run in one table, with the figure of how many dots are enough."""

from pathlib import Path

from sparsurf_study.report.summaries import summarise_surfaces
from sparsurf_study.workflow.jobs import job

with job(snakemake) as s:
    folders = {Path(path).parent: Path(path).parts[-3] in s.params.sampled for path in s.input.surfaces}
    summarise_surfaces(folders, s.output.table, s.output.png)
