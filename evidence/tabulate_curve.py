"""d over the link in spacings of the kept dots, over several surfaces: tables and figure."""

from measures import curve
from measures.tables import read_tables, write_tables
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    table, out = read_tables(snakemake.input.curves), snakemake.output
    write_tables({out.table: table, out.numbers: curve.numbers(table)})
    write_tables({out.shares: curve.by_share(table), out.signs: curve.signs(table)})
    curve.draw(table, snakemake.params.marked).savefig(out.figure, dpi=200, metadata={"Software": None})
