"""How the number of dots that are enough scatters over seeds, and how often its interval holds the truth."""

import numpy as np
import pandas as pd

from sparsurf.api.surfaces import surface_settings
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.patches.index import D_LINK
from sparsurf.recovery.readings import RECOVERED
from sparsurf.study.crossing import fitted_crossing
from sparsurf.study.floors import FRESH, measure_floors
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.study.required_dots import FLOOR_FACTOR, Trials, required_to_recover
from sparsurf.surfaces.molecular_surface import surface_for_d_link, surface_generator
from sparsurf.surfaces.radii import radii
from sparsurf.workflow.jobs import job

MOST_PERCENT = 30  # of the dots, up to which the pooled curve is measured


def main(structure: str, table: str, protein: str, seeds: int, test_dots: int, threads: int) -> None:
    """Write a row: truth (n_S in % of the curve pooled over all seeds), and the answers of single seeds.

    Columns: protein, N, seeds, truth, lowest, median, highest (% of the dots), sd_ln (standard deviation of ln n_S), low
    and high (medians of the ends of the intervals, %), held (share of intervals that hold the truth).
    """
    molecule = read_molecule(structure)
    atoms, rules = radii(molecule, "dms"), surface_settings(1.4, "auto", "keep")
    dots, _ = surface_for_d_link(molecule, 0, atoms, rules, D_LINK, protein)
    generate_surface, xyz = surface_generator(molecule, 0, atoms, rules, D_LINK, protein)
    first = PreparedSurface(dots, threads=threads)
    answers, curves = [], []
    for seed in range(1, seeds + 1):
        prepared = PreparedSurface(dots, roughness_values=first.roughness, seed=seed, threads=threads)
        trials = Trials(prepared, "farthest", test_dots)
        floor = measure_floors(prepared, test_dots, generate_surface, xyz, moved=())[FRESH]
        sizes = trials.sizes[trials.sizes <= MOST_PERCENT / 100 * len(dots)]
        curves.append(trials.measured(sizes, RECOVERED)[1] / floor.mean())
        answers.append(required_to_recover(trials, floor)[:3])
    pooled = np.mean(curves, axis=0)[:, None, None]
    rng = np.random.default_rng(0)
    truth = fitted_crossing(sizes.astype(float), pooled, np.ones((1, 1)), FLOOR_FACTOR, len(dots), rng).n
    n, low, high = np.array(answers, float).T
    percents = (
        100 / len(dots) * np.array([truth, n.min(), np.median(n), n.max(), np.median(low), np.median(high)])
    )
    columns = dict(zip(("truth", "lowest", "median", "highest", "low", "high"), percents, strict=True))
    row = {"protein": protein, "N": len(dots), "seeds": seeds, **columns, "sd_ln": np.log(n).std(ddof=1)}
    row["held"] = float(((low <= truth) & (truth <= high)).mean())
    pd.DataFrame([row]).to_csv(table, index=False, float_format="%.4g")


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            table=snakemake.output.table,
            protein=snakemake.wildcards.protein,
            seeds=snakemake.params.seeds,
            test_dots=snakemake.params.test_dots,
            threads=snakemake.threads,
        )
