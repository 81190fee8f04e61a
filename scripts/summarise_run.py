"""All surfaces of a run in one table, and the best parameters against their mean roughness."""

from pathlib import Path

from sparsurf.report.figures import enough, layout, summary_figures
from sparsurf.report.page import write
from sparsurf.report.summary_page import TEMPLATE, summary_page
from sparsurf.streams import stream
from sparsurf.study.summary import (
    read_result,
    relation_table,
    summary_table,
    surfaces_table,
)
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings):
    """Write surfaces.csv, summary.csv, relation.csv, their page and the figures."""
    folders = list(dict.fromkeys(Path(path).parent for path in inputs["results"]))
    results = [read_result(folder) for folder in folders]
    surfaces, summary = surfaces_table(results, settings["patches"]), summary_table(results)
    relations = relation_table(results, summary, stream(settings["seed"], "summary"))
    for key, table in {"surfaces": surfaces, "summary": summary, "relation": relations}.items():
        table.to_csv(outputs[key], index=False)
    draws, name = results[0].best.get("draws"), Path(inputs["results"][0]).parts[-4]
    write(outputs["page"], TEMPLATE, **summary_page(name, surfaces, relations, draws))
    figure = summary_figures.summary_figure(summary, relations, name)
    layout.save(figure, outputs["png"].removesuffix(".png"))
    curves = enough.figure(
        [enough.read(folder) for folder in folders], settings["minimal"].get("floor", enough.FRESH)
    )
    layout.save(curves, outputs["enough"].removesuffix(".png"))


if __name__ == "__main__":
    run(main, snakemake)
