"""Close a run in batches: its first page, the figure of its distributions, failures and warnings, and the crate."""

from sparsurf_study.report.closing import close_batches
from sparsurf_study.workflow.job_logs import collected_warnings
from sparsurf_study.workflow.jobs import job

with job(snakemake) as s:
    studied = list(s.input.studied)
    warnings = collected_warnings(studied, s.params.logs, s.params.jobs) if studied else []
    close_batches(s.input.tables, studied, warnings, s.params.exclude, s.output)
