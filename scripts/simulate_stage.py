"""One stage of the molecular dynamics: minimisation, NVT, NPT or production."""

import os

from sparsurf.simulation.protocol import completed
from sparsurf.simulation.stages import run_stage
from sparsurf.workflow.jobs import reporter, run


def main(inputs, outputs, simulate, settings, stage, work, name, threads):
    """Run the stage in the folder `work`, which outlives a killed job, and hand it over when it is complete."""
    report = reporter(f"{name}: {stage}", "steps")
    done = run_stage(
        stage,
        inputs["system"],
        inputs.get("before"),
        completed(simulate),
        settings["seed"],
        work,
        threads,
        report,
    )
    os.replace(done, outputs["folder"])


if __name__ == "__main__":
    run(main, snakemake)
