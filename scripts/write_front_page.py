"""The first page of a run, alone and as the first page of the report."""

from pathlib import Path

import pandas as pd

from sparsurf.report.first_page import FRESH, TEMPLATE, first_page
from sparsurf.report.page import embedded, linked_in_report, render, write
from sparsurf.workflow.jobs import run


def main(inputs, outputs, folder, without, floor=FRESH):
    """Write index.html, the part of the report and failures.csv; see `first_page` for `without` and `floor`.

    They link to `pages`, which the report holds, and to what is `beside` it.
    """
    held, beside = (
        [str(Path(path).relative_to(folder)) for path in _listed(inputs.get(key, []))]
        for key in ("pages", "beside")
    )
    known = first_page(folder, held, beside, list(without.items()), floor)
    write(outputs["html"], TEMPLATE, **known)
    table = pd.DataFrame(without.items(), columns=["place", "reason"])
    table.to_csv(outputs["failures"], index=False)
    if "part" in outputs:
        figure = known["main_figure"]
        known["main_figure"] = figure and figure | {"src": embedded(Path(folder, figure["path"]))}
        page = linked_in_report(render(TEMPLATE, **known, in_report=True), folder, held)
        Path(outputs["part"]).write_text(page, encoding="utf-8")


def _listed(paths):
    return [paths] if isinstance(paths, str) else paths


if __name__ == "__main__":
    run(main, snakemake)
