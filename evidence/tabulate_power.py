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
        table = table.pivot(index=["binning", "n_runs"], columns="measure", values="power").reset_index()
        rows.append(table.assign(rule=Path(path).stem, mean_centres=centres(other).mean()))
    table = pd.concat(rows, ignore_index=True)
    columns = ["rule", "binning", "n_runs", "d", "Z_tS", "centres", "together", "mean_centres"]
    store({"power": table[columns], "power_cpu": of_logs(logs)}, outputs)


if __name__ == "__main__":
    run(main, snakemake)
