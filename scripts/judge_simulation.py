"""Extract the protein's trajectory without water, and check that the simulation reached its targets."""

import logging

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.report.figures import layout
from sparsurf.report.figures.simulation import simulation_figure
from sparsurf.rounding import write_table
from sparsurf.simulation import quality
from sparsurf.simulation.protocol import with_defaults
from sparsurf.simulation.stages import extract_protein
from sparsurf.workflow.jobs import job

with job(snakemake) as s:
    extract_protein(s.input.system, s.input.production, s.output.topology, s.output.trajectory)
    stages = ("minimise", "nvt", "npt", "production")
    energies = quality.energies({stage: s.input[stage] for stage in stages})
    motion = quality.motion(read_molecule(s.output.topology, s.output.trajectory))
    checks = quality.judge(energies, with_defaults(s.params.simulate))
    for sentence in quality.warnings(checks):
        logging.getLogger("sparsurf").warning(sentence)
    for path, table in ((s.output.energies, energies), (s.output.motion, motion), (s.output.quality, checks)):
        write_table(path, table)
    layout.save(simulation_figure(energies, motion, checks), s.output.png)
