"""The protein's trajectory without water, and whether the simulation did what it was asked."""

import logging

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.report.figures import layout
from sparsurf.report.figures.simulation import simulation_figure
from sparsurf.simulation import quality
from sparsurf.simulation.protocol import STAGES, completed
from sparsurf.simulation.stages import take_trajectory
from sparsurf.workflow.jobs import run

log = logging.getLogger("sparsurf")


def main(inputs, outputs, simulate):
    """Write topology.pdb, trajectory.xtc, the tables of quality and their figure; warn of a mean off its target."""
    take_trajectory(inputs["system"], inputs["production"], outputs["topology"], outputs["trajectory"])
    energies = quality.energies({stage: inputs[stage] for stage in STAGES})
    motion = quality.motion(read_molecule(outputs["topology"], outputs["trajectory"]))
    judged = quality.judge(energies, completed(simulate))
    for sentence in quality.warnings(judged):
        log.warning(sentence)
    energies.to_csv(outputs["energies"], index=False)
    motion.to_csv(outputs["motion"], index=False)
    judged.to_csv(outputs["quality"], index=False)
    layout.save(simulation_figure(energies, motion, judged), outputs["png"].removesuffix(".png"))


if __name__ == "__main__":
    run(main, snakemake)
