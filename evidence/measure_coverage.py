"""How often the intervals of a study contain the truth on one surface, over replicates of several designs."""

import numpy as np
import pandas as pd

from measures import coverage
from sparsurf.patches.readings import GRID_READINGS
from sparsurf.streams import stream
from sparsurf.workflow.jobs import job


def main(
    pool: str, table: str, protein: str, replicates: int, designs: list[list[int]], default: list[int]
) -> None:
    """Write a row per reading, design (draws, test dots) and range of n_S; only the default design has confidence sets."""
    with np.load(pool) as arrays:
        d, member = arrays["d"], arrays["member"]
    tables = []
    for r, reading in enumerate(GRID_READINGS):
        for draws, test_dots in designs:
            rng = stream(0, "coverage", protein, r, draws)
            with_sets = [draws, test_dots] == default
            shares = coverage.replicates(d[r], member, draws, test_dots, replicates, rng, with_sets)
            keys = {"surface": protein, "reading": reading, "draws": draws, "test_dots": test_dots}
            tables.append(pd.DataFrame(keys | {"replicates": replicates} | shares.to_dict("series")))
    pd.concat(tables).to_csv(table, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            pool=snakemake.input.pool,
            table=snakemake.output.table,
            protein=snakemake.wildcards.protein,
            replicates=snakemake.params.replicates,
            designs=snakemake.params.designs,
            default=snakemake.params.default,
        )
