"""What roughness contributes to d of Table I over proteins: tables and figure."""

from measures import null_result
from measures.tables import read_tables, write_tables
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    table, out, paper = read_tables(snakemake.input.tables), snakemake.output, snakemake.params.paper
    write_tables({out.table: table, out.means: null_result.means(table, paper)})
    null_result.draw(table, paper).savefig(out.figure, dpi=200, metadata={"Software": None})
