"""Cost of recovering many dots from a tenth of the dots of copies of one structure."""

import pandas as pd

from measures import recovery
from measures.molecules import atoms_of
from sparsurf.workflow.jobs import job


def main(structure: str, table: str, dots: int) -> None:
    """Write CPU seconds per million dots and bytes per dot; this process must not have done anything before."""
    points, normals = recovery.copies_of_a_tenth(*atoms_of(structure), dots)
    pd.DataFrame([recovery.cost(points, normals)]).to_csv(table, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            table=snakemake.output.table,
            dots=snakemake.params.dots,
        )
