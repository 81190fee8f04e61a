"""Match both partners of a pair: propensity of every dot, best-matching patches, agreement with the interface."""

import pandas as pd

from sparsurf.pairs import matching
from sparsurf.pairs.matching import NEAREST, Recipe
from sparsurf.pairs.partner_files import read_partners, select_centres
from sparsurf.rounding import write_table
from sparsurf.settings import Patches, Settings
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf.workflow.jobs import job


def main(
    surface_1: str,
    surface_2: str,
    structure_1: str | None,
    structure_2: str | None,
    dots: str,
    best: str,
    agreement: str,
    contacts: str,
    ply_1: str,
    ply_2: str,
    patches: dict,
    centres: str | dict,
    smoothing: float,
    interface: float,
    seed: int,
    name: str,
    threads: int = 1,
) -> None:
    """Write the tables of a pair and two coloured surfaces.

    Parameters
    ----------
    structure_1, structure_2 : None for a ready surface
    dots, best, agreement, contacts : tables to be written
    patches : dict, the section `patches` of the config
    centres, smoothing, interface : see the section `complementarity` of the config
    name : of the pair
    """
    partners = read_partners(surface_1, surface_2, structure_1, structure_2, patches["D_link"], name)
    recipe = Recipe(patches["descriptor"], patches["R_zernike"])
    settings = Settings(patches=Patches(**patches))
    selected = [select_centres(partner, centres, settings, seed, threads) for partner in partners]
    match = matching.match(*partners, selected, NEAREST, recipe, threads)
    dot_tables, area_tables = [], []
    for position, (partner, ply) in enumerate(zip(partners, (ply_1, ply_2), strict=True)):
        maps = matching.maps(match, position, smoothing, threads)
        table = matching.by_dot(match, position, maps, interface)
        table.insert(0, "partner", position + 1)
        dot_tables.append(table)
        areas = matching.agreement(match, position, maps, interface, seed=seed, threads=threads)
        if areas is not None:
            areas.insert(0, "partner", position + 1)
            area_tables.append(areas)
        columns = {key: table[key].to_numpy() for key in ("similarity_smoothed", "interface")}
        write_ply(ply, partner.surface, table["propensity_smoothed"].to_numpy(), "propensity", columns)
    best_table = matching.best_pairs(match)
    agreement_table = pd.concat(area_tables) if area_tables else pd.DataFrame(columns=matching.AREAS)
    contact_table = matching.contacts(*partners, interface, recipe, seed, threads)
    if contact_table is None:
        contact_table = pd.DataFrame(columns=matching.CONTACTS)
    pd.concat(dot_tables).to_csv(dots, index=False, float_format="%.6g")
    write_table(best, best_table)
    write_table(agreement, agreement_table)
    write_table(contacts, contact_table)


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface_1=snakemake.input.surface_1,
            surface_2=snakemake.input.surface_2,
            structure_1=snakemake.input.get("structure_1"),
            structure_2=snakemake.input.get("structure_2"),
            dots=snakemake.output.dots,
            best=snakemake.output.best,
            agreement=snakemake.output.agreement,
            contacts=snakemake.output.contacts,
            ply_1=snakemake.output.ply_1,
            ply_2=snakemake.output.ply_2,
            patches=snakemake.params.patches,
            centres=snakemake.params.centres,
            smoothing=snakemake.params.smoothing,
            interface=snakemake.params.interface,
            seed=snakemake.params.seed,
            name=snakemake.wildcards.pair,
            threads=snakemake.threads,
        )
