"""Close a run: its warnings, its failures, its first page, and a description of all files for archives."""

from sparsurf.report.closing import close_run
from sparsurf.workflow.job_logs import collected_warnings
from sparsurf.workflow.jobs import job

with job(snakemake) as s:
    warnings = collected_warnings(s.input.results, s.params.logs, s.params.jobs)
    close_run(s.input.results, warnings, s.params.exclude, s.output)
