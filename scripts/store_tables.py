"""Keep the numbers that the README quotes: `python scripts/store_tables.py results/default results/paper [results/bench]`

Writes docs/tables/default_ranges.csv (of the first conformation), paper_facts.csv and bench.csv, and fills the README's
two tables and the plan of docs/cluster.md from them.
"""

import json
import sys
from pathlib import Path

import pandas as pd

from sparsurf.report.readme_tables import filled, plan_table, readme_tables
from sparsurf.study.paper_facts import paper_facts

ROOT = Path(__file__).resolve().parents[1]
FRAMES = 1001  # of the embedded trajectory


def main(default, paper, bench=None, docs=ROOT / "docs" / "tables", readme=ROOT / "README.md"):
    """Store the tables and fill the pages; without `bench` the plan stays as it is."""
    first = sorted(Path(default).glob("*/*/ranges.csv"))[0]
    ranges = pd.read_csv(first).drop(columns="best_set").round(4)
    ranges.to_csv(docs / "default_ranges.csv", index=False)
    paper_facts(paper).to_csv(docs / "paper_facts.csv", index=False)
    stored = pd.read_csv(docs / "default_ranges.csv"), pd.read_csv(docs / "paper_facts.csv", dtype=str)
    readme.write_text(filled(readme.read_text(encoding="utf-8"), readme_tables(*stored)), encoding="utf-8")
    if bench is None:
        return
    figures = json.loads((Path(bench) / "bench.json").read_text(encoding="utf-8"))["figures"]
    figures = pd.DataFrame(figures).astype({"dots": "Int64"})
    figures.to_csv(docs / "bench.csv", index=False, float_format="%.3g")
    page = docs.parent / "cluster.md"
    plan = {"plan": plan_table(pd.read_csv(docs / "bench.csv"), bytes_per_frame())}
    page.write_text(filled(page.read_text(encoding="utf-8"), plan), encoding="utf-8")


def bytes_per_frame(folder=ROOT / "data" / "tdp43"):
    """Size of the embedded trajectory by its frames."""
    return (folder / "trajectory.xtc").stat().st_size / FRAMES


if __name__ == "__main__":
    main(*sys.argv[1:4])
