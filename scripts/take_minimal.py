"""The subset of a surface that is handed out, with the number of dots that each of its dots stands for."""

import pandas as pd

from sparsurf.comparison import choices_of, with_choices
from sparsurf.evaluation import Evaluator, number_of_tests
from sparsurf.exports import write_ply
from sparsurf.minimal import minimal_subset
from sparsurf.surface import Surface, read_surface
from sparsurf.workflow import job


def main(path_to_surface, path_to_roughness, path_to_ranges, path_to_table, path_to_ply, settings, name):
    """Write minimal.csv and minimal.ply; the paper's sampler takes its parameters from ranges.csv where given."""
    surface = read_surface(path_to_surface)
    rough = pd.read_csv(path_to_roughness)["roughness"].to_numpy()
    wish = settings["minimal"]
    evaluator = Evaluator.from_settings(surface, settings, rough, name, 1)
    if path_to_ranges:
        evaluator = with_choices(evaluator, choices_of(pd.read_csv(path_to_ranges)))
    dots, weight = minimal_subset(
        evaluator,
        wish["sampler"],
        number_of_dots(wish, len(surface)),
        wish.get("Z"),
        wish.get("combination"),
        number_of_tests(settings["evaluation"]["test_dots"], len(surface)),
    )
    table = pd.DataFrame({"dot": dots})
    table[["x", "y", "z"]] = surface.points[dots]
    table[["nx", "ny", "nz"]] = surface.normals[dots]
    table["weight"] = weight
    table.to_csv(path_to_table, index=False)
    subset = Surface(surface.points[dots], surface.normals[dots])
    write_ply(path_to_ply, subset, weight.astype(float), "weight")


def number_of_dots(wish, n_dots):
    """n_S from the config's n_S or n_S_percent; None where neither is given."""
    if "n_S_percent" in wish:
        return max(1, round(wish["n_S_percent"] / 100 * n_dots))
    return wish.get("n_S")


if __name__ == "__main__":
    with job(snakemake) as output:
        main(
            path_to_surface=snakemake.input.surface,
            path_to_roughness=snakemake.input.roughness,
            path_to_ranges=snakemake.input.get("ranges"),
            path_to_table=output["table"],
            path_to_ply=output["ply"],
            settings=snakemake.params.settings,
            name=f"{snakemake.wildcards.protein}/{snakemake.wildcards.conformation}",
        )
