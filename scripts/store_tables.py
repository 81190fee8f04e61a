"""Keep the numbers that the README quotes: `python scripts/store_tables.py results/default results/paper`

Writes docs/tables/default_ranges.csv (of the first conformation) and docs/tables/paper_facts.csv, and fills the README's
two tables from them.
"""

import sys
from pathlib import Path

import pandas as pd

from sparsurf.report.readme_tables import filled, readme_tables
from sparsurf.study.paper_facts import paper_facts

ROOT = Path(__file__).resolve().parents[1]


def main(default, paper, docs=ROOT / "docs" / "tables", readme=ROOT / "README.md"):
    """Store the tables and fill the README."""
    first = sorted(Path(default).glob("*/*/ranges.csv"))[0]
    ranges = pd.read_csv(first).drop(columns="best_set").round(4)
    ranges.to_csv(docs / "default_ranges.csv", index=False)
    paper_facts(paper).to_csv(docs / "paper_facts.csv", index=False)
    stored = pd.read_csv(docs / "default_ranges.csv"), pd.read_csv(docs / "paper_facts.csv", dtype=str)
    readme.write_text(filled(readme.read_text(encoding="utf-8"), readme_tables(*stored)), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:3])
