"""Check that a simulation reached its targets, and draw its course."""

import logging

from sparsurf_study.workflow.jobs import job
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.views import layout
from sparsurf_study.report.figures.simulation import simulation_figure
from sparsurf_study.rounding import write_rounded
from sparsurf_study.simulation import quality
from sparsurf_study.simulation.protocol import with_defaults

with job(snakemake) as s:
    stages = ("minimise", "nvt", "npt", "production")
    energies = quality.energies({stage: s.input[stage] for stage in stages})
    motion = quality.motion(read_molecule(s.input.topology, s.input.trajectory))
    checks = quality.judge(energies, with_defaults(s.params.simulate))
    for sentence in quality.warnings(checks):
        logging.getLogger("sparsurf").warning(sentence)
    for path, table in ((s.output.energies, energies), (s.output.motion, motion), (s.output.quality, checks)):
        write_rounded(path, table)
    layout.save(simulation_figure(energies, motion, checks), s.output.png)
