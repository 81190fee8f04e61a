"""Extract the protein's trajectory without water from a simulation."""

from sparsurf_study.workflow.jobs import job
from sparsurf_study.simulation.stages import extract_protein

with job(snakemake) as s:
    extract_protein(s.input.system, s.input.production, s.output.topology, s.output.trajectory)
