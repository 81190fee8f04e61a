"""Samplers compared at equal n_S on one surface."""

from functools import partial

import pandas as pd

from sparsurf.molecules.reading import read_molecule
from sparsurf.report import comparison_answer, comparison_page
from sparsurf.report.figures import comparison_figure, layout
from sparsurf.study import comparison, comparison_intervals, dots_needed
from sparsurf.study.evaluator import Evaluator, number_of_tests
from sparsurf.study.tables import as_yardsticks
from sparsurf.study.without_the_surface import dotted, stand_alone
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spacing import area_of
from sparsurf.workflow.jobs import reporter, run


def main(inputs, outputs, settings, name, threads):
    """Write compare.csv with its page and figure, and the tables that follow from it."""
    surface = read_npz(inputs["surface"])
    rough, grid, ranges = (pd.read_csv(inputs[key]) for key in ("roughness", "grid", "ranges"))
    evaluator = Evaluator.from_settings(surface, settings, rough["roughness"].to_numpy(), name, threads)
    percents, names = settings["compare"]["percents"], settings["compare"].get("samplers")
    n_tests = number_of_tests(settings["evaluation"]["test_dots"], len(surface))
    draws = settings["evaluation"]["draws"]
    drawers, raw = comparison.contestants(evaluator, names, ranges, grid, percents), {}
    table = comparison.compare(
        evaluator,
        drawers,
        percents,
        n_tests,
        draws,
        reporter(f"{name}: comparison", "samplers"),
        as_yardsticks(pd.read_csv(inputs["floors"])),
        raw,
    )
    lay = None
    if inputs.get("structure"):
        atoms, rules = read_molecule(inputs["structure"], selection="all", whole=False), settings["surface"]
        lay = partial(
            dotted,
            atoms.xyz[0],
            radii(atoms, rules["radii"]),
            probe=rules["probe_radius"],
            reentrant=rules["reentrant"],
        )
    against = dict.fromkeys([*comparison_intervals.AGAINST, comparison_answer.best_of(table)[-1]])
    own = {key: drawers[key] for key in ("farthest", "uniform") if key in drawers}
    more = {
        "pairs": comparison_intervals.paired(raw, percents, against=against),
        "fewer": comparison_intervals.times_fewer_intervals(raw, table, evaluator.stream("times fewer")),
        "alone": stand_alone(evaluator, own, lay, percents, n_tests, draws),
    }
    for key, each in more.items():
        each.to_csv(outputs[key], index=False)
    table.to_csv(outputs["table"], index=False)
    dots_needed.all_needed(table).to_csv(outputs["needed"], index=False)
    facts = comparison_page.facts(
        len(surface), *area_of(surface), n_tests, draws, comparison.choices_of(ranges)
    )
    with open(outputs["page"], "w", encoding="utf-8") as stream:
        stream.write(comparison_page.compare_markdown(table, name, facts, **more))
    figure = comparison_figure.comparison_figure(table, name)
    layout.save(figure, outputs["png"].removesuffix(".png"))


if __name__ == "__main__":
    run(main, snakemake)
