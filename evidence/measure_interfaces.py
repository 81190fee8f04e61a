"""AUC of interface residues from points of several densities, over many complexes; needs the package scikit-learn."""

from importlib.util import find_spec

import pandas as pd
from threadpoolctl import threadpool_limits

from measures import interfaces
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf_study.workflow.jobs import job

with job(snakemake), threadpool_limits(1):
    seed, tables, table = snakemake.params.seed, [], pd.DataFrame(columns=["density", *interfaces.MEASURES])
    if find_spec("sklearn") is None:
        print("scikit-learn is not installed: nothing is measured (pip install scikit-learn).")
    else:
        for name, paths in snakemake.params.complexes.items():
            pair = [read_molecule(path) for path in paths]
            for side in (0, 1):
                rows = interfaces.residues_of(pair[side], pair[1 - side], snakemake.params.densities, seed)
                tables.append(rows.assign(complex=name, partner=side))
        table = interfaces.areas(pd.concat(tables, ignore_index=True))
    table.to_csv(snakemake.output.table, index=False, float_format="%.4f")
