"""Tables of the study over many proteins, and the evidence that `sparsurf recommend` answers from."""

from pathlib import Path

import pandas as pd

from measures.protein_tables import tables_of
from measures.studies import measured, sizes
from measures.tables import of_logs, store
from sparsurf.recovery.readings import RECOVERED
from sparsurf.workflow.jobs import run

PACKED = {"method": "gzip", "mtime": 0}  # the same bytes for the same table


def main(outputs, runs, hydrogens):
    """Write every table.

    `runs` names the folder and the proteins of each run: of the grid, of a quarter and of all of it recovered.
    """
    folder, names = runs["proteins"]
    own = {key: pd.read_csv(Path(folder, f"{key}.csv")) for key in ("summary", "relation", "surfaces")}
    own["summary"]["best_set"] = own["summary"]["best_set"].fillna("")
    own["surfaces"] = own["surfaces"].merge(sizes(folder, names)).assign(hydrogens=hydrogens)
    others = (measured(*runs[key], RECOVERED) for key in ("recovered", "whole"))
    found = tables_of(measured(folder, names), *own.values(), *others)
    tables = {f"proteins_{name}": table for name, table in found.items()}
    logs = [f"{folder}/logs" for folder, _ in runs.values()]
    store(tables | {"proteins_cpu": of_logs(*logs)}, outputs)
    for key, table in own.items():
        table.to_csv(outputs[key], index=False, float_format="%.5g", compression=PACKED)


if __name__ == "__main__":
    run(main, snakemake)
