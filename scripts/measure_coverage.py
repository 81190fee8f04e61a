"""How often the study's intervals hold the truth: `python scripts/measure_coverage.py results/<run>/<protein>/<conformation> ...`

Writes docs/tables/coverage.csv and docs/coverage.md from surfaces that a study has evaluated over the whole grid. The pool
of each surface (5 CPU minutes) is kept beside its tables as coverage.npz and taken from there the next time.
"""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf.patches.readings import OF_GRID
from sparsurf.report.coverage_page import coverage_markdown
from sparsurf.streams import stream
from sparsurf.study import coverage
from sparsurf.study.evaluator import Evaluator
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.threads import available_cores, over_slices

DOCS = Path(__file__).resolve().parents[1] / "docs"


def main(folders, n, path_to_table, path_to_page):
    """Write the table and the page."""
    cases = [
        (k, r, draws, tests)
        for k in range(len(folders))
        for r in range(len(OF_GRID))
        for draws, tests in coverage.DESIGNS
    ]
    pools = [pool_of(folder) for folder in folders]

    def one(i, _):
        k, r, draws, tests = cases[i]
        rng = stream(0, "coverage", k, r, draws)
        sets = (draws, tests) == coverage.DESIGNS[1]
        table = coverage.replicates(pools[k][0][r], pools[k][1], draws, tests, n, rng, sets)
        own = {"surface": folders[k].parent.name + "/" + folders[k].name, "islands": OF_GRID[r]}
        return pd.DataFrame(
            {**own, "draws": draws, "test_dots": tests, "replicates": n} | table.to_dict("series")
        )

    parts = over_slices(one, len(cases), available_cores(), 1)
    table = pd.concat(parts, ignore_index=True).round(4)
    table.to_csv(path_to_table, index=False)
    path_to_page.write_text(coverage_markdown(table), encoding="utf-8")


def pool_of(folder):
    """d of the contenders of one surface and their ranges; computed once."""
    path = folder / "coverage.npz"
    if not path.is_file():
        rough = pd.read_csv(folder / "roughness.csv")["roughness"].to_numpy()
        name = f"coverage of {folder.parent.name}/{folder.name}"
        surface = read_npz(folder / "surface.npz")
        evaluator = Evaluator(surface, roughness_values=rough, seed=1, name=name, threads=available_cores())
        d, member = coverage.pool(evaluator, pd.read_csv(folder / "grid.csv"), OF_GRID)
        np.savez(path, d=d, member=member)
    with np.load(path) as data:
        return data["d"], data["member"]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", type=Path, nargs="+", help="results/<run>/<protein>/<conformation>")
    parser.add_argument("--replicates", type=int, default=200)
    parser.add_argument("--table", type=Path, default=DOCS / "tables" / "coverage.csv")
    parser.add_argument("--page", type=Path, default=DOCS / "coverage.md")
    wish = parser.parse_args()
    main(wish.folders, wish.replicates, wish.table, wish.page)
