"""What the jobs of a run warned of, in one table."""

import csv
from pathlib import Path

from sparsurf.workflow.job_logs import place, warnings_in
from sparsurf.workflow.jobs import run

COLUMNS = ("protein", "conformation", "job", "sentence")


def main(outputs, logs, places):
    """Write warnings.csv from the logs of a run's proteins, pairs and of the run itself; others are of earlier studies."""
    rows = []
    for path in sorted(Path(logs).rglob("*.log")):
        protein, conformation, job = place(path, logs)
        if protein in ("", *places):
            rows += [(protein, conformation, job, sentence) for sentence in warnings_in(path)]
    with open(outputs["table"], "w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows([COLUMNS, *rows])


if __name__ == "__main__":
    run(main, snakemake)
