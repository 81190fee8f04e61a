"""Run one stage of the molecular dynamics: minimisation, NVT, NPT or production."""

import os

from sparsurf_study.workflow.jobs import job, reporter
from sparsurf_study.simulation.protocol import with_defaults
from sparsurf_study.simulation.stages import run_stage

with job(snakemake) as s:
    stage, settings = s.params.stage, with_defaults(s.params.simulate)
    progress = reporter(f"{s.wildcards.protein}: {stage}", "steps")
    finished = run_stage(
        stage,
        s.input.system,
        s.input.before or None,
        settings,
        s.params.seed,
        s.params.unfinished,
        s.threads,
        progress,
    )
    os.replace(finished, s.output.folder)  # only a complete stage lies there
