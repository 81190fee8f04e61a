"""How often the interval of a mean over few structures contains the mean: ours compared with Student's t."""

import numpy as np
import pandas as pd
from scipy.stats import t

from measures.over_proteins import coverage_of_mean
from measures.tables import write_tables
from sparsurf.streams import stream
from sparsurf.study.relation import mean_interval
from sparsurf.workflow.jobs import job

LEVEL = 0.95


def student_interval(values: np.ndarray) -> tuple[float, float, float]:
    """Return mean and Student's t interval."""
    error = values.std(ddof=1) / len(values) ** 0.5
    return values.mean(), *t.interval(LEVEL, len(values) - 1, values.mean(), error)


INTERVALS = {"ours": mean_interval, "Student's t": student_interval}


def populations(recover: pd.DataFrame, required: pd.DataFrame) -> dict[str, pd.Series]:
    """Return values by structure over which means are taken, some of them skewed."""
    farthest = recover[recover["sampler"] == "farthest"]
    values = {
        f"{words}, {percent:g} % of the dots": farthest.loc[farthest["percent"] == percent, column]
        for column, words in (("Z_over_floor", "Z over the floor"), ("distance", "distance"))
        for percent in (5, 10)
    }
    return values | {"dots that are enough": required.loc[required["floor"] == "fresh dots", "n_S_percent"]}


def main(recover: str, required: str, coverage_means: str, drawn: list[int], seed: int) -> None:
    """Write the shares of intervals that contain the mean, for each number of structures drawn."""
    rows = []
    for name, values in populations(pd.read_csv(recover), pd.read_csv(required)).items():
        row = {"of": name, "structures": len(values), "skewness": values.skew()}
        for n in drawn:
            rng = stream(seed, "intervals", name, n)
            shares = {key: coverage_of_mean(values, rng, n, interval) for key, interval in INTERVALS.items()}
            rows.append(row | {"drawn": n} | shares)
    write_tables({coverage_means: pd.DataFrame(rows)})


if __name__ == "__main__":
    with job(snakemake):
        main(
            recover=snakemake.input.recover,
            required=snakemake.input.required,
            coverage_means=snakemake.output.coverage_means,
            drawn=snakemake.params.drawn,
            seed=snakemake.params.seed,
        )
