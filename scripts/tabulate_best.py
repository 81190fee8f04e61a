"""The best combination per range of n_S, and the best of all."""

import json

import pandas as pd

from sparsurf.report import pages
from sparsurf.study import tables
from sparsurf.study.grid import load
from sparsurf.study.tables import as_yardsticks
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings):
    """Write ranges.csv and best.json, and their twins for people."""
    table, grid = pd.read_csv(inputs["grid"]), load(inputs["distances"])
    floors = as_yardsticks(pd.read_csv(inputs["floors"]))
    ranges = tables.ranges_table(table, grid, settings["tables"]["ranges"], floors)
    best = tables.best(table, grid, settings["tables"]["max_n_S_percent"], floors)
    ranges.to_csv(outputs["ranges"], index=False)
    texts = {
        outputs["ranges_md"]: pages.ranges_markdown(ranges, best["yardsticks"], best["draws"]),
        outputs["best_md"]: pages.best_markdown(best),
        outputs["best"]: json.dumps(best, indent=2) + "\n",
    }
    for path, text in texts.items():
        with open(path, "w", encoding="utf-8") as stream:
            stream.write(text)


if __name__ == "__main__":
    run(main, snakemake)
