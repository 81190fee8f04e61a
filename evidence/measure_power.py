"""Runs of Table I made by one changed rule."""

from measures.power import grid_of, runs_of
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.molecular_surface import surface_of
from sparsurf.surfaces.radii import radii
from sparsurf.workflow.jobs import reporter, run


def main(inputs, outputs, settings, variant, threads):
    """Write the winners of every run, and the number of centres."""
    molecule = read_molecule(inputs["structure"])
    surface = surface_of(molecule, 0, radii(molecule, "dms"), settings["surface"])
    combinations = grid_of(settings["sampling"])
    rules, runs = settings["rules"], settings["runs"]
    progress = reporter(variant, "runs of the grid")
    table = runs_of(
        surface, combinations, rules, settings["seed"], f"power {variant}", runs, threads, progress
    )
    table.to_csv(outputs["table"], index=False)


if __name__ == "__main__":
    run(main, snakemake)
