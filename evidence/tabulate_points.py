"""Protocols for points on a surface, over all chains: counts and means."""

import pandas as pd

from measures.tables import read_tables, write_tables
from sparsurf_study.workflow.jobs import job

COUNTS = ["failed", "open", "topology_changed", "differs"]
MEANS = ["density", "distance", "distance_99", "largest", "angle", "cpu_s", "short"]

with job(snakemake):
    rows = read_tables(snakemake.input.tables).astype(dict.fromkeys([*COUNTS, *MEANS], float))
    by = rows.groupby("protocol", sort=False)
    table = pd.DataFrame({"chains": by.size(), "measured": by["distance"].count()})
    table[COUNTS] = by[COUNTS].sum(min_count=1)
    table["repeated"] = by["differs"].count()
    table[MEANS] = by[MEANS].mean()
    table["short_most"] = by["short"].max()
    write_tables({snakemake.output.protocols: table.reset_index()})
