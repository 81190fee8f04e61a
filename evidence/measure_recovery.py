"""What surfaces recovered from subsets of one structure are worth."""

from measures import recovery
from measures.molecules import atoms_of
from sparsurf.workflow.jobs import run

MOST_ATOMS = 20_000  # beyond, farthest dots alone


def main(inputs, outputs, settings, name, threads):
    """Write a row per sampler and n_S, and the floors."""
    atoms = atoms_of(inputs["structure"])
    names = recovery.NAMES[:1] if len(atoms[0]) > MOST_ATOMS else recovery.NAMES
    tests, percents = settings["test_dots"], settings["percents"]
    floors, subsets = recovery.measure(name, *atoms, tests, percents, names, settings["seed"], threads)
    floors.to_csv(outputs["floors"], index=False)
    subsets.to_csv(outputs["subsets"], index=False)


if __name__ == "__main__":
    run(main, snakemake)
