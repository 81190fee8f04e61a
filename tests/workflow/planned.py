"""The jobs of a study as Snakemake plans them, as JSON: `python planned.py Snakefile folder config.yaml`.

Runs nothing, and in a process of its own: Snakemake keeps much of a workflow in modules.
"""

import contextlib
import io
import json
import sys
from pathlib import Path

from snakemake.api import SnakemakeApi
from snakemake.settings.types import ConfigSettings, OutputSettings, Quietness, ResourceSettings


def planned(snakefile, folder, config):
    """Rule of each job, its input, output, log and params, their names, and what it goes by, as Snakemake notes it."""
    with SnakemakeApi(OutputSettings(quiet={Quietness.ALL})) as api:
        given = api.workflow(
            ResourceSettings(cores=2),
            ConfigSettings(configfiles=[config]),
            snakefile=snakefile,
            workdir=folder,
        )
        with contextlib.redirect_stdout(io.StringIO()):
            given.dag().printrulegraph()
        return [
            {
                "rule": job.rule.name,
                "input": list(map(str, job.input)),
                "output": list(map(str, job.output)),
                "log": list(map(str, job.log)),
                "names": {
                    part: {name: str(each) for name, each in getattr(job, part).items()}
                    for part in ("input", "output", "params")
                },
                "goes by": sorted(map(repr, job.non_derived_params)),
            }
            for job in given._workflow.dag.jobs
        ]


if __name__ == "__main__":
    print(json.dumps(planned(*map(Path, sys.argv[1:]))))
