"""What rules of the authors' code that the paper's text lacks change on A1."""

from measures import fragments, links
from measures.tables import write_tables
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    params, path = snakemake.params, snakemake.input.structure
    prepared = fragments.prepare(path, params, "rules", snakemake.threads)
    table = links.rules_table(prepared.surface, prepared, params.orders, params.test_dots, params.draws)
    write_tables({snakemake.output.table: table})
