"""Select the minimal subset of a surface: enough dots to reconstruct the surface from."""

import logging
from dataclasses import replace

import numpy as np

from sparsurf_study.workflow.jobs import job
from sparsurf.evaluation.minimal_subset import represent
from sparsurf.sampling.combination import PUBLISHED_CHOICES, choices_from_ranges
from sparsurf.surfaces.components import COMPONENT_FIELD, fields_without_component
from sparsurf.surfaces.formats.colours import scale_of
from sparsurf.surfaces.formats.csv import write_csv
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf_study.analysis.reconstructed import write_reconstructed
from sparsurf_study.analysis.tables import read_roughness, read_table
from sparsurf_study.rounding import write_rounded
from sparsurf_study.structures import read_study_structure

REMARK = "%s: nothing was evaluated among the kept dots, so the paper's sampling takes the paper's parameters"

with job(snakemake) as s:
    dots = read_npz(s.input.surface)
    component = {key: dots.fields[key].astype(int) for key in (COMPONENT_FIELD,) if key in dots.fields}
    dots = replace(dots, fields=fields_without_component(dots))
    choices = choices_from_ranges(read_table(s.input.ranges) if s.input.ranges else None)
    if s.input.ranges and choices is PUBLISHED_CHOICES:
        logging.getLogger("sparsurf").warning(REMARK, s.place)
    found = represent(
        dots,
        s.settings,
        s.streams(),
        read_study_structure(s.input.structure) if s.input.structure else None,
        table=s.input.table or None,
        roughness=read_roughness(s.input.roughness, dots),
        choices=choices,
        threads=s.threads,
    )
    reconstructed = found.reconstructed()
    write_rounded(s.output.recovered, found.errors(s.threads))
    distance = reconstructed.distances(dots.points, s.threads, found.trials.rolled)
    write_reconstructed(s.output.reconstructed, reconstructed.comparable, distance)
    few, fields = found.subset, found.surface.fields
    rows = few.table.assign(**few.surface.fields)
    write_csv(s.output.table, rows, list(few.surface.fields))
    columns = {key: rows[key].to_numpy(float) for key in ("area", "spacing", "reach") if key in rows}
    columns |= few.surface.fields
    write_ply(s.output.ply, few.surface, scale_of("weight", few.weight), columns)
    write_ply(s.output.whole, dots, scale_of("roughness", found.roughness), component | fields)
    if s.settings.fields:
        with open(s.output.fields, "wb") as stream:
            np.savez(stream, **fields)  # type: ignore[arg-type]  # numpy 2.0 has no allow_pickle here
        errors = found.errors_of_fields()
        errors.to_csv(s.output.fields_recovered, index=False, float_format="%.5g")
