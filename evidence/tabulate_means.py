"""Tables of many structures, one below the other, and means over groups of their rows."""

from measures.tables import joined, store
from sparsurf.workflow.jobs import run


def main(inputs, outputs, table, groups, means, where=None):
    """Write `table` with the rows of all, those `where` a condition holds, and <table>_means.

    `means` has a column of the means for each name: what it is of, and how it is formed, as pandas says it.
    """
    rows = joined(inputs["tables"])
    rows = rows.query(where) if where else rows
    store(
        {table: rows, f"{table}_means": rows.groupby(groups, sort=False).agg(**means).reset_index()}, outputs
    )


if __name__ == "__main__":
    run(main, snakemake)
