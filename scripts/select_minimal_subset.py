"""Select the minimal subset of a surface: enough dots to recover the surface from."""

import logging
from dataclasses import replace

import numpy as np

from sparsurf.molecules.read_molecule import read_study_structure
from sparsurf.recovery.fields import recovery_table
from sparsurf.rounding import write_table
from sparsurf.sampling.combination import PUBLISHED_CHOICES, choices_from_ranges
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.study.floors import read_distances
from sparsurf.study.minimal_subset import represent
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
    settings: Settings,
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
    whole_curve : whether the curve of recovered surfaces goes on below the lowest noise floor
    name : protein/conformation
    """
    dots = read_npz(surface)
    component = {name: dots.fields[name].astype(int) for name in (COMPONENT_FIELD,) if name in dots.fields}
    dots = replace(dots, fields=fields_without_component(dots))
    choices = choices_from_ranges(read_table(ranges) if ranges else None)
    if ranges and choices is PUBLISHED_CHOICES:
        log.warning(
            "%s: nothing was evaluated among the kept dots, so the paper's sampling takes the paper's parameters",
            name,
        )
    rough, noise_floors = read_roughness(roughness, dots), read_distances(floors)
    molecule = read_study_structure(structure) if structure else None
    found = represent(
        dots,
        settings,
        Streams(seed, name),
        molecule,
        table=field_table,
        roughness=rough,
        floors=noise_floors,
        choices=choices,
    )
    required, curve = found.required_dots(noise_floors, whole_curve)
    write_table(required_dots, required)
    write_table(curves, curve)
    write_table(recovered, found.errors(threads))
    few, of_dots = found.subset, found.surface.fields
    rows = few.table.assign(**few.surface.fields)
    write_csv(table, rows, list(few.surface.fields))
    columns = {key: rows[key].to_numpy(float) for key in ("spacing", "reach")} | few.surface.fields
    write_ply(ply, few.surface, few.weight.astype(float), "weight", columns)
    write_ply(whole, dots, found.roughness, "roughness", component | of_dots)
    with open(fields, "wb") as stream:
        np.savez(stream, allow_pickle=False, **(of_dots if settings.fields else {}))
    errors_of_fields = (
        found.errors_of_fields()
        if settings.fields
        else recovery_table(replace(dots, fields={}), np.empty(0, int))
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
            settings=Settings.of(snakemake.params),
            whole_curve=snakemake.params.whole_curve,
            seed=snakemake.params.seed,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            threads=snakemake.threads,
        )
