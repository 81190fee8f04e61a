"""What the test of Table I can notice."""

from pathlib import Path

import pandas as pd

from measures.tables import of_logs, store
from sparsurf.paper.published_runs import power
from sparsurf.workflow.jobs import run


def main(inputs, outputs, logs):
    """Write the power for every changed rule."""

    def centres(runs):
        return runs.groupby("run")["centres"].first().to_numpy()

    reference, rows = pd.read_csv(inputs["reference"]), []
    for path in inputs["others"]:
        other = pd.read_csv(path)
        table = power(reference, centres(reference), other, centres(other))
        table.insert(0, "rule", Path(path).stem)
        rows.append(table.assign(centres=centres(other).mean()))
    store({"power": pd.concat(rows, ignore_index=True), "power_cpu": of_logs(logs)}, outputs)


if __name__ == "__main__":
    run(main, snakemake)
