"""Measure how the maps of a pair degrade with fewer centres."""

from sparsurf.pairs.matching import Recipe
from sparsurf.pairs.partner_files import read_partners
from sparsurf.pairs.thinning import thinning as thin
from sparsurf.report.figures import layout
from sparsurf.report.figures.pair_figures import thinning_figure
from sparsurf.workflow.jobs import job


def main(
    surface_1: str,
    surface_2: str,
    structure_1: str | None,
    structure_2: str | None,
    table: str,
    png: str,
    patches: dict,
    distance_from_moved_centre: bool,
    chance_in_every_patch: bool,
    thinning: dict,
    smoothing: float,
    interface: float,
    seed: int,
    name: str,
) -> None:
    """Write thinning.csv and its figure, in one thread so that seconds can be compared.

    Parameters
    ----------
    structure_1, structure_2 : None for a ready surface
    patches : dict, the section `patches` of the config
    thinning, smoothing, interface : see the section `complementarity` of the config
    name : of the pair
    """
    results = thin(
        *read_partners(surface_1, surface_2, structure_1, structure_2, patches, name),
        thinning["percents"],
        thinning["samplers"],
        thinning["draws"],
        thinning["recovered"],
        Recipe(patches["descriptor"], patches["R_zernike"]),
        smoothing=smoothing,
        within=interface,
        seed=seed,
        rules={
            "r_patch": patches["R_patch"],
            "d_link": patches["D_link"],
            "distance_from_moved_centre": distance_from_moved_centre,
            "chance_in_every_patch": chance_in_every_patch,
        },
    )
    results.to_csv(table, index=False, float_format="%.6g")
    layout.save(thinning_figure(results, name), png)


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface_1=snakemake.input.surface_1,
            surface_2=snakemake.input.surface_2,
            structure_1=snakemake.input.get("structure_1"),
            structure_2=snakemake.input.get("structure_2"),
            table=snakemake.output.table,
            png=snakemake.output.png,
            patches=snakemake.params.patches,
            distance_from_moved_centre=snakemake.params.distance_from_moved_centre,
            chance_in_every_patch=snakemake.params.chance_in_every_patch,
            thinning=snakemake.params.thinning,
            smoothing=snakemake.params.smoothing,
            interface=snakemake.params.interface,
            seed=snakemake.params.seed,
            name=snakemake.wildcards.pair,
        )
