"""Propensity and references of one complex, and against a partner of another one."""

import pandas as pd

from measures.partners import pair_of, unbound_pair
from sparsurf.pairs.complex_scores import centres_of, score_complex
from sparsurf.pairs.matching import Recipe, descriptors_at
from sparsurf.patches.descriptors import PUBLISHED
from sparsurf.workflow.jobs import run

RADII = (6.0, 12.0)  # Å, R_zernike; the first is the published one


def main(inputs, outputs, settings, pair, descriptor, threads):
    """Write the areas of all scores, the patches in contact, and the control against another partner."""
    recipes = [Recipe(descriptor, radius) for radius in (RADII if descriptor == PUBLISHED else RADII[:1])]
    form, labels, most = "unbound" if "bound" in inputs else "bound", None, settings["patches"]
    name = pair.removesuffix("_u")
    if form == "unbound":
        partners, labels = unbound_pair(inputs["own"], inputs["bound"], name)
    else:
        partners = pair_of(inputs["own"], name)
    others = (
        _descriptors(pair_of(inputs["other"], "other"), recipes[0], most, threads)
        if "other" in inputs
        else None
    )
    table, touching, _, same = score_complex(partners, others, labels, recipes, most=most, threads=threads)
    own = {"complex": name, "form": form}
    table.assign(**own).to_csv(outputs["areas"], index=False)
    contacts = pd.DataFrame() if touching is None else touching
    contacts.assign(**own, descriptor=descriptor).to_csv(outputs["contacts"], index=False)
    control = own | {"correlation_1": same[0], "correlation_2": same[1], "descriptor": descriptor}
    pd.DataFrame([control]).to_csv(outputs["control"], index=False)


def _descriptors(pair, recipe, most, threads):
    """'Up' descriptors of a first partner and 'down' ones of the second."""
    places = [one.surface.points[centres_of(one, most)] for one in pair]
    asked = zip(pair, places, (True, False), strict=True)
    return tuple(descriptors_at(one, at, up, recipe, threads)[0] for one, at, up in asked)


if __name__ == "__main__":
    run(main, snakemake)
