"""How often intervals contain the truth, over several surfaces: all rows, and means over the ranges of n_S."""

from measures.coverage import of_means
from measures.tables import read_tables, write_tables
from sparsurf.streams import stream
from sparsurf_study.workflow.jobs import job

NUMBERS = ["fixed_t", "fixed_normal", "winner", "cv", "cv_winner", "best_in_set"]
NUMBERS += ["selected_bias", "cv_bias", "half_width", "set_size"]
DESIGN = ["reading", "draws", "test_dots"]

with job(snakemake):
    rows = read_tables(snakemake.input.tables).round(4)
    params = snakemake.params
    means = of_means(params.numbers, params.replicates, stream(params.seed, "coverage of means"))
    by_surface = rows.groupby(["surface", *DESIGN], sort=False)
    write_tables(
        {
            snakemake.output.coverage: rows,
            snakemake.output.coverage_surfaces: by_surface[NUMBERS].mean().reset_index(),
            snakemake.output.coverage_designs: rows.groupby(DESIGN, sort=False)[NUMBERS].mean().reset_index(),
            snakemake.output.coverage_means: means,
        }
    )
