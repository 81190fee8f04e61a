"""Places of a protein, described on its bound form and on a relative's unbound form: how often they are found there."""

import numpy as np
import pandas as pd

import sparsurf
from measures import sites
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.pairs.interface import interface
from sparsurf.sites.finding import find_site
from sparsurf.sites.weighing import weights
from sparsurf.streams import stream
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, pair):
    """Write a row per channels and kind of place, by the weights that the library ships; `pair` names both, and their family."""
    bound, partner, other = (read_molecule(inputs[key]) for key in ("bound", "partner", "relative"))
    other, identity = sites.numbered_as(other, bound)
    dots = sparsurf.surface(bound)
    touching = interface(dots.points, sparsurf.surface(partner).points)
    rng = stream(settings["seed"], "sites", pair["query"], pair["relative"])
    how = (sites.MAIN,), settings["places"], sites.FEW, rng
    arrays, _, target, site = sites.forms(bound, dots, touching, other, *how)
    table = pd.DataFrame(sites.scores(arrays, weights()))
    known = pair | {"identity": identity, "there": arrays["share_there"][0], "whole": np.nan}
    if site is not None and len(site) == len(arrays["true_site"]):
        pose = find_site(site, [target], 1).poses[0]
        known["whole"] = int(sites.off_place(site, pose, arrays["true_site"]) < sites.SAME)
    table.assign(**known).to_csv(outputs["table"], index=False)


if __name__ == "__main__":
    run(main, snakemake)
