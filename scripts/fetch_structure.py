"""Fetch a structure from the network, and record where it came from."""

from sparsurf_study.workflow.jobs import job
from sparsurf_study.config.download import fetch

with job(snakemake) as s:
    fetch(s.params.url, s.params.sha256, s.output.structure, s.output.record, s.params.name)
