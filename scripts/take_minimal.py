"""The subset of a surface that is handed out, which is enough to have the surface back."""

import pandas as pd

from sparsurf.recovery.recovering import REACH, spacing_of
from sparsurf.recovery.settling import settle
from sparsurf.sampling.samplers import weights
from sparsurf.study.comparison import choices_of
from sparsurf.study.evaluator import Evaluator, number_of_tests
from sparsurf.study.minimal import minimal_subset
from sparsurf.study.minimal_by_floor import enough_dots, smallest
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf.surfaces.surface import Surface
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, name):
    """Write minimal.csv, minimal.ply and enough.csv; the paper's sampler takes its parameters from ranges.csv where given."""
    surface = read_npz(inputs["surface"])
    rough = pd.read_csv(inputs["roughness"])["roughness"].to_numpy()
    wish = settings["minimal"]
    evaluator = Evaluator.from_settings(surface, settings, rough, name, 1)
    choices = choices_of(pd.read_csv(inputs["ranges"]) if "ranges" in inputs else None)
    n_tests = number_of_tests(settings["evaluation"]["test_dots"], len(surface))
    floors = pd.read_csv(inputs["floors"])
    enough = enough_dots(evaluator, wish["sampler"], floors, n_tests, choices, settled=wish["settle"])
    enough.to_csv(outputs["enough"], index=False)
    if "floor" in wish:
        dots = smallest(
            evaluator, wish["sampler"], floors, wish["floor"], enough, n_tests, choices, wish["settle"]
        )
        weight = weights(surface.points, dots)
    else:
        size, z = number_of_dots(wish, len(surface)), wish.get("Z")
        dots, weight = minimal_subset(
            evaluator, wish["sampler"], size, z, wish.get("combination"), n_tests, choices
        )
    subset = Surface(surface.points[dots], surface.normals[dots])
    if wish["settle"]:
        subset = Surface(*settle(subset.points, subset.normals, surface.points, surface.normals))
    table = pd.DataFrame({"dot": dots})
    table[["x", "y", "z"]] = subset.points
    table[["nx", "ny", "nz"]] = subset.normals
    table["weight"], table["spacing"], table["reach"] = (
        weight,
        spacing_of(subset.points, subset.normals),
        REACH,
    )
    table.to_csv(outputs["table"], index=False)
    columns = {key: table[key].to_numpy(float) for key in ("spacing", "reach")}
    write_ply(outputs["ply"], subset, weight.astype(float), "weight", columns)


def number_of_dots(wish, n_dots):
    """n_S from the config's n_S or n_S_percent; None where neither is given."""
    if "n_S_percent" in wish:
        return max(1, round(wish["n_S_percent"] / 100 * n_dots))
    return wish.get("n_S")


if __name__ == "__main__":
    run(main, snakemake)
