"""Where the dots that the paper's sampling keeps lie: Figure 5 of the paper."""

from sparsurf_study.workflow.jobs import Job
from measures import fragments
from measures.figures import reduce_figure
from sparsurf.sampling.combination import Combination
from sparsurf.surfaces.surface import Surface
from sparsurf.views import layout
from sparsurf_study.paper.replication import GATHERED
from sparsurf_study.report.figures import subsets


def draw_gathering(job: Job) -> None:
    """Draw Figure 5 of the paper from A1: the surface, two combinations of the paper, and random subsets of the same size."""
    params, path = job.params, job.output.figure
    prepared = fragments.prepare(job.input.structure, params, "gathering", job.threads)
    cells = []
    for combination in GATHERED:
        name = str(Combination(*combination))
        sampled, uniform = (
            Surface(prepared.points[kept], prepared.normals[kept]) for kept in prepared.pair(combination, 0)
        )
        cells.append((f"the paper's sampling, {name}", sampled, layout.SAMPLED))
        cells.append(("random subset of the same size", uniform, layout.RANDOM))
    drawn = subsets.figure(Surface(prepared.points, prepared.normals), cells)
    layout.save(drawn, path)
    reduce_figure(path, path)
