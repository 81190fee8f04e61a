"""Z of random clumps and of other subsets of the same size, on several surfaces: tables."""

import pandas as pd

from measures import clumps
from measures.proteins import prepare_proteins
from measures.tables import write_tables
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    params, out, found = snakemake.params, snakemake.output, []
    for name, prepared in prepare_proteins(params, "clumps", snakemake.threads):
        of_surface = clumps.clumps_table(prepared, params.rows, params.radii, params.test_dots, params.draws)
        found.append(of_surface.assign(surface=name))
    table = pd.concat(found).set_index("surface").reset_index()
    write_tables({out.table: table, out.means: clumps.means(table)})
