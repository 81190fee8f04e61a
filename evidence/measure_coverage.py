"""How often the intervals of a study contain the truth on one surface, over replicates of several designs."""

import numpy as np
import pandas as pd

from measures import coverage
from sparsurf.patches.readings import GRID_READINGS
from sparsurf.streams import stream
from sparsurf_study.workflow.jobs import job

with job(snakemake):
    protein, replicates = snakemake.wildcards.protein, snakemake.params.replicates
    with np.load(snakemake.input.pool) as arrays:
        d, member = arrays["d"], arrays["member"]
    tables = []
    for r, reading in enumerate(GRID_READINGS):
        for draws, test_dots in snakemake.params.designs:
            rng = stream(0, "coverage", protein, r, draws)
            with_sets = [draws, test_dots] == snakemake.params.default  # they take long
            shares = coverage.replicates(d[r], member, draws, test_dots, replicates, rng, with_sets)
            keys = {"surface": protein, "reading": reading, "draws": draws, "test_dots": test_dots}
            tables.append(pd.DataFrame(keys | {"replicates": replicates} | shares.to_dict("series")))
    pd.concat(tables).to_csv(snakemake.output.table, index=False)
