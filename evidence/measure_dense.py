"""Minimal subsets of one structure at several densities, recovered at the surface's own density or at 5.35 dots per Å^2."""

import pandas as pd

from sparsurf.api.surfaces import surface_settings
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.patches.index import D_LINK
from sparsurf.study.floors import FRESH, measure_floors
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.study.required_dots import Trials
from sparsurf.study.subset_search import smallest_recovered_subset
from sparsurf.surfaces.molecular_surface import surface_for_d_link, surface_generator
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.workflow.jobs import job


class AtOneDensity(PreparedSurface):
    """Recovers every surface at 5.35 dots per Å^2, whatever its own density."""

    density = DENSITY


def main(
    structure: str, table: str, protein: str, densities: list[float], test_dots: int, seed: int, threads: int
) -> None:
    """Write a row for each surface: with and without hydrogens at the automatic density, and at each density."""
    rows = []
    surfaces = [("keep", "auto"), ("remove", "auto"), *(("keep", density) for density in densities)]
    for hydrogens, requested in surfaces:
        molecule = read_molecule(structure, hydrogens=hydrogens)
        atoms, rules = radii(molecule, "dms"), surface_settings(1.4, requested, "keep")
        dots, density = surface_for_d_link(molecule, 0, atoms, rules, D_LINK, protein)
        row = {"protein": protein, "hydrogens": hydrogens, "requested_density": requested}
        row |= {"density": density, "N": len(dots)}
        prepared = PreparedSurface(dots, seed=seed, threads=threads)
        generate_surface, xyz = surface_generator(molecule, 0, atoms, rules, D_LINK, protein)
        references = measure_floors(prepared, test_dots, generate_surface, xyz)
        row["floor"] = references[FRESH].mean()
        for kind, suffix in ((PreparedSurface, ""), (AtOneDensity, "_at_5.35")):
            recovering = kind(dots, roughness_values=prepared.roughness, seed=seed, threads=threads)
            trials = Trials(recovering, "farthest", test_dots)
            row[f"n_S{suffix}"] = len(smallest_recovered_subset(trials, references, FRESH)[0])
        rows.append(row)
    pd.DataFrame(rows).to_csv(table, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            table=snakemake.output.table,
            protein=snakemake.wildcards.protein,
            densities=snakemake.params.densities,
            test_dots=snakemake.params.test_dots,
            seed=snakemake.params.seed,
            threads=snakemake.threads,
        )
