"""Places of a protein, described on its bound form and searched on the unbound form of a relative, or on its own."""

import numpy as np
import pandas as pd

import sparsurf
from measures import sites
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.pairs.interface import interface
from sparsurf.sites.finding import find_site
from sparsurf.sites.metric import weights
from sparsurf.streams import stream
from sparsurf.workflow.jobs import job


def main(
    bound_path: str,
    partner_path: str,
    relative_path: str,
    table: str,
    family: str,
    query: str,
    relative: str,
    places: int,
    seed: int,
) -> None:
    """Write how often places are found, a row per channels and kind of place, with the weights that the library ships."""
    bound = read_molecule(bound_path)
    unbound, identity = read_molecule(relative_path), 1.0
    if relative != query:
        unbound, identity = sites.numbered_as(unbound, bound)
    dots = sparsurf.surface(bound)
    touching = interface(dots.points, sparsurf.surface(read_molecule(partner_path)).points)
    arrays, _, target, site = sites.forms(
        bound,
        dots,
        touching,
        unbound,
        percents=(sites.MAIN,),
        n=places,
        n_learned=sites.FEW,
        rng=stream(seed, "sites", query, relative),
        everywhere=True,
    )
    columns = {"family": family, "query": query, "relative": relative, "identity": identity}
    columns |= {"there": arrays["share_there"][0], "whole": np.nan}
    if site is not None and len(site) == len(arrays["true_site"]):
        pose = find_site(site, [target], 1).poses[0]
        columns["whole"] = int(sites.off_place(site, pose, arrays["true_site"]) < sites.SAME)
    pd.DataFrame(sites.scores(arrays, weights())).assign(**columns).to_csv(table, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            bound_path=snakemake.input.bound,
            partner_path=snakemake.input.partner,
            relative_path=snakemake.input.relative,
            table=snakemake.output.table,
            family=snakemake.params.family,
            query=snakemake.params.query,
            relative=snakemake.params.relative,
            places=snakemake.params.places,
            seed=snakemake.params.seed,
        )
