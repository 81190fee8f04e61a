"""Analyse a batch of structures and write its rows of the tables of the run."""

from sparsurf_study.workflow.jobs import job, reporter
from sparsurf_study.batches.analysis import Structure, analyse_batch
from sparsurf_study.batches.tables import import_pyarrow, write_parquet

with job(snakemake) as s:
    import_pyarrow()  # before anything is computed
    batch = [Structure(name, **entry) for name, entry in s.params.structures.items()]
    tables = analyse_batch(batch, s.settings, s.params.seed, reporter("Structures", "structures"))
    for table, path in s.output.items():
        write_parquet(path, table, tables[table], s.settings.fields)
