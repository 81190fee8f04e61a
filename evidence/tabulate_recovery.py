"""Tables of recovered surfaces over all structures: means with intervals, and samplers and opponents in pairs."""

import pandas as pd

from measures import opponents, recovery
from measures.tables import joined, of_logs, store
from sparsurf.workflow.jobs import run

BESIDE = (opponents.SETTLED, opponents.SPARSE, opponents.MESH, opponents.CORNERS, opponents.QUANTISED)


def main(inputs, outputs, a1, logs):
    """Write every table; the paper's structure stands in one of its own."""
    subsets, floors, others = (joined(inputs[key]) for key in ("subsets", "floors", "opponents"))
    where, dense = joined(inputs["where"]), joined(inputs["dense"])
    found = {"recover_cpu": of_logs(logs), "recover_dense": dense}
    found["recover_a1"] = pd.concat([each[each["protein"] == a1] for each in (subsets, others)])
    found["recover_a1"] = found["recover_a1"].merge(joined([inputs["cost"]]), how="cross")
    if subsets["protein"].nunique() > 1:
        subsets, floors, others, where = (
            each[each["protein"] != a1] for each in (subsets, floors, others, where)
        )
    found |= {
        "recover": subsets,
        "recover_floors": floors,
        "recover_opponents": others,
        "recover_where": where,
    }
    found["recover_means"] = recovery.means(subsets)
    found["recover_dense_means"] = recovery.dense_means(dense)
    beside = opponents.in_common(others)
    found["recover_opponents_means"] = recovery.means(beside, opponents.MEASURES)
    errors, groups = ("mean", "high_99", "largest"), ["sampler", "percent", "where"]
    found["recover_where_means"] = recovery.means(
        opponents.in_common(where), ("dots_percent", *errors), groups
    )
    atoms = others[others["sampler"].isin((opponents.ATOMS, opponents.ROUNDED_ATOMS))].assign(percent=0)
    found["recover_atoms_means"] = recovery.means(atoms, opponents.MEASURES).drop(columns="percent")
    pairs = [(subsets, "adaptive", "farthest"), (subsets, "roughness", "uniform")]
    pairs += [(beside, each, opponents.KEPT) for each in BESIDE if each in set(beside["sampler"])]
    found["recover_pairs"] = pd.concat([recovery.paired(*pair) for pair in pairs], ignore_index=True)
    store(found, outputs)


if __name__ == "__main__":
    run(main, snakemake)
