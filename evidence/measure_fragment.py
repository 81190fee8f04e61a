"""Table I on one surface: its combinations, the repeated choice of each range, and where the kept dots lie."""

import pandas as pd

from measures import fragments
from sparsurf.sampling.combination import PUBLISHED_ROWS
from sparsurf_study.analysis.grid import evaluate_grid
from sparsurf_study.paper.replication import gathering_by_roughness
from sparsurf_study.workflow.jobs import job, reporter

with job(snakemake):
    name, params, output = snakemake.wildcards.surface, snakemake.params, snakemake.output
    prepared = fragments.prepare(snakemake.input.structure, params, f"fragment {name}", snakemake.threads)
    of_surface, of_rows, of_grid = (
        fragments.surface_row(prepared),
        params.rows_evaluation,
        params.grid_evaluation,
    )
    ten = evaluate_grid(prepared, PUBLISHED_ROWS, of_rows["test_dots"], of_rows["draws"])
    combinations = fragments.published_grid(params.sampling)
    grid = evaluate_grid(
        prepared, combinations, of_grid["test_dots"], of_grid["draws"], progress=reporter(name)
    )
    tables: dict[str, pd.DataFrame] = {
        output.rows: fragments.rows_table(ten).assign(**of_surface),
        output.choices: fragments.choices_table(grid),
        output.gathering: gathering_by_roughness(prepared, of_rows["draws"]),
    }
    for path, table in tables.items():
        table.insert(0, "surface", name)
        table.to_csv(path, index=False)
