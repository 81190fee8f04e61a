"""Tables of recovered surfaces over all structures: means with intervals, and samplers in pairs."""

import pandas as pd

from measures import recovery
from measures.tables import joined, of_logs, store
from sparsurf.workflow.jobs import run


def main(inputs, outputs, a1, logs):
    """Write every table; the paper's structure stands in one of its own."""
    subsets, floors = joined(inputs["subsets"]), joined(inputs["floors"])
    cost = joined([inputs["cost"]])
    found = {"recover_cpu": of_logs(logs)}
    found["recover_a1"] = subsets[subsets["protein"] == a1].merge(cost, how="cross")
    if subsets["protein"].nunique() > 1:
        subsets, floors = (each[each["protein"] != a1] for each in (subsets, floors))
    found |= {"recover": subsets, "recover_floors": floors, "recover_means": recovery.means(subsets)}
    pairs = [recovery.paired(subsets, *pair) for pair in (("adaptive", "farthest"), ("roughness", "uniform"))]
    found["recover_pairs"] = pd.concat(pairs, ignore_index=True)
    store(found, outputs)


if __name__ == "__main__":
    run(main, snakemake)
