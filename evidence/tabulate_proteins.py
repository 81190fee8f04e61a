"""Tables of the study of many proteins."""

import pandas as pd

from measures.protein_tables import tables_of
from measures.studies import read_study, sizes
from measures.tables import cpu_table, write_tables
from sparsurf.recovery.readings import RECOVERED
from sparsurf.workflow.jobs import job

GZIP = {"method": "gzip", "mtime": 0}  # the same bytes for the same table


def main(
    run: str,
    proteins: list[str],
    run_recovered: str,
    proteins_recovered: list[str],
    run_whole: str,
    proteins_whole: list[str],
    hydrogens: str,
    outputs: dict[str, str],
) -> None:
    """Write every table.

    Parameters
    ----------
    run, proteins : folder and proteins of the study of the grid; in the same way of those with a quarter of the grid
        recovered and with the whole grid recovered
    hydrogens : how the studies treat hydrogens
    outputs : paths by the name of the table
    """
    summary = pd.read_csv(f"{run}/summary.csv")
    summary["best_set"] = summary["best_set"].fillna("")
    relation = pd.read_csv(f"{run}/relation.csv")
    surfaces = pd.read_csv(f"{run}/surfaces.csv").merge(sizes(run, proteins)).assign(hydrogens=hydrogens)
    tables = tables_of(
        read_study(run, proteins),
        summary,
        relation,
        surfaces,
        read_study(run_recovered, proteins_recovered, RECOVERED),
        read_study(run_whole, proteins_whole, RECOVERED),
    )
    tables["cpu"] = cpu_table(f"{run}/logs", f"{run_recovered}/logs", f"{run_whole}/logs")
    write_tables({outputs[name]: table for name, table in tables.items()})
    for name, table in (("summary", summary), ("relation", relation), ("surfaces", surfaces)):
        compression = GZIP if outputs[name].endswith(".gz") else None
        table.to_csv(outputs[name], index=False, float_format="%.5g", compression=compression)


if __name__ == "__main__":
    with job(snakemake):
        main(
            run=snakemake.params.run,
            proteins=snakemake.params.proteins,
            run_recovered=snakemake.params.run_recovered,
            proteins_recovered=snakemake.params.proteins_recovered,
            run_whole=snakemake.params.run_whole,
            proteins_whole=snakemake.params.proteins_whole,
            hydrogens=snakemake.params.hydrogens,
            outputs=dict(snakemake.output.items()),
        )
