"""Tabulate the best parameters of all surfaces, and whether they follow mean roughness."""

from pathlib import Path

from sparsurf_study.report.summaries import summarise_best
from sparsurf_study.workflow.jobs import job

with job(snakemake) as s:
    folders = [Path(path).parent for path in s.input.surfaces]
    summarise_best(folders, s.params.seed, s.output.summary, s.output.relation)
