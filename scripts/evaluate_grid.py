"""Sample a surface with every combination and compare the subsets with the whole."""

import pandas as pd

from sparsurf import evaluation, sampling, tables
from sparsurf.surface import read_surface
from sparsurf.workflow import job, reporter


def main(path_to_surface, path_to_roughness, path_to_grid, path_to_distances, settings, name, threads):
    """Write grid.csv and the raw distances behind it."""
    surface = read_surface(path_to_surface)
    rough = pd.read_csv(path_to_roughness)["roughness"].to_numpy()
    evaluator = evaluation.Evaluator.from_settings(surface, settings, rough, name, threads)
    grid, test = settings["sampling"], settings["evaluation"]
    result = evaluator.grid(
        sampling.grid(grid["alpha"], grid["beta"], grid["gamma"], grid["delta"]),
        evaluation.number_of_tests(test["test_dots"], len(surface)),
        test["draws"],
        tuple(test["islands"]),
        test["shared_test_dots"],
        reporter(name),
    )
    evaluation.save_grid(path_to_distances, result)
    tables.grid_table(result).to_csv(path_to_grid, index=False)


if __name__ == "__main__":
    with job(snakemake) as output:
        main(
            path_to_surface=snakemake.input.surface,
            path_to_roughness=snakemake.input.roughness,
            path_to_grid=output["grid"],
            path_to_distances=output["distances"],
            settings=snakemake.params.settings,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
            threads=snakemake.threads,
        )
