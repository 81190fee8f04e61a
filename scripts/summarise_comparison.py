"""Summarise the comparison of samplers at equal n_S over all conformations and proteins of a study."""

from sparsurf_study.workflow.jobs import job
from sparsurf_study.config.conformations import require_conformations
from sparsurf_study.report.summaries import summarise_comparison

with job(snakemake) as s:
    summarise_comparison(require_conformations(s.input.tables), s.output.table, s.output.png)
