"""Sum up many complexes: `python scripts/write_complexes.py results/complexes docs`.

Reads what `study_complexes.py` measured, of every descriptor, writes docs/tables/complexes*.csv, and docs/complexes.md
from these tables and that of `thin_complexes.py`.
"""

import sys
from pathlib import Path

import pandas as pd

from sparsurf import InputError
from sparsurf.patches.descriptors import PUBLISHED
from sparsurf.report.complexes_page import TABLES, complexes_markdown
from sparsurf.study.complex_tables import tables_of


def measured(path_to_results, name):
    """The tables of one name of all descriptors, the published one first."""
    paths = sorted(
        Path(path_to_results).glob(f"*/{name}.csv"), key=lambda path: path.parent.name != PUBLISHED
    )
    if not paths:
        raise InputError(f"{path_to_results} holds no {name}.csv: run scripts/study_complexes.py first.")
    tables = [pd.read_csv(path) for path in paths]
    if name != "areas":
        tables = [
            table.assign(descriptor=path.parent.name) for table, path in zip(tables, paths, strict=True)
        ]
    return pd.concat(tables)


def main(path_to_results, path_to_docs):
    """Write the tables and the page."""
    docs = Path(path_to_docs)
    found = tables_of(*(measured(path_to_results, name) for name in ("areas", "contacts", "controls")))
    for name, table in found.items():
        table.to_csv(docs / "tables" / f"{name}.csv", index=False, float_format="%.4f")
    stored = {name: pd.read_csv(docs / "tables" / f"{name}.csv") for name in TABLES}
    (docs / "complexes.md").write_text(complexes_markdown(stored), encoding="utf-8")


if __name__ == "__main__":
    try:
        main(*sys.argv[1:3])
    except InputError as error:
        sys.exit(str(error))
