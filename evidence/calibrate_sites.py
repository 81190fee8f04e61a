"""How high unrelated proteins score for a site: constants fitted on one half of the complexes, checked on the other."""

import numpy as np
import pandas as pd

from measures import sites
from measures.tables import store
from sparsurf.sites.finding import chance
from sparsurf.streams import stream
from sparsurf.workflow.jobs import run

LEVELS = (0.01, 0.05, 0.1, 0.25, 0.5)


def main(inputs, outputs, forms, seed):
    """Write how often p is below some levels (in %) on each half, and the constants of the first, which the library ships."""
    names, half, _, targets, queries, learned = sites.halves(inputs, forms)
    table = sites.null_scores(names, half, queries, targets, learned, stream(seed, "sites", "null"))
    rows, constants = [], {}
    for own, other in ((1, 2), (2, 1)):
        constants[own] = sites.fitted_null(table[(table["half"] == own) & ~table["same"]])
        held_out = table[table["half"] == other]
        p = chance(held_out["score"].to_numpy(), held_out[sites.TERMS].to_numpy(), constants[own])
        for same, of_one in held_out.assign(p=p).groupby("same"):
            row = {"fitted_on": own, "protein": "the same" if same else "unrelated", "searches": len(of_one)}
            rows.append(row | {f"below_{100 * level:g}": (of_one["p"] < level).mean() for level in LEVELS})
    store({"sites_chance": pd.DataFrame(rows)}, outputs, "%.4g")
    header = ",".join([*(f"location_{term}" for term in sites.TERMS), "width_one", "width_spread"])
    np.savetxt(outputs["null"], constants[1][None], "%.5g", ",", header=header, comments="")


if __name__ == "__main__":
    run(main, snakemake)
