"""Run one stage of the molecular dynamics: minimisation, NVT, NPT or production."""

import os

from sparsurf.simulation.protocol import with_defaults
from sparsurf.simulation.stages import run_stage
from sparsurf.workflow.jobs import job, reporter


def main(
    before: str | None,
    system: str,
    folder: str,
    simulate: dict,
    stage: str,
    unfinished: str,
    seed: int,
    name: str,
    threads: int = 1,
) -> None:
    """Run the stage in a folder that survives a killed job, and move it to `folder` when it is complete.

    Parameters
    ----------
    before : folder of the stage before; None for the first
    simulate : dict, the key `simulate` of the protein in the config
    unfinished : folder in which the stage runs
    name : of the protein
    """
    progress = reporter(f"{name}: {stage}", "steps")
    finished = run_stage(stage, system, before, with_defaults(simulate), seed, unfinished, threads, progress)
    os.replace(finished, folder)


if __name__ == "__main__":
    with job(snakemake):
        main(
            before=snakemake.input.before or None,
            system=snakemake.input.system,
            folder=snakemake.output.folder,
            simulate=snakemake.params.simulate,
            stage=snakemake.params.stage,
            unfinished=snakemake.params.unfinished,
            seed=snakemake.params.seed,
            name=snakemake.wildcards.protein,
            threads=snakemake.threads,
        )
