"""How often intervals hold the truth, over several surfaces."""

from measures.tables import joined, of_logs, store
from sparsurf.workflow.jobs import run

SHARES = ["fixed_t", "fixed_normal", "winner", "held_out", "held_out_winner", "best_in_set"]
OTHERS = ["selected_bias", "held_out_bias", "half_width", "set_size"]


def main(inputs, outputs, logs):
    """Write all rows, and means over the ranges of n_S by surface and by design."""
    table = joined(inputs["tables"]).round(4)
    numbers = [*SHARES, *OTHERS]
    keys = ["reading", "draws", "test_dots"]
    found = {"coverage": table, "coverage_cpu": of_logs(logs)}
    found["coverage_surfaces"] = table.groupby(["surface", *keys], sort=False)[numbers].mean().reset_index()
    found["coverage_designs"] = table.groupby(keys, sort=False)[numbers].mean().reset_index()
    store(found, outputs)


if __name__ == "__main__":
    run(main, snakemake)
