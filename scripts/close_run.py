"""Close a run: its warnings, its failures, its first page, and a description of all files for archives."""

from pathlib import Path

from sparsurf_study.report.closing import close_run
from sparsurf_study.report.provenance import Origin
from sparsurf_study.workflow.job_logs import collected_warnings
from sparsurf_study.workflow.jobs import job

with job(snakemake) as s:
    warnings = collected_warnings(s.input.results, Path(s.output.page).with_name("logs"), s.params.jobs)
    origin = Origin(*s.config["origin"])
    close_run(
        s.input.results, warnings, s.params.exclude, s.output, s.params.lengths, origin, s.params.minimal
    )
