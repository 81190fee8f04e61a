"""d of the published combinations by linking distance and reading, over several surfaces: table and figure."""

from measures.links import draw, readings_table
from measures.tables import read_tables, write_tables
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    table = read_tables(snakemake.input.links)
    write_tables({snakemake.output.table: table, snakemake.output.readings: readings_table(table)})
    draw(table).savefig(snakemake.output.figure, dpi=200, metadata={"Software": None})
