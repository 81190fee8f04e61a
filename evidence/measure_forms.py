"""Places of both partners of a complex, described on their bound and on their unbound forms."""

import numpy as np
import pandas as pd

import sparsurf
from measures import sites
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.pairs.interface import interface
from sparsurf.streams import stream
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, pair):
    """Write the numbers, the Sites of unbound forms and of bound interfaces, and what describing costs."""
    bound, unbound = ([read_molecule(path) for path in inputs[form]] for form in ("bound", "unbound"))
    dots = [sparsurf.surface(molecule) for molecule in bound]
    rows = []
    for side, (own, other) in enumerate((dots, dots[::-1])):
        name = f"{pair}_{'rl'[side]}"
        touching = interface(own.points, other.points)
        rng = stream(settings["seed"], "sites", name)
        how = settings["percents"], settings["places"], settings["learned"], rng
        arrays, costs, target, site = sites.forms(bound[side], own, touching, unbound[side], *how)
        np.savez(outputs[f"numbers_{side + 1}"], **arrays)
        target.save(outputs[f"target_{side + 1}"])
        (target.take([]) if site is None else site).save(outputs[f"site_{side + 1}"])
        rows += [(name, unbound[side].n_atoms, *cost) for cost in costs]
    columns = ["protein", "atoms", "percent", "dots", "places", "bytes", "seconds"]
    pd.DataFrame(rows, columns=columns).to_csv(outputs["costs"], index=False)


if __name__ == "__main__":
    run(main, snakemake)
