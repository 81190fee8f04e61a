"""Scores of unrelated proteins for a site: constants are fitted on one half of the complexes and checked on the other."""

import numpy as np
import pandas as pd

from measures import sites
from measures.tables import write_tables
from sparsurf.sites.finding import chance
from sparsurf.streams import stream
from sparsurf.workflow.jobs import job

LEVELS = (0.01, 0.05, 0.1, 0.25, 0.5)


def main(
    numbers_paths: list[str],
    target_paths: list[str],
    site_paths: list[str],
    sites_chance: str,
    null: str,
    forms: list[str],
    seed: int,
) -> None:
    """Write how often p is below each level (in %) on each half, and the constants of the first half for the library."""
    names, half, _, targets, queries, learned = sites.halves(numbers_paths, target_paths, site_paths, forms)
    table = sites.null_scores(names, half, queries, targets, learned, stream(seed, "sites", "null"))
    rows, constants = [], {}
    for fitted, tested in ((1, 2), (2, 1)):
        constants[fitted] = sites.fitted_null(table[(table["half"] == fitted) & ~table["same"]])
        held_out = table[table["half"] == tested]
        p = chance(held_out["score"].to_numpy(), held_out[sites.TERMS].to_numpy(), constants[fitted])
        for same, part in held_out.assign(p=p).groupby("same"):
            row = {"fitted_on": fitted, "protein": "the same" if same else "unrelated", "searches": len(part)}
            rows.append(row | {f"below_{100 * level:g}": (part["p"] < level).mean() for level in LEVELS})
    write_tables({sites_chance: pd.DataFrame(rows)}, "%.4g")
    header = ",".join([*(f"location_{term}" for term in sites.TERMS), "width_one", "width_spread"])
    np.savetxt(null, constants[1][None], "%.5g", ",", header=header, comments="")


if __name__ == "__main__":
    with job(snakemake):
        main(
            numbers_paths=snakemake.input.numbers,
            target_paths=snakemake.input.targets,
            site_paths=snakemake.input.sites,
            sites_chance=snakemake.output.sites_chance,
            null=snakemake.output.null,
            forms=snakemake.params.forms,
            seed=snakemake.params.seed,
        )
