"""Analyse a batch of structures and write its rows of the tables of the run."""

from sparsurf.batches.analysis import Structure, analyse_batch
from sparsurf.batches.tables import import_pyarrow, write_parquet
from sparsurf.workflow.jobs import job, reporter


def main(structures: dict[str, dict], outputs: dict[str, str], config: dict) -> None:
    """Write a Parquet file of each table.

    Parameters
    ----------
    structures : dict of path, table and options by name
    outputs : paths by the names of the tables
    config : dict, see `analyse_structure`
    """
    import_pyarrow()  # before anything is computed
    batch = [Structure(name, **entry) for name, entry in structures.items()]
    tables = analyse_batch(batch, config, reporter("Structures", "structures"))
    for table, path in outputs.items():
        write_parquet(path, table, tables[table], config["fields"])


if __name__ == "__main__":
    with job(snakemake):
        main(
            structures=snakemake.params.structures,
            outputs=dict(snakemake.output.items()),
            config={
                key: getattr(snakemake.params, key)
                for key in (
                    "surface",
                    "patches",
                    "sampling",
                    "evaluation",
                    "minimal",
                    "fields",
                    "seed",
                )
            },
        )
