"""Z on the full surface against the holes and the number of dots of a subset, on several surfaces: tables."""

import pandas as pd

from measures import holes
from measures.proteins import prepare_proteins
from measures.tables import write_tables
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    params, out, found = snakemake.params, snakemake.output, []
    for name, prepared in prepare_proteins(params, "holes", snakemake.threads):
        design = params.samplers, params.percents, params.test_dots, params.draws
        found.append(holes.holes_table(prepared, *design).assign(surface=name))
    table = pd.concat(found).set_index("surface").reset_index()
    write_tables({out.table: table, out.fits: holes.fits(table)})
