"""How often the intervals of a study hold the truth on one surface, over replicates of several designs."""

import numpy as np
import pandas as pd

from measures import coverage
from sparsurf.patches.readings import OF_GRID
from sparsurf.streams import stream
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, name):
    """Write a row per reading, design and range of n_S; confidence sets are made for the default design alone."""
    with np.load(inputs["pool"]) as pool:
        d, member = pool["d"], pool["member"]
    n, parts = settings["replicates"], []
    for r, reading in enumerate(OF_GRID):
        for draws, tests in settings["designs"]:
            rng = stream(0, "coverage", name, r, draws)
            sets = [draws, tests] == settings["default"]
            table = coverage.replicates(d[r], member, draws, tests, n, rng, sets)
            own = {"surface": name, "reading": reading, "draws": draws, "test_dots": tests, "replicates": n}
            parts.append(pd.DataFrame(own | table.to_dict("series")))
    pd.concat(parts).to_csv(outputs["table"], index=False)


if __name__ == "__main__":
    run(main, snakemake)
