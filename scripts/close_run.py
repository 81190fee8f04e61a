"""Close a run: its warnings, its failures, its first page, and a description of all files for archives."""

from dataclasses import replace

from sparsurf_study.workflow.jobs import job
from sparsurf_study.report.closing import close_run
from sparsurf_study.report.provenance import RunOrigin
from sparsurf_study.workflow.code import libraries
from sparsurf_study.workflow.job_logs import collected_warnings

with job(snakemake) as s:
    results = list(s.input.results)
    warnings = collected_warnings(results, s.run / "logs", s.params.jobs)
    origin = replace(RunOrigin(*s.config["origin"]), libraries=libraries())
    close_run(
        s.run, results, warnings, s.params.exclude, s.output, s.params.lengths, origin, s.params.minimal
    )
