"""All sites against all surfaces that were searched for them."""

from pathlib import Path

import pandas as pd

from sparsurf.report.figures import layout
from sparsurf.report.figures.site_figures import matrix_figure
from sparsurf.report.site_page import is_found
from sparsurf.workflow.jobs import run

COLUMNS = ("target", "score", "p", "places")


def main(inputs, outputs):
    """Write matrix.csv, a row per site and target, and its picture; the tables of hits end in <site>/hits.csv."""
    tables = {Path(path).parent.name: pd.read_csv(path, usecols=COLUMNS) for path in inputs["hits"]}
    table = pd.concat([own.assign(found=is_found(own).astype(int)) for own in tables.values()], keys=tables)
    table = table.droplevel(1).rename_axis("site").reset_index()[["site", *COLUMNS, "found"]]
    table.to_csv(outputs["matrix"], index=False)
    layout.save(matrix_figure(Path(outputs["png"]).parts[-3], table), outputs["png"].removesuffix(".png"))


if __name__ == "__main__":
    run(main, snakemake)
