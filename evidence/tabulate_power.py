"""Power of the test of Table I: how often it detects each changed rule."""

from pathlib import Path

import numpy as np
import pandas as pd

from measures.tables import cpu_table, write_tables
from sparsurf.paper.published_runs import power as power_of
from sparsurf.workflow.jobs import job

COLUMNS = ["rule", "binning", "n_runs", "d", "Z_tS", "centres", "together", "mean_centres"]


def centres_by_run(winners: pd.DataFrame) -> np.ndarray:
    """Return the number of centres of each run, (runs,)."""
    return winners.groupby("run")["centres"].first().to_numpy()


def main(reference: str, others: list[str], power: str, power_cpu: str, logs: str) -> None:
    """Write the power for every changed rule."""
    unchanged, tables = pd.read_csv(reference), []
    for path in others:
        changed = pd.read_csv(path)
        table = power_of(unchanged, centres_by_run(unchanged), changed, centres_by_run(changed))
        table = table.pivot(index=["binning", "n_runs"], columns="measure", values="power").reset_index()
        mean_centres = centres_by_run(changed).mean()
        tables.append(table.assign(rule=Path(path).stem, mean_centres=mean_centres))
    table = pd.concat(tables, ignore_index=True)[COLUMNS]
    write_tables({power: table, power_cpu: cpu_table(logs)})


if __name__ == "__main__":
    with job(snakemake):
        main(
            reference=snakemake.input.reference,
            others=snakemake.input.others,
            power=snakemake.output.power,
            power_cpu=snakemake.output.power_cpu,
            logs=snakemake.params.logs,
        )
