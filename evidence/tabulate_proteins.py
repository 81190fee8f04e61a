"""Tables and figures of the study of many proteins."""

import pandas as pd

from measures.protein_figures import FIGURES
from measures.protein_tables import tables_of
from measures.studies import read_study, sizes
from measures.tables import write_tables
from sparsurf.recovery.readings import RECOVERED
from sparsurf_study.workflow.jobs import job

GZIP = {"method": "gzip", "mtime": 0}  # the same bytes for the same table

with job(snakemake):
    params, output = snakemake.params, snakemake.output
    summary = pd.read_csv(snakemake.input.summary)
    summary["best_set"] = summary["best_set"].fillna("")
    relation = pd.read_csv(snakemake.input.relation)
    surfaces = pd.read_csv(snakemake.input.surfaces).merge(sizes(params.run, params.proteins))
    surfaces = surfaces.assign(hydrogens=params.hydrogens)
    tables = tables_of(
        read_study(params.run, params.proteins),
        summary,
        relation,
        surfaces,
        read_study(params.run_recovered, params.recovered, RECOVERED),
    )
    write_tables({output[name]: table for name, table in tables.items()})
    stored = {name: pd.read_csv(output[name]) for name in tables}
    for name, table in (("summary", summary), ("relation", relation), ("surfaces", surfaces)):
        compression = GZIP if output[name].endswith(".gz") else None
        table.to_csv(output[name], index=False, float_format="%.5g", compression=compression)
        stored[name] = pd.read_csv(output[name])
    for name, draw in FIGURES.items():
        draw(stored).savefig(output[f"figure_{name}"], dpi=200, metadata={"Software": None})
