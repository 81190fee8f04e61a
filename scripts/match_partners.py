"""Both partners of a pair matched: propensity of every dot, best-matching patches, agreement with the interface."""

import pandas as pd

from sparsurf.pairs import matching
from sparsurf.report.page import write
from sparsurf.report.pair_page import TEMPLATE, pair_page
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf.workflow.jobs import run
from sparsurf.workflow.partner_files import SIDES, names_of, partners, recipe_of, requested_centres


def main(inputs, outputs, settings, pair, name, threads):
    """Write propensity.csv, best_pairs.csv, agreement.csv, contacts.csv, a page and two coloured surfaces."""
    rules, recipe = settings["complementarity"], recipe_of(settings)
    both = partners(inputs, settings, name, threads)
    centres = [requested_centres(each, settings) for each in both]
    found = matching.match(*both, centres, rules["nearest"], recipe, threads)
    dots, agreed = [], []
    for place, side in enumerate(SIDES):
        maps = matching.maps(found, place, rules["smoothing"], threads)
        table = matching.by_dot(found, place, maps, rules["interface"])
        table.insert(0, "partner", int(side))
        dots.append(table)
        areas = matching.agreement(
            found, place, maps, rules["interface"], seed=settings["seed"], threads=threads
        )
        if areas is not None:
            areas.insert(0, "partner", int(side))
            agreed.append(areas)
        columns = {key: table[key].to_numpy() for key in ("similarity_smoothed", "interface")}
        write_ply(
            outputs[f"ply_{side}"],
            both[place].surface,
            table["propensity_smoothed"].to_numpy(),
            "propensity",
            columns,
        )
    touching = matching.contacts(*both, rules["interface"], recipe, settings["seed"], threads)
    best = matching.best_pairs(found)
    agreement = pd.concat(agreed) if agreed else pd.DataFrame(columns=matching.AREAS)
    contacts = pd.DataFrame(columns=matching.CONTACTS) if touching is None else touching
    pd.concat(dots).to_csv(outputs["dots"], index=False, float_format="%.6g")
    best.to_csv(outputs["best"], index=False)
    agreement.to_csv(outputs["agreement"], index=False)
    contacts.to_csv(outputs["contacts"], index=False)
    bare = [side for side, each in zip(SIDES, both, strict=True) if each.residues is None]
    page = pair_page(name, agreement, contacts, best, settings, names_of(pair), bare)
    write(outputs["page"], TEMPLATE, **page)


if __name__ == "__main__":
    run(main, snakemake)
