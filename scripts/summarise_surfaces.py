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
    """Write surfaces.csv and the figure of how many dots are enough; of a grid summary.csv, relation.csv, page and figure."""
    sampled = "summary" in outputs
    folders = list(dict.fromkeys(Path(path).parent for path in inputs["results"]))
    results = [read_result(folder, sampled) for folder in folders]
    surfaces = surfaces_table(results, settings["patches"])
    surfaces.to_csv(outputs["surfaces"], index=False)
    if sampled:
        summary = summary_table(results)
        relations = relation_table(results, summary, stream(settings["seed"], "summary"))
        summary.to_csv(outputs["summary"], index=False)
        relations.to_csv(outputs["relation"], index=False)
        draws, name = results[0].best.get("draws"), folders[0].parts[-3]
        write(outputs["page"], TEMPLATE, **summary_page(name, surfaces, relations, draws))
        figure = summary_figures.summary_figure(summary, relations, name)
        layout.save(figure, outputs["png"].removesuffix(".png"))
    curves = enough.figure(
        [enough.read(folder, sampled) for folder in folders], settings["minimal"].get("floor", enough.FRESH)
    )
    layout.save(curves, outputs["enough"].removesuffix(".png"))


if __name__ == "__main__":
    run(main, snakemake)
