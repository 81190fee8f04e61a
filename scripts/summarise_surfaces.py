"""Summarise all surfaces of a run in one table, with the figure of how many dots are enough."""

from sparsurf_study.workflow.jobs import job
from sparsurf_study.config.conformations import require_conformations, require_excluded
from sparsurf_study.report.summaries import summarise_surfaces

with job(snakemake) as s:
    surfaces = require_conformations(s.input.surfaces)
    require_excluded(s.params.exclude, surfaces[0].parents[2])
    folders = {path.parent: path.parts[-3] in s.params.sampled for path in surfaces}
    summarise_surfaces(folders, s.output.table, s.output.png)
