"""Tabulate the best parameters of all surfaces, and whether they follow mean roughness."""

from sparsurf_study.workflow.jobs import job
from sparsurf_study.config.conformations import require_conformations
from sparsurf_study.report.summaries import summarise_best

with job(snakemake) as s:
    folders = [path.parent for path in require_conformations(s.input.surfaces)]
    summarise_best(folders, s.params.seed, s.output.summary, s.output.relation)
