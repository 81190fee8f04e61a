"""Measure how far two sets of dots of one surface differ: the noise floor that every Z of a subset is compared with."""

from sparsurf_study.workflow.jobs import job
from sparsurf.evaluation.floors import floors_table, fresh_dots
from sparsurf.evaluation.prepared_surface import number_of_tests
from sparsurf.surfaces.molecular_surface import surface_generator
from sparsurf.surfaces.radii import radii
from sparsurf_study.structures import read_study_structure

with job(snakemake) as s:
    rules, d_link = s.settings.surface, s.settings.patches.d_link
    prepared = s.prepared(s.streams(shared=True))
    generate_surface = atoms = None
    if s.input.conformation:
        molecule = read_study_structure(s.input.conformation)
        generate_surface, atoms = surface_generator(
            molecule.xyz[0], radii(molecule, rules.radii), rules, d_link, s.place
        )
    n_tests = number_of_tests(s.settings.evaluation.test_dots, len(prepared))
    floors_table(fresh_dots(prepared, n_tests, generate_surface, atoms)).to_csv(s.output.floors, index=False)
