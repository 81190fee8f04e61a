"""How many dots are enough on several surfaces, and the coverage of the interval."""

from measures.tables import read_tables, write_tables
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    write_tables(
        {
            snakemake.output.table: read_tables(snakemake.input.tables),
            snakemake.output.coverage: read_tables(snakemake.input.coverage),
        }
    )
