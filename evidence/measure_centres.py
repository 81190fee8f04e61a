"""What of d the always-kept centres of patches have on one surface of the study over many proteins."""

from sparsurf.study.centres import centres_table
from sparsurf.study.evaluator import Evaluator
from sparsurf.study.tables import read_roughness, read_table
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, name, threads):
    """Write a row for each reading that the settings name, and each range."""
    surface = read_npz(inputs["surface"])
    rough = read_roughness(inputs["roughness"], surface)
    evaluator = Evaluator(surface, roughness_values=rough, seed=settings["seed"], name=name, threads=threads)
    grid, ranges = (read_table(inputs[key]) for key in ("grid", "ranges"))
    table = centres_table(evaluator, grid, ranges, settings["test_dots"], settings["draws"])
    table = table[table["reading"].isin(settings["readings"])]
    table.assign(protein=name).to_csv(outputs["table"], index=False)


if __name__ == "__main__":
    run(main, snakemake)
