"""Close a run in batches: its first page, the figure of its distributions, failures and warnings, and the crate."""

from pathlib import Path

from sparsurf_study.report.closing import close_batches
from sparsurf_study.report.provenance import Origin
from sparsurf_study.workflow.job_logs import collected_warnings
from sparsurf_study.workflow.jobs import job

with job(snakemake) as s:
    studied = list(s.input.studied)
    logs = Path(s.output.page).with_name("logs")
    warnings = collected_warnings(studied, logs, s.params.jobs) if studied else []
    origin = Origin(*s.config["origin"])
    close_batches(
        s.input.tables,
        studied,
        warnings,
        s.params.exclude,
        s.output,
        s.params.lengths,
        origin,
        s.params.minimal,
    )
