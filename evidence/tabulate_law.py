"""The law of the error by density: tables and figure."""

from measures import law
from measures.tables import read_tables, write_tables
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    table, out = law.in_order(read_tables(snakemake.input.errors)), snakemake.output
    fits = law.fits(table)
    write_tables({out.table: table, out.fits: fits, out.by_density: law.by_density(table)})
    parts = law.by_part(read_tables(snakemake.input.parts))
    write_tables({out.required: law.required(table, fits), out.by_part: parts})
    law.draw(table).savefig(out.figure, dpi=200, metadata={"Software": None})
