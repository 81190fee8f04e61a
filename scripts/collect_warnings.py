"""What the jobs of a run warned of, in one table."""

import csv
import re
from fnmatch import fnmatch
from pathlib import Path

from sparsurf.workflow.job_logs import place, warnings_in
from sparsurf.workflow.jobs import run
from sparsurf.workflow.results import LOGS, replaced

COLUMNS = ("protein", "conformation", "job", "sentence")
CONFORMATION = re.compile(r"[cf]\d+")  # else a folder of its own, as of a simulation


def main(inputs, outputs, places, jobs):
    """Write warnings.csv from the logs of a run.

    Those of earlier studies in its folder do not count: of proteins, pairs and sites that are none of its `places`, of
    conformations without results, of `jobs` that it does not have, and of jobs whose results others have made since.
    """
    run_folder = Path(outputs["table"]).parent
    there, rows = {*places, *(str(Path(path).parent) for path in inputs["results"])}, []
    logs = sorted((run_folder / LOGS).rglob("*.log"))
    old = replaced(logs)
    for path in logs:
        if path in old:
            continue
        protein, conformation, job = place(path, run_folder / LOGS)
        names = f"{protein}/{conformation}", str(run_folder / protein / conformation)
        chosen = not CONFORMATION.fullmatch(conformation) or not there.isdisjoint(names)
        if protein in ("", *places) and chosen and any(fnmatch(job, each) for each in jobs):
            rows += [(protein, conformation, job, sentence) for sentence in warnings_in(path)]
    with open(outputs["table"], "w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows([COLUMNS, *rows])


if __name__ == "__main__":
    run(main, snakemake)
