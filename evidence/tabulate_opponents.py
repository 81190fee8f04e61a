"""Tables of other ways to keep a surface over all structures: means with intervals, in pairs, and where they err."""

import pandas as pd

from measures import opponents, recovery
from measures.tables import joined, of_logs, store
from sparsurf.workflow.jobs import run

BESIDE = (opponents.SETTLED, opponents.SPARSE, opponents.MESH, opponents.CORNERS, opponents.QUANTISED)
WHERE = ("dots_percent", "mean", "high_99", "largest")


def main(inputs, outputs, logs):
    """Write every table."""
    others, where = joined(inputs["opponents"]), joined(inputs["where"])
    found = {"opponents_cpu": of_logs(logs), "recover_opponents": others, "recover_where": where}
    beside = opponents.in_common(others)
    found["recover_opponents_means"] = recovery.means(beside, opponents.MEASURES)
    atoms = others[others["sampler"].isin((opponents.ATOMS, opponents.ROUNDED_ATOMS))].assign(percent=0)
    found["recover_atoms_means"] = recovery.means(atoms, opponents.MEASURES).drop(columns="percent")
    groups = ("sampler", "percent", "where")
    found["recover_where_means"] = recovery.means(opponents.in_common(where), WHERE, groups)
    pairs = [
        recovery.paired(beside, each, opponents.KEPT) for each in BESIDE if each in set(beside["sampler"])
    ]
    found["recover_opponents_pairs"] = pd.concat(pairs, ignore_index=True)
    store(found, outputs)


if __name__ == "__main__":
    run(main, snakemake)
