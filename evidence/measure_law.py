"""Errors of the surfaces reconstructed from few dots of several structures, by the density of the kept dots."""

import pandas as pd

import sparsurf
from measures import law
from measures.molecules import first_model
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf_study.workflow.jobs import job, reporter

with job(snakemake):
    params, errors, parts, progress = snakemake.params, [], [], reporter("The law", "surfaces")
    for k, (name, path) in enumerate(params.structures.items()):
        molecule = first_model(name, path, params.hydrogens)
        if molecule is None:
            continue
        streams = Streams(params.seed, f"law {name}")
        prepared = PreparedSurface(sparsurf.surface(molecule), Settings(), None, streams)
        found = law.errors_by_density(prepared, params.densities)
        known = {"group": params.group, "structure": name, "atoms": molecule.n_atoms, "area": prepared.area}
        for tables, table in zip((errors, parts), found, strict=True):
            tables.append(pd.DataFrame(known | table.to_dict("series")))
        progress(k + 1, len(params.structures))
    pd.concat(errors).to_csv(snakemake.output.errors, index=False)
    pd.concat(parts).to_csv(snakemake.output.parts, index=False)
