"""Read the surface of another program into the study, dots in the order of the file."""

from sparsurf_study.workflow.jobs import job
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.read_surface import read_surface

with job(snakemake) as s:
    write_npz(s.output.surface, read_surface(s.input.surface))
