"""What few dots give back of fields, over proteins."""

from measures.tables import joined, store
from sparsurf.workflow.jobs import run


def main(inputs, outputs):
    """Write the tables of all, and means."""
    table = joined(inputs["tables"])
    means = table.groupby(["field", "percent"], sort=False).agg(
        r=("r", "mean"),
        lowest=("r", "min"),
        rms=("rms", "mean"),
        rms_sd=("rms_sd", "mean"),
        proteins=("r", "size"),
    )
    store({"fields": table, "fields_means": means.reset_index()}, outputs)


if __name__ == "__main__":
    run(main, snakemake)
