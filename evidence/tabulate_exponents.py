"""Whether any exponent gains over evenly spread dots."""

from measures import exponents
from measures.tables import joined, of_logs, store
from sparsurf.workflow.jobs import run


def main(inputs, outputs, logs):
    """Write the measured Z, their ratios to k = 0, and what the best exponent gains."""
    table = joined(inputs["tables"])
    found = {"exponents": table, "exponents_means": exponents.ratios(table)}
    store(found | {"exponents_best": exponents.best(table), "exponents_cpu": of_logs(logs)}, outputs)


if __name__ == "__main__":
    run(main, snakemake)
