"""Kept dots as centres of patches, over proteins: tables."""

import pandas as pd

from measures import centres
from measures.proteins import prepare_proteins
from measures.tables import write_tables
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    params, out, found = snakemake.params, snakemake.output, []
    for name, prepared in prepare_proteins(params, "centres", snakemake.threads):
        design = params.samplers, params.percents, params.test_dots, params.draws
        found.append(centres.centres_table(prepared, *design).assign(protein=name))
    table = pd.concat(found).set_index("protein").reset_index()
    write_tables({out.table: table, out.means: centres.means(table)})
