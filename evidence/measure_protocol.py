"""Points of many chains by one protocol: failures, topology and CPU; on every n-th chain also errors."""

import pandas as pd

from measures import protocols
from measures.molecules import atoms_of
from sparsurf.errors import InputError
from sparsurf_study.workflow.jobs import job

COLUMNS = ["protocol", "chain", *protocols.MEASURES]

with job(snakemake):
    name, every, rows = snakemake.wildcards.protocol, snakemake.params.every, []
    step = snakemake.params.every_fast if name in snakemake.params.fast else every
    chains = snakemake.params.structures if protocols.installed(name) else {}
    for path in list(chains.values())[:1]:
        protocols.PROTOCOLS[name].run(*atoms_of(path))  # loads kernels and programs
    for k, (chain, path) in enumerate(chains.items()):
        if k % step:
            continue
        try:
            atoms = atoms_of(path)
        except InputError as error:
            print(f"{chain} takes no part: {error}")
            continue
        row = protocols.measure(name, *atoms, k % every == 0, k % (every * snakemake.params.again) == 0)
        rows.append({"protocol": name, "chain": chain} | row)
    pd.DataFrame(rows, columns=COLUMNS).to_csv(snakemake.output.table, index=False)
