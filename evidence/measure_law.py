"""Errors of the surfaces reconstructed from few dots of several structures, by the density of the kept dots."""

import pandas as pd

import sparsurf
from measures import law
from sparsurf.errors import InputError
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf_study.workflow.jobs import job, reporter

with job(snakemake):
    params, errors, parts, progress = snakemake.params, [], [], reporter("The law", "surfaces")
    for k, (name, path) in enumerate(params.structures.items()):
        try:
            molecule = read_molecule(path, model=1, hydrogens=params.hydrogens)
        except InputError as error:
            print(f"{name} takes no part: {error}")
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
