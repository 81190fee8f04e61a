"""Tables of many structures, one below the other, and means over groups of their rows."""

from measures.tables import read_tables, write_tables
from sparsurf.workflow.jobs import job


def main(
    tables: list[str],
    table: str,
    means: str,
    groups: list[str],
    columns: dict[str, tuple[str, str]],
    where: str = "",
) -> None:
    """Write all rows that fulfil `where`, a pandas query, and the means over their groups.

    `columns` gives, for each column of the means, the column that it summarises and how, in the words of pandas.
    """
    rows = read_tables(tables)
    rows = rows.query(where) if where else rows
    write_tables({table: rows, means: rows.groupby(groups, sort=False).agg(**columns).reset_index()})


if __name__ == "__main__":
    with job(snakemake):
        main(
            tables=snakemake.input.tables,
            table=snakemake.output.table,
            means=snakemake.output.means,
            groups=snakemake.params.groups,
            columns=snakemake.params.means,
            where=snakemake.params.where,
        )
