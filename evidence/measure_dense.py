"""The subset that is handed out of one structure at several densities, recovered at the density of its surface or at 5.35."""

import pandas as pd

from sparsurf.cli.making import rules_of
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.patches.index import D_LINK
from sparsurf.study.enough import Trials
from sparsurf.study.evaluator import Evaluator
from sparsurf.study.floors import FRESH, floors
from sparsurf.study.minimal import smallest_recovered
from sparsurf.surfaces.molecular_surface import fitting_surface, layer
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.workflow.jobs import run


class AtOneDensity(Evaluator):
    """Recovers every surface at 5.35 dots per Å^2, whatever its own density."""

    density = DENSITY


def main(inputs, outputs, settings, name, threads):
    """Write a row for each surface: with hydrogens and without, and at each density."""
    rows = []
    surfaces = [("keep", "auto"), ("remove", "auto"), *(("keep", each) for each in settings["densities"])]
    for hydrogens, asked in surfaces:
        molecule = read_molecule(inputs["structure"], hydrogens=hydrogens)
        atoms, rules = radii(molecule, "dms"), rules_of(1.4, asked, "keep")
        surface, density = fitting_surface(molecule, 0, atoms, rules, D_LINK, name)
        row = {"protein": name, "hydrogens": hydrogens, "asked": asked, "density": density, "N": len(surface)}
        of_surface = Evaluator(surface, seed=settings["seed"], threads=threads)
        lay = layer(molecule, 0, atoms, rules, D_LINK, name)
        table = floors(of_surface, settings["test_dots"], **lay)
        row["floor"] = table.set_index("floor").loc[FRESH, "Z"]
        for kind, end in ((Evaluator, ""), (AtOneDensity, "_at_5.35")):
            own = kind(surface, roughness_values=of_surface.roughness, seed=settings["seed"], threads=threads)
            trials = Trials(own, "farthest", settings["test_dots"])
            row[f"n_S{end}"] = len(smallest_recovered(trials, table, FRESH))
        rows.append(row)
    pd.DataFrame(rows).to_csv(outputs["table"], index=False)


if __name__ == "__main__":
    run(main, snakemake)
