"""Sample a surface with every combination and compare the subsets with the whole."""

from sparsurf.sampling import law
from sparsurf.study import grid, tables
from sparsurf.study.evaluator import Evaluator, number_of_tests
from sparsurf.study.tables import read_roughness
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import reporter, run


def main(inputs, outputs, settings, name, threads):
    """Write grid.csv and the raw distances behind it."""
    surface = read_npz(inputs["surface"])
    rough = read_roughness(inputs["roughness"], surface)
    evaluator = Evaluator.from_settings(surface, settings, rough, name, threads)
    test = settings["evaluation"]
    result = grid.run(
        evaluator,
        law.grid(**settings["sampling"]),
        number_of_tests(test["test_dots"], len(surface)),
        test["draws"],
        tuple(test["readings"]),
        test["shared_test_dots"],
        reporter(name),
    )
    grid.save(outputs["distances"], result)
    tables.grid_table(result).to_csv(outputs["grid"], index=False)


if __name__ == "__main__":
    run(main, snakemake)
