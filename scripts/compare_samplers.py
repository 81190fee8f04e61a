"""Samplers compared at equal n_S on one surface."""

from functools import partial

from sparsurf.molecules.read_molecule import read_own
from sparsurf.report import comparison_page
from sparsurf.report.figures import comparison_figure, layout
from sparsurf.report.page import write
from sparsurf.sampling.combination import OF_PAPER, choices_of
from sparsurf.study.centres import centres_table
from sparsurf.study.comparison import contestants, fewer, measuring
from sparsurf.study.comparison.contestants import dotted
from sparsurf.study.comparison.measuring import stand_alone
from sparsurf.study.evaluator import Evaluator, number_of_tests
from sparsurf.study.tables import as_references, combinations_in, read_roughness, read_table
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spacing import area_of
from sparsurf.workflow.jobs import reporter, run


def main(inputs, outputs, settings, name, threads):
    """Write compare.csv with its page and figure, and the tables that follow from it."""
    surface = read_npz(inputs["surface"])
    rough, ranges = read_roughness(inputs["roughness"], surface), read_table(inputs["ranges"])
    grid = read_table(inputs["grid"], combinations_in(ranges), "combinations")
    evaluator = Evaluator.from_settings(surface, settings, rough, name, threads)
    percents, names = settings["compare"]["percents"], settings["compare"].get("samplers")
    n_tests = number_of_tests(settings["evaluation"]["test_dots"], len(surface))
    draws = settings["evaluation"]["draws"]
    drawers, raw = contestants.contestants(evaluator, names, ranges, grid, percents), {}
    table = measuring.compare(
        evaluator,
        drawers,
        percents,
        n_tests,
        draws,
        reporter(f"{name}: comparison", "samplers"),
        as_references(read_table(inputs["floors"])),
        raw,
    )
    lay = None
    if inputs.get("structure"):
        atoms, rules = read_own(inputs["structure"]), settings["surface"]
        lay = partial(
            dotted,
            atoms.xyz[0],
            radii(atoms, rules["radii"]),
            probe=rules["probe_radius"],
            reentrant=rules["reentrant"],
            cavities=rules.get("cavities", "keep"),
        )
    against = dict.fromkeys([*fewer.AGAINST, comparison_page.best_of(table)[-1]])
    own = {key: drawers[key] for key in ("farthest", "uniform") if key in drawers}
    more = {
        "pairs": fewer.paired(raw, percents, against=against),
        "fewer": fewer.times_fewer_intervals(raw, table, evaluator.stream("times fewer")),
        "alone": stand_alone(evaluator, own, lay, percents, n_tests, draws),
        "centres": centres_table(evaluator, grid, ranges, n_tests, draws),
    }
    for key, each in more.items():
        each.to_csv(outputs[key], index=False)
    table.to_csv(outputs["table"], index=False)
    fewer.all_needed(table).to_csv(outputs["needed"], index=False)
    area, estimated = area_of(surface)
    facts = {"n_dots": len(surface), "area": area, "estimated": estimated, "n_tests": n_tests, "draws": draws}
    facts["of_paper"] = choices_of(ranges) is OF_PAPER
    shown = (more[key] for key in ("fewer", "pairs", "alone", "centres"))
    page = comparison_page.comparison_page(name, table, *shown, **facts)
    write(outputs["page"], comparison_page.TEMPLATE, **page)
    figure = comparison_figure.comparison_figure(table, name)
    layout.save(figure, outputs["png"].removesuffix(".png"))


if __name__ == "__main__":
    run(main, snakemake)
