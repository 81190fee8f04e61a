"""Tables of both descriptors over several structures."""

from measures.steadiness import grid_means, means
from measures.tables import joined, of_logs, store
from sparsurf.workflow.jobs import run

TABLES = ("changes", "linked", "orders", "rows", "samplers", "grid")


def main(inputs, outputs, logs):
    """Write the tables of all structures, and means of what moves a descriptor."""
    found = {key: joined(inputs[key]) for key in TABLES}
    found["changes_means"] = means(found["changes"], ["density", "descriptor", "change"])
    found["linked_means"] = means(found["linked"], ["D_link", "descriptor", "change"])
    found["orders_means"] = means(found["orders"], ["density", "descriptor", "n"])
    found["grid_means"] = grid_means(found["grid"])
    store({f"descriptors_{key}": each for key, each in (found | {"cpu": of_logs(logs)}).items()}, outputs)


if __name__ == "__main__":
    run(main, snakemake)
