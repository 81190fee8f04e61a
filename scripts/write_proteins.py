"""Sum up many proteins: `python scripts/write_proteins.py results/over_proteins`.

Reads what `study_proteins.py` measured, writes docs/tables/proteins_*.csv and the evidence of `sparsurf recommend`, and from
these tables docs/proteins.md with its figures; prints the README's paragraph. Without a folder, the page is made again.
"""

import sys
import textwrap
from pathlib import Path

import pandas as pd

from sparsurf import InputError
from sparsurf.recovery.readings import RECOVERED
from sparsurf.report.figures import protein_figures
from sparsurf.report.proteins_answer import readme
from sparsurf.report.proteins_page import STORED, page
from sparsurf.report.recommendation import EVIDENCE, read_run
from sparsurf.study.protein_files import load_all
from sparsurf.study.protein_scores import WHOLE
from sparsurf.study.protein_tables import OF_RECOMMENDATION, tables_of
from sparsurf.study.protein_variants import VARIANTS

WIDTH = 135  # of the README
DOCS = Path(__file__).parents[1] / "docs"
PACKED = {"method": "gzip", "mtime": 0}  # the same bytes for the same table


def write_tables(path_to_results, tables, evidence):
    """Write every table of the study."""
    results = Path(path_to_results)
    places = {variant: results / "variants" / variant for variant in VARIANTS}
    varied = {variant: load_all(place) for variant, place in places.items() if place.is_dir()}
    alone = (results / folder for folder in (RECOVERED, WHOLE))
    recovered, whole = (load_all(folder) if folder.is_dir() else [] for folder in alone)
    for name, table in tables_of(load_all(results), varied, recovered, whole).items():
        if name in OF_RECOMMENDATION:
            path = evidence / f"{name}.csv.gz"
            table.to_csv(path, index=False, float_format="%.5g", compression=PACKED)
        else:
            path = tables / f"proteins_{name}.csv"
            if name == "coverage" and path.is_file():  # what was not measured this time stays, row by row
                before = pd.read_csv(path)
                table = pd.concat([table, before[~before["quantity"].isin(table["quantity"])]])
            table.to_csv(path, index=False, float_format="%.5g")


def read_stored(docs=DOCS, evidence=EVIDENCE):
    """The tables that the page is made of, by name; variants and recovered grids only where they were measured."""
    paths = {name: Path(docs) / "tables" / f"proteins_{name}.csv" for name in STORED}
    return {name: pd.read_csv(path) for name, path in paths.items() if path.is_file()} | read_run(evidence)


def main(path_to_results=None, path_to_docs=DOCS, path_to_evidence=EVIDENCE):
    """Write the tables, then the page and its figures."""
    docs, evidence = Path(path_to_docs), Path(path_to_evidence)
    for folder in (docs / "tables", evidence):
        folder.mkdir(parents=True, exist_ok=True)
    if path_to_results is not None:
        write_tables(path_to_results, docs / "tables", evidence)
    stored = read_stored(docs, evidence)
    (docs / "proteins.md").write_text(page(stored), encoding="utf-8")
    for name, draw in protein_figures.FIGURES.items():
        draw(stored).savefig(docs / f"proteins_{name}.png", dpi=200, metadata={"Software": None})
    print(
        f"The README's paragraph:\n{textwrap.fill(readme(stored), WIDTH, break_long_words=False, break_on_hyphens=False)}"
    )


if __name__ == "__main__":
    try:
        main(*sys.argv[1:3])
    except InputError as error:
        sys.exit(str(error))
