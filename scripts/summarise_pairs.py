"""Agreement of the maps with the interface, over all pairs of a run."""

from pathlib import Path

import pandas as pd

from sparsurf.report.front_page import links_to_pairs
from sparsurf.report.html import write_first_page
from sparsurf.report.pair_page import pairs_markdown
from sparsurf.study.complexes import means_over_complexes
from sparsurf.workflow.jobs import run


def main(inputs, outputs):
    """Write pairs.csv, a row per pair, partner and score, and their means; tables end in pairs/<pair>/agreement.csv.

    In a run of pairs alone the page is the run's first, too.
    """
    tables = [pd.read_csv(path).assign(complex=Path(path).parent.name) for path in inputs["tables"]]
    table = pd.concat(tables)
    means = means_over_complexes(table, ["score"])
    table.to_csv(outputs["table"], index=False)
    means.to_csv(outputs["means"], index=False)
    known = (means, len(tables), table["complex"].nunique())
    Path(outputs["page"]).write_text(pairs_markdown(*known), encoding="utf-8")
    if "html" in outputs:
        folder = Path(inputs["tables"][0]).parents[2]
        held, beside = (
            [str(Path(path).relative_to(folder)) for path in inputs[key]] for key in ("pages", "beside")
        )
        links = links_to_pairs([*beside, *held])
        page = pairs_markdown(*known, f"Results of the run {folder.name}", links)
        write_first_page(page, folder, outputs, held)


if __name__ == "__main__":
    run(main, snakemake)
