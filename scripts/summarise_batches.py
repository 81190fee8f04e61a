"""Close a run in batches: its first page, the figure of its distributions, failures and warnings, and the crate."""

from dataclasses import replace

from sparsurf_study.workflow.jobs import job
from sparsurf_study.report.closing import close_batches
from sparsurf_study.report.provenance import RunOrigin
from sparsurf_study.workflow.code import libraries
from sparsurf_study.workflow.job_logs import collected_warnings

with job(snakemake) as s:
    studied = list(s.input.studied)
    warnings = collected_warnings(studied, s.run / "logs", s.params.jobs) if studied else []
    origin = replace(RunOrigin(*s.config["origin"]), libraries=libraries())
    close_batches(
        s.run,
        s.input.tables,
        studied,
        warnings,
        s.params.exclude,
        s.output,
        s.params.lengths,
        origin,
        s.params.minimal,
    )
