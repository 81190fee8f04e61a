"""Samplers compared at equal n_S on one surface."""

import pandas as pd

from sparsurf import comparison, comparison_figure, comparison_tables, comparison_text, page
from sparsurf.evaluation import Evaluator, number_of_tests
from sparsurf.surface import read_surface
from sparsurf.workflow import job, reporter


def main(paths_to_inputs, paths_to_outputs, settings, name, threads):
    """Write compare.csv with its twin for people, needed.csv and the figure."""
    surface = read_surface(paths_to_inputs["surface"])
    rough, grid, ranges = (pd.read_csv(paths_to_inputs[key]) for key in ("roughness", "grid", "ranges"))
    evaluator = Evaluator.from_settings(surface, settings, rough["roughness"].to_numpy(), name, threads)
    percents, names = settings["compare"]["percents"], settings["compare"].get("samplers")
    n_tests = number_of_tests(settings["evaluation"]["test_dots"], len(surface))
    draws = settings["evaluation"]["draws"]
    area = comparison.area_of(surface)
    table = comparison.compare(
        evaluator,
        area[0],
        comparison.contestants(evaluator, names, ranges, grid, percents),
        percents,
        n_tests,
        draws,
        reporter(f"{name}: comparison", "samplers"),
    )
    table.to_csv(paths_to_outputs["table"], index=False)
    comparison_tables.all_needed(table).to_csv(paths_to_outputs["needed"], index=False)
    facts = comparison_text.facts(len(surface), *area, n_tests, draws, comparison.choices_of(ranges))
    with open(paths_to_outputs["page"], "w", encoding="utf-8") as stream:
        stream.write(comparison_text.compare_markdown(table, name, facts))
    figure = comparison_figure.comparison_figure(table, name)
    page.save(figure, paths_to_outputs["png"].removesuffix(".png"))


if __name__ == "__main__":
    with job(snakemake) as output:
        main(
            paths_to_inputs={key: snakemake.input[key] for key in ("surface", "roughness", "grid", "ranges")},
            paths_to_outputs={key: output[key] for key in ("table", "needed", "page", "png")},
            settings=snakemake.params.settings,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            threads=snakemake.threads,
        )
