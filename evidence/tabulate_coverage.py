"""How often intervals contain the truth, over several surfaces."""

from measures.tables import cpu_table, read_tables, write_tables
from sparsurf.workflow.jobs import job

SHARES = ["fixed_t", "fixed_normal", "winner", "cv", "cv_winner", "best_in_set"]
OTHER_NUMBERS = ["selected_bias", "cv_bias", "half_width", "set_size"]
DESIGN = ["reading", "draws", "test_dots"]


def main(
    tables: list[str],
    coverage: str,
    coverage_surfaces: str,
    coverage_designs: str,
    coverage_cpu: str,
    logs: str,
) -> None:
    """Write all rows, and means over the ranges of n_S by surface and by design."""
    rows = read_tables(tables).round(4)
    numbers = [*SHARES, *OTHER_NUMBERS]
    write_tables(
        {
            coverage: rows,
            coverage_surfaces: rows.groupby(["surface", *DESIGN], sort=False)[numbers].mean().reset_index(),
            coverage_designs: rows.groupby(DESIGN, sort=False)[numbers].mean().reset_index(),
            coverage_cpu: cpu_table(logs),
        }
    )


if __name__ == "__main__":
    with job(snakemake):
        main(
            tables=snakemake.input.tables,
            coverage=snakemake.output.coverage,
            coverage_surfaces=snakemake.output.coverage_surfaces,
            coverage_designs=snakemake.output.coverage_designs,
            coverage_cpu=snakemake.output.coverage_cpu,
            logs=snakemake.params.logs,
        )
