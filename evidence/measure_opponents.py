"""Other ways to keep the surface of one structure in as many bytes."""

from measures import opponents
from measures.molecules import atoms_of
from sparsurf.workflow.jobs import run

MOST_ATOMS = 3_000  # beyond, meshes take minutes each


def main(inputs, outputs, settings, name, threads):
    """Write a row per opponent and n_S, and where each errs; meshes only where the package fast-simplification is installed."""
    atoms = atoms_of(inputs["structure"])
    fewer = opponents.simplifier() if len(atoms[0]) <= MOST_ATOMS else None
    tests, percents = settings["test_dots"], settings["percents"]
    table, where = opponents.measure(name, *atoms, fewer, tests, percents, settings["seed"], threads)
    table.to_csv(outputs["table"], index=False)
    where.to_csv(outputs["where"], index=False)


if __name__ == "__main__":
    run(main, snakemake)
