"""Analyse a batch of structures and write its rows of the tables of the run."""

from sparsurf.batches.analysis import Structure, analyse_batch
from sparsurf.batches.tables import import_pyarrow, write_parquet
from sparsurf.settings import Settings
from sparsurf.workflow.jobs import job, reporter


def main(structures: dict[str, dict], outputs: dict[str, str], settings: Settings, seed: int) -> None:
    """Write a Parquet file of each table.

    Parameters
    ----------
    structures : dict of path, table and options by name
    outputs : paths by the names of the tables
    """
    import_pyarrow()  # before anything is computed
    batch = [Structure(name, **entry) for name, entry in structures.items()]
    tables = analyse_batch(batch, settings, seed, reporter("Structures", "structures"))
    for table, path in outputs.items():
        write_parquet(path, table, tables[table], settings.fields)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structures=snakemake.params.structures,
            outputs=dict(snakemake.output.items()),
            settings=Settings.of(snakemake.params),
            seed=snakemake.params.seed,
        )
