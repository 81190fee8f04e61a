"""Tables of the subsets that dense surfaces hand out."""

from measures import recovery
from measures.tables import joined, of_logs, store
from sparsurf.workflow.jobs import run


def main(inputs, outputs, logs):
    """Write them."""
    table = joined(inputs["tables"])
    found = {"recover_dense": table, "recover_dense_means": recovery.dense_means(table)}
    store(found | {"dense_cpu": of_logs(logs)}, outputs)


if __name__ == "__main__":
    run(main, snakemake)
