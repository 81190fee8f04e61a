"""Table I on one surface: its combinations, the choice of each range made again, and where the kept dots lie."""

import pandas as pd

from measures import fragments
from sparsurf.paper.replication import gathering_by_roughness
from sparsurf.sampling.combination import PUBLISHED_ROWS
from sparsurf.study.grid import evaluate_grid
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.workflow.jobs import job, reporter


def main(
    structure: str,
    rows: str,
    choices: str,
    gathering: str,
    dots: str,
    name: str,
    surface: dict,
    patches: dict[str, float],
    sampling: dict[str, list[float]],
    rows_evaluation: dict[str, int],
    grid_evaluation: dict[str, int],
    seed: int,
    threads: int,
) -> None:
    """Write the three tables.

    Parameters
    ----------
    dots : 'file', 'dms' or 'exact', see `fragments.dots_of`
    rows_evaluation, grid_evaluation : test_dots and draws of the ten combinations and of the whole grid
    """
    settings = {key.lower(): value for key, value in patches.items()}
    prepared = PreparedSurface(
        fragments.dots_of(structure, dots, surface),
        **settings,
        seed=seed,
        name=f"fragment {name}",
        threads=threads,
    )
    of_surface = fragments.surface_row(prepared)
    ten = evaluate_grid(prepared, PUBLISHED_ROWS, rows_evaluation["test_dots"], rows_evaluation["draws"])
    grid = evaluate_grid(
        prepared,
        fragments.published_grid(sampling),
        grid_evaluation["test_dots"],
        grid_evaluation["draws"],
        progress=reporter(name),
    )
    tables: dict[str, pd.DataFrame] = {
        rows: fragments.rows_table(ten).assign(**of_surface),
        choices: fragments.choices_table(grid),
        gathering: gathering_by_roughness(prepared, rows_evaluation["draws"]),
    }
    for path, table in tables.items():
        table.insert(0, "surface", name)
        table.to_csv(path, index=False)


if __name__ == "__main__":
    with job(snakemake):
        main(
            structure=snakemake.input.structure,
            rows=snakemake.output.rows,
            choices=snakemake.output.choices,
            gathering=snakemake.output.gathering,
            dots=snakemake.params.dots,
            name=snakemake.wildcards.surface,
            surface=snakemake.params.surface,
            patches=snakemake.params.patches,
            sampling=snakemake.params.sampling,
            rows_evaluation=snakemake.params.rows_evaluation,
            grid_evaluation=snakemake.params.grid_evaluation,
            seed=snakemake.params.seed,
            threads=snakemake.threads,
        )
