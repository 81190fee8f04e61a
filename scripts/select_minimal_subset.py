"""Select the minimal subset of a surface: enough dots to recover the surface from."""

import logging
from dataclasses import replace

import numpy as np
import pandas as pd

from sparsurf.dot_fields.registry import FIELDS, compute_fields
from sparsurf.molecules.read_molecule import read_study_structure
from sparsurf.patches.readings import FULL_READING
from sparsurf.recovery.errors import DENSITY_FOR_ERRORS, curvature, distance_to_recovered, error_table
from sparsurf.recovery.fields import recovery_table
from sparsurf.rounding import write_table
from sparsurf.sampling.combination import PUBLISHED_CHOICES, choices_from_ranges
from sparsurf.sampling.samplers import farthest
from sparsurf.study.floors import read_distances
from sparsurf.study.minimal_subset import recovered_z, select_minimal_subset
from sparsurf.study.prepared_surface import number_of_tests, prepare_surface
from sparsurf.study.required_dots import FLOOR_FACTOR, UNIFORM, Trials, curves_table, required_dots_table
from sparsurf.study.tables import read_roughness, read_table
from sparsurf.surfaces.components import COMPONENT_FIELD, fields_without_component
from sparsurf.surfaces.formats.csv import write_csv
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf.workflow.jobs import job

log = logging.getLogger("sparsurf")


def main(
    surface: str,
    roughness: str,
    floors: str,
    ranges: str | None,
    structure: str | None,
    field_table: str | None,
    table: str,
    ply: str,
    whole: str,
    recovered: str,
    required_dots: str,
    curves: str,
    fields: str,
    fields_recovered: str,
    patches: dict,
    distance_from_moved_centre: bool,
    chance_in_every_patch: bool,
    test_dots: int | str,
    minimal: dict,
    field_names: list[str],
    whole_curve: bool,
    seed: int,
    name: str,
    threads: int = 1,
) -> None:
    """Write the minimal subset, Z over n_S, the errors of the surface recovered from it, and both surfaces as PLY.

    Parameters
    ----------
    ranges : table that the paper's sampler takes its parameters from; None for other samplers
    structure : None for a ready surface
    field_table : table with fields of the protein's own
    patches, minimal : dict, sections of the config
    field_names : the list `fields` of the config
    whole_curve : whether the curve of recovered surfaces goes on below the lowest noise floor
    name : protein/conformation
    """
    dots = read_npz(surface)
    molecule = read_study_structure(structure) if structure else None
    dot_fields = fields_without_component(dots)
    components = (
        {COMPONENT_FIELD: dots.fields[COMPONENT_FIELD].astype(int)} if COMPONENT_FIELD in dots.fields else {}
    )
    if molecule is not None:
        computed = [field for field in field_names if field_table or field in FIELDS]
        table_of_fields = compute_fields(computed, molecule, dots.points, table=field_table)
        dot_fields |= {str(field): table_of_fields[field].to_numpy() for field in table_of_fields}
    dots = replace(dots, fields=dot_fields)
    rough = read_roughness(roughness, dots)
    prepared = prepare_surface(
        dots, patches, rough, seed, name, 1, distance_from_moved_centre, chance_in_every_patch
    ).with_shared_streams
    choices = choices_from_ranges(read_table(ranges) if ranges else None)
    if ranges and choices is PUBLISHED_CHOICES:
        log.warning(
            "%s: nothing was evaluated among the kept dots, so the paper's sampling takes the paper's parameters",
            name,
        )
    n_tests = number_of_tests(test_dots, len(dots))
    noise_floors = read_distances(floors)
    trials = Trials(prepared, minimal["sampler"], n_tests, choices)
    subset = select_minimal_subset(trials, minimal, noise_floors, molecule)
    lowest = min(distances.mean() for distances in noise_floors.values())
    trials.down_to = -1 if whole_curve else FLOOR_FACTOR * lowest
    write_table(required_dots, required_dots_table(trials, noise_floors))
    all_curves = [curves_table(trials)]
    if minimal["sampler"] != UNIFORM:
        all_curves.append(curves_table(Trials(prepared, UNIFORM, n_tests), (FULL_READING,)))
    write_table(curves, pd.concat(all_curves))
    distances = distance_to_recovered(
        dots.points, subset.surface.points, subset.surface.normals, threads, DENSITY_FOR_ERRORS
    )
    errors = error_table(distances, curvature(prepared.index, threads=threads), subset.dots)
    low, high = subset.interval or (np.nan, np.nan)
    of_subset = {"n_S_percent": len(subset), "n_S_percent_low": low, "n_S_percent_high": high}
    of_subset = {key: 100 * n / len(dots) for key, n in of_subset.items()}
    of_subset |= {"density": len(subset) / prepared.area}
    of_subset |= recovered_z(prepared, subset.dots, trials.tests)
    errors.loc[0, list(of_subset)] = list(of_subset.values())
    write_table(recovered, errors)
    rows = subset.table.assign(**subset.surface.fields)
    write_csv(table, rows, list(subset.surface.fields))
    columns = {key: rows[key].to_numpy(float) for key in ("spacing", "reach")} | subset.surface.fields
    write_ply(ply, subset.surface, subset.weight.astype(float), "weight", columns)
    write_ply(whole, dots, rough, "roughness", components | dot_fields)
    with open(fields, "wb") as stream:
        np.savez(stream, allow_pickle=False, **(dot_fields if field_names else {}))
    order = farthest(prepared, len(dots) // 5, prepared.stream("minimal", "farthest"))
    errors_of_fields = recovery_table(
        dots if field_names else replace(dots, fields={}), order, subset.dots, subset.surface.points
    )
    errors_of_fields.to_csv(fields_recovered, index=False, float_format="%.5g")


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface=snakemake.input.surface,
            roughness=snakemake.input.roughness,
            floors=snakemake.input.floors,
            ranges=snakemake.input.ranges or None,
            structure=snakemake.input.structure or None,
            field_table=snakemake.input.table or None,
            table=snakemake.output.table,
            ply=snakemake.output.ply,
            whole=snakemake.output.whole,
            recovered=snakemake.output.recovered,
            required_dots=snakemake.output.required_dots,
            curves=snakemake.output.curves,
            fields=snakemake.output.fields,
            fields_recovered=snakemake.output.fields_recovered,
            patches=snakemake.params.patches,
            distance_from_moved_centre=snakemake.params.distance_from_moved_centre,
            chance_in_every_patch=snakemake.params.chance_in_every_patch,
            test_dots=snakemake.params.test_dots,
            minimal=snakemake.params.minimal,
            field_names=snakemake.params.fields,
            whole_curve=snakemake.params.whole_curve,
            seed=snakemake.params.seed,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            threads=snakemake.threads,
        )
