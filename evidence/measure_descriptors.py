"""How far a rotation and fresh dots change each descriptor on one structure, and the paper's tables with each descriptor."""

import pandas as pd

from measures import steadiness
from measures.molecules import atoms_of
from sparsurf.patches.index import D_LINK
from sparsurf.sampling import published
from sparsurf.streams import stream
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.workflow.jobs import job


def main(
    structure: str,
    changes: str,
    linked: str,
    orders: str,
    rows: str,
    samplers: str,
    grid: str,
    protein: str,
    test_dots: int,
    densities: list[float],
    d_link: list[float],
    percents: list[float],
    sampling: dict[str, list[float]],
    grid_test_dots: int,
    seed: int,
    threads: int,
) -> None:
    """Write a table for each question."""
    xyz, radii = atoms_of(structure)
    surface = molecular_surface(xyz, radii)
    tests = surface.points[stream(seed, protein, "tests").permutation(len(surface))[:test_dots]]

    def steadiness_at(density: float, link: float) -> tuple[pd.DataFrame, pd.DataFrame]:
        turns = stream(seed, protein, "turns")
        return steadiness.steadiness(xyz, radii, tests, turns, density, link, threads)

    by_density = [steadiness_at(density, D_LINK) for density in densities]
    by_link = {D_LINK: by_density[0][0]} | {link: steadiness_at(DENSITY, link)[0] for link in d_link}
    prepared = PreparedSurface(surface, seed=seed, name=protein, threads=threads)
    combinations = published.parameter_grid(**sampling)
    tables = {
        changes: pd.concat([table for table, _ in by_density]),
        orders: pd.concat([table for _, table in by_density]),
        linked: pd.concat([table.assign(D_link=link) for link, table in by_link.items()]),
        rows: steadiness.rows_of_paper(prepared, test_dots),
        samplers: steadiness.of_samplers(prepared, test_dots, percents),
        grid: steadiness.whole_grid(prepared, combinations, grid_test_dots),
    }
    for path, table in tables.items():
        table.assign(surface=protein).to_csv(path, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            changes=snakemake.output.changes,
            linked=snakemake.output.linked,
            orders=snakemake.output.orders,
            rows=snakemake.output.rows,
            samplers=snakemake.output.samplers,
            grid=snakemake.output.grid,
            protein=snakemake.wildcards.protein,
            test_dots=snakemake.params.test_dots,
            densities=snakemake.params.densities,
            d_link=snakemake.params.d_link,
            percents=snakemake.params.percents,
            sampling=snakemake.params.sampling,
            grid_test_dots=snakemake.params.grid_test_dots,
            seed=snakemake.params.seed,
            threads=snakemake.threads,
        )
