"""Summarise the agreement of the maps with the interface, over all pairs of a run."""

from pathlib import Path

from sparsurf_study.workflow.jobs import job
from sparsurf_study.report.summaries import summarise_pairs

with job(snakemake) as s:
    summarise_pairs(map(Path, s.input.tables), s.wildcards.run, s.output.table, s.output.png)
