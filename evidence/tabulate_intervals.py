"""How often the interval of a mean over few structures holds the mean: ours beside Student's t."""

import pandas as pd
from scipy.stats import t

from measures.over_proteins import coverage_of_mean
from measures.tables import store
from sparsurf.streams import stream
from sparsurf.study.relation import mean_interval
from sparsurf.workflow.jobs import run

LEVEL = 0.95


def student(values):
    """Mean and Student's t interval."""
    return values.mean(), *t.interval(
        LEVEL, len(values) - 1, values.mean(), values.std(ddof=1) / len(values) ** 0.5
    )


INTERVALS = {"ours": mean_interval, "Student's t": student}


def populations(recover, enough):
    """Values by structure that means are taken of, skewed ones among them."""
    own = recover[recover["sampler"] == "farthest"]
    found = {
        f"{words}, {percent:g} % of the dots": own.loc[own["percent"] == percent, column]
        for column, words in (("Z_over_floor", "Z over the floor"), ("distance", "distance"))
        for percent in (5, 10)
    }
    of = (enough["sampler"] == "farthest") & (enough["reading"] == "recovered")
    return found | {
        "dots that are enough": enough.loc[of & (enough["reference"] == "fresh dots"), "n_S_percent"]
    }


def main(inputs, outputs, settings):
    """Write the shares, for each number of structures that is drawn."""
    rows = []
    for name, values in populations(*(pd.read_csv(inputs[key]) for key in ("recover", "enough"))).items():
        row = {"of": name, "structures": len(values), "skewness": values.skew()}
        for n in settings["drawn"]:
            rng = stream(settings["seed"], "intervals", name, n)
            found = {key: coverage_of_mean(values, rng, n, interval) for key, interval in INTERVALS.items()}
            rows.append(row | {"drawn": n} | found)
    store({"coverage_means": pd.DataFrame(rows)}, outputs)


if __name__ == "__main__":
    run(main, snakemake)
