"""Tables of the centres over all proteins: the best of each range beside a control that has nothing but the centres."""

import pandas as pd

from measures.tables import joined, of_logs, store
from sparsurf.study.relation import with_interval
from sparsurf.workflow.jobs import run

MEASURES = ("n_S_percent", "d_mean", "d_centres_mean", "d", "d_centres")


def means(table):
    """Means over proteins with 95 % intervals, by reading and range: d and the control's, of all combinations and the best."""
    rows = []
    for (reading, number), part in table.groupby(["reading", "range"], sort=False):
        row = {"reading": reading, "range": number, "n": int(part["d"].notna().sum())}
        for measure in MEASURES:
            row |= with_interval(measure, part[measure])
        row |= {key: 100 * part[key].sum() / part["n_combinations"].sum() for key in ("n_above", "n_below")}
        rows.append(row)
    return pd.DataFrame(rows)


def main(inputs, outputs, logs):
    """Write them."""
    table = joined(inputs["tables"])
    store({"centres": table, "centres_means": means(table), "centres_cpu": of_logs(logs)}, outputs)


if __name__ == "__main__":
    run(main, snakemake)
