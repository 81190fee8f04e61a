"""The best combination per range of n_S, and the best of all."""

import json
from pathlib import Path

from sparsurf.report.page import write
from sparsurf.report.ranges_page import TEMPLATE, TWIN, ranges_page
from sparsurf.study import tables
from sparsurf.study.grid import load
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, name):
    """Write ranges.csv and best.json, and their page."""
    grid = load(inputs["distances"])
    table = tables.read_table(inputs["grid"], len(grid.combinations), "combinations")
    floors = tables.as_references(tables.read_table(inputs["floors"]))
    ranges = tables.ranges_table(table, grid, settings["tables"]["ranges"], floors)
    best = tables.best(table, grid, settings["tables"]["max_n_S_percent"], floors)
    ranges.to_csv(outputs["ranges"], index=False)
    Path(outputs["best"]).write_text(json.dumps(best, indent=2) + "\n", encoding="utf-8")
    known = ranges_page(name, ranges, best, best["references"])
    write(outputs["page"], TEMPLATE, **known)
    write(outputs["markdown"], TWIN, **known)


if __name__ == "__main__":
    run(main, snakemake)
