"""How often unrelated proteins score as high as a site: constants are fitted on half of the proteins and checked on the rest."""

import numpy as np

from measures import unrelated
from measures.tables import read_tables, write_tables
from sparsurf.workflow.jobs import job


def main(tables: list[str], searches: str, sites_chance: str, null: str) -> None:
    """Write all searches with p, its shares below some levels, and the constants of all searches for the library."""
    table = read_tables(tables)
    tested, _ = unrelated.held_out(table)
    write_tables({searches: tested, sites_chance: unrelated.shares(tested)}, "%.4g")
    constants = unrelated.fit(table[~table["same"]])
    np.savetxt(null, constants[None], "%.5g", ",", header="log_width,of_places,of_score", comments="")


if __name__ == "__main__":
    with job(snakemake):
        main(
            tables=snakemake.input.tables,
            searches=snakemake.output.searches,
            sites_chance=snakemake.output.sites_chance,
            null=snakemake.output.null,
        )
