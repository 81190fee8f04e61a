"""Match both partners of a pair: propensity of every dot, best-matching patches, agreement with the interface."""

import pandas as pd

from sparsurf.pairs import matching
from sparsurf.pairs.matching import Recipe
from sparsurf.pairs.partner_files import partner_labels, read_partners, select_centres
from sparsurf.report.page import write
from sparsurf.report.pair_page import TEMPLATE, pair_page
from sparsurf.rounding import write_table
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
    page: str,
    pair: dict,
    patches: dict,
    centres: str | dict,
    nearest: int,
    smoothing: float,
    interface: float,
    seed: int,
    name: str,
    threads: int = 1,
) -> None:
    """Write the tables of a pair, its page and two coloured surfaces.

    Parameters
    ----------
    structure_1, structure_2 : None for a ready surface
    dots, best, agreement, contacts : tables to be written
    pair : dict, the entry of `pairs` in the config
    patches : dict, the section `patches` of the config
    centres, nearest, smoothing, interface : see the section `complementarity` of the config
    name : of the pair
    """
    partners = read_partners(surface_1, surface_2, structure_1, structure_2, patches, name, threads)
    recipe = Recipe(patches["descriptor"], patches["R_zernike"])
    selected = [select_centres(partner, centres, seed) for partner in partners]
    match = matching.match(*partners, selected, nearest, recipe, threads)
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
    sides_without_atoms = [str(side) for side, partner in enumerate(partners, 1) if partner.residues is None]
    facts = pair_page(
        name,
        agreement_table,
        contact_table,
        best_table,
        {"patches": patches, "complementarity": {"interface": interface}},
        partner_labels(pair),
        sides_without_atoms,
    )
    write(page, TEMPLATE, **facts)


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
            page=snakemake.output.page,
            pair=snakemake.params.pair,
            patches=snakemake.params.patches,
            centres=snakemake.params.centres,
            nearest=snakemake.params.nearest,
            smoothing=snakemake.params.smoothing,
            interface=snakemake.params.interface,
            seed=snakemake.params.seed,
            name=snakemake.wildcards.pair,
            threads=snakemake.threads,
        )
