"""Compare samplers at equal n_S on one surface."""

from collections.abc import Callable
from functools import partial

from sparsurf.molecules.read_molecule import read_study_structure
from sparsurf.report import comparison_page
from sparsurf.report.figures import comparison_figure, layout
from sparsurf.report.page import write
from sparsurf.rounding import write_table
from sparsurf.sampling.combination import PUBLISHED_CHOICES, choices_from_ranges
from sparsurf.study.comparison import equal_error as fewer_dots
from sparsurf.study.comparison import measuring, methods
from sparsurf.study.comparison.measuring import stand_alone
from sparsurf.study.comparison.methods import dotted_surface
from sparsurf.study.prepared_surface import number_of_tests, prepare_surface
from sparsurf.study.tables import floors_by_name, read_roughness, read_table
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spacing import area_of
from sparsurf.workflow.jobs import job, reporter

SAMPLERS_ALONE = ("farthest", "uniform")  # whose subsets are described without the full surface


def main(
    surface: str,
    roughness: str,
    ranges: str,
    floors: str,
    structure: str | None,
    table: str,
    page: str,
    pairs: str,
    fewer: str,
    alone: str,
    needed: str,
    png: str,
    panels: str,
    surface_settings: dict,
    patches: dict,
    distance_from_moved_centre: bool,
    chance_in_every_patch: bool,
    evaluation: dict,
    percents: list[float],
    samplers: list[str] | None,
    seed: int,
    name: str,
    title: str,
    threads: int = 1,
) -> None:
    """Write compare.csv with its page and figure, and the tables that follow from it.

    Parameters
    ----------
    structure : None for a ready surface
    table, pairs, fewer, alone, needed : tables to be written
    surface_settings, patches, evaluation : dict, the sections `surface`, `patches` and `evaluation` of the config
    percents : n_S in % of the dots
    samplers : names; None for all
    name : protein/conformation
    title : its name on the page
    """
    dots = read_npz(surface)
    rough, best = read_roughness(roughness, dots), read_table(ranges)
    prepared = prepare_surface(
        dots, patches, rough, seed, name, threads, distance_from_moved_centre, chance_in_every_patch
    )
    n_tests, draws = number_of_tests(evaluation["test_dots"], len(dots)), evaluation["draws"]
    drawers = methods.select_methods(prepared, samplers, best)
    distances: dict = {}  # filled by `compare`: those of every test dot, for the intervals
    comparison = measuring.compare_samplers(
        prepared,
        drawers,
        percents,
        n_tests,
        draws,
        reporter(f"{name}: comparison", "samplers"),
        floors_by_name(read_table(floors)),
        distances,
    )
    drawers_alone = {key: drawers[key] for key in SAMPLERS_ALONE if key in drawers}
    place_dots = _place_dots(structure, surface_settings) if structure else None
    best_sampler = comparison_page.best_of(comparison)[-1]
    references = list(dict.fromkeys(filter(None, [*fewer_dots.BASELINES, best_sampler])))
    pair_table = fewer_dots.paired_differences(distances, percents, against=references)
    fewer_table = fewer_dots.factor_intervals(distances, comparison, prepared.stream("times fewer"))
    alone_table = stand_alone(prepared, drawers_alone, place_dots, percents, n_tests, draws)
    write_table(pairs, pair_table)
    write_table(fewer, fewer_table)
    write_table(alone, alone_table)
    write_table(table, comparison)
    write_table(needed, fewer_dots.dots_needed_for_all_uses(comparison))
    area, estimated = area_of(dots)
    facts = comparison_page.comparison_page(
        title,
        comparison,
        fewer_table,
        pair_table,
        alone_table,
        n_dots=len(dots),
        area=area,
        estimated=estimated,
        n_tests=n_tests,
        draws=draws,
        of_paper=choices_from_ranges(best) is PUBLISHED_CHOICES,
    )
    write(page, comparison_page.TEMPLATE, **facts)
    layout.save(comparison_figure.comparison_figure(comparison, title), png)
    layout.save(comparison_figure.comparison_panels(comparison, title), panels)


def _place_dots(structure: str, settings: dict) -> Callable:
    """Return the function that places any number of dots on the surface of a structure."""
    atoms = read_study_structure(structure)
    return partial(
        dotted_surface,
        atoms.xyz[0],
        radii(atoms, settings["radii"]),
        probe=settings["probe_radius"],
        reentrant=settings["reentrant"],
        cavities=settings.get("cavities", "keep"),
    )


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface=snakemake.input.surface,
            roughness=snakemake.input.roughness,
            ranges=snakemake.input.ranges,
            floors=snakemake.input.floors,
            structure=snakemake.input.structure or None,
            table=snakemake.output.table,
            page=snakemake.output.page,
            pairs=snakemake.output.pairs,
            fewer=snakemake.output.fewer,
            alone=snakemake.output.alone,
            needed=snakemake.output.needed,
            png=snakemake.output.png,
            panels=snakemake.output.panels,
            surface_settings=snakemake.params.surface,
            patches=snakemake.params.patches,
            distance_from_moved_centre=snakemake.params.distance_from_moved_centre,
            chance_in_every_patch=snakemake.params.chance_in_every_patch,
            evaluation=snakemake.params.evaluation,
            percents=snakemake.params.percents,
            samplers=snakemake.params.samplers,
            seed=snakemake.params.seed,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            title=snakemake.params.title,
            threads=snakemake.threads,
        )
