"""How d changes without single rules of the authors' code that the paper's text lacks."""

from sparsurf_study.workflow.jobs import Job
from measures import fragments, links
from measures.tables import write_tables


def measure_rules(job: Job) -> None:
    """Measure what rules of the authors' code that the paper's text lacks change on A1."""
    params, path = job.params, job.input.structure
    prepared = fragments.prepare(path, params, "rules", job.threads)
    table = links.rules_table(prepared.surface, prepared, params.orders, params.test_dots, params.draws)
    write_tables({job.output.table: table})
