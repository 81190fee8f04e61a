"""What the test of Table I can notice."""

from pathlib import Path

import pandas as pd

from measures.power import power
from measures.tables import of_logs, store
from sparsurf.workflow.jobs import run


def main(inputs, outputs, logs):
    """Write the power for every changed rule."""
    reference = pd.read_csv(inputs["reference"])
    rows = [power(reference, pd.read_csv(path)).assign(rule=Path(path).stem) for path in inputs["others"]]
    table = pd.concat(rows, ignore_index=True)
    table = table[["rule", *table.columns.drop("rule")]]
    store({"power": table, "power_cpu": of_logs(logs)}, outputs)


if __name__ == "__main__":
    run(main, snakemake)
