"""Extract the protein's trajectory without water, and check that the simulation reached its targets."""

import logging

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.report.figures import layout
from sparsurf.report.figures.simulation import simulation_figure
from sparsurf.rounding import write_table
from sparsurf.simulation import quality as checks
from sparsurf.simulation.protocol import with_defaults
from sparsurf.simulation.stages import extract_protein
from sparsurf.workflow.jobs import job

log = logging.getLogger("sparsurf")


def main(
    system: str,
    minimise: str,
    nvt: str,
    npt: str,
    production: str,
    topology: str,
    trajectory: str,
    energies: str,
    motion: str,
    quality: str,
    png: str,
    simulate: dict,
) -> None:
    """Write topology.pdb, trajectory.xtc, the tables of quality and their figure; warn of a mean off its target.

    Parameters
    ----------
    minimise, nvt, npt, production : folders of the stages
    energies, motion, quality : tables to be written
    simulate : dict, the key `simulate` of the protein in the config
    """
    extract_protein(system, production, topology, trajectory)
    stages = {"minimise": minimise, "nvt": nvt, "npt": npt, "production": production}
    energy_table = checks.energies(stages)
    motion_table = checks.motion(read_molecule(topology, trajectory))
    quality_table = checks.judge(energy_table, with_defaults(simulate))
    for sentence in checks.warnings(quality_table):
        log.warning(sentence)
    write_table(energies, energy_table)
    write_table(motion, motion_table)
    write_table(quality, quality_table)
    layout.save(simulation_figure(energy_table, motion_table, quality_table), png)


if __name__ == "__main__":
    with job(snakemake):
        main(
            system=snakemake.input.system,
            minimise=snakemake.input.minimise,
            nvt=snakemake.input.nvt,
            npt=snakemake.input.npt,
            production=snakemake.input.production,
            topology=snakemake.output.topology,
            trajectory=snakemake.output.trajectory,
            energies=snakemake.output.energies,
            motion=snakemake.output.motion,
            quality=snakemake.output.quality,
            png=snakemake.output.png,
            simulate=snakemake.params.simulate,
        )
