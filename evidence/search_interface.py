"""The interface of one protein, and parts of it, searched on chains of other superfamilies and on its own unbound form."""

import numpy as np

import sparsurf
from measures import unrelated
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.pairs.interface import interface
from sparsurf.sites.describing import load_sites
from sparsurf.streams import stream
from sparsurf.workflow.jobs import job


def main(
    bound: str, partner: str, unbound: str, targets: list[str], table: str, query: str, half: int, seed: int
) -> None:
    """Write a row per part and target."""
    site, other = sparsurf.describe_sites(bound), sparsurf.surface(read_molecule(partner))
    own = sparsurf.describe_sites(unbound, name="own")
    touching = np.flatnonzero(interface(site.points.astype(float), other.points))
    queries = unrelated.parts(site.take(touching), stream(seed, "unrelated", query))
    rows = unrelated.search(queries, [own, *(load_sites(path) for path in targets)])
    rows.assign(protein=query, half=half, same=rows["target"] == "own").to_csv(table, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            bound=snakemake.input.bound,
            partner=snakemake.input.partner,
            unbound=snakemake.input.unbound,
            targets=snakemake.input.targets,
            table=snakemake.output.table,
            query=snakemake.wildcards.query,
            half=snakemake.params.half,
            seed=snakemake.params.seed,
        )
