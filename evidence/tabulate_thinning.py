"""Maps from few centres over some complexes, and their figure."""

from measures.tables import cpu_table, read_tables, write_tables
from sparsurf.report.figures.pair_figures import thinning_figure
from sparsurf.workflow.jobs import job

MEASURES = ["n_S_percent", "correlation", "auc", "seconds"]


def main(
    tables: list[str],
    complexes_thinning: str,
    complexes_thinning_means: str,
    thinning_cpu: str,
    figure: str,
    logs: str,
) -> None:
    """Write the table, means over the complexes and the figure."""
    rows = read_tables(tables)
    means = rows.groupby(["sampler", "surface", "percent"], sort=False)[MEASURES].mean().reset_index()
    seconds_of_all = means.loc[means["sampler"] == "all", "seconds"].iloc[0]
    write_tables(
        {
            complexes_thinning: rows,
            complexes_thinning_means: means.assign(times_less=seconds_of_all / means["seconds"]),
            thinning_cpu: cpu_table(logs),
        },
        "%.4g",
    )
    drawn = thinning_figure(rows, f"mean of {', '.join(rows['complex'].unique())}")
    drawn.savefig(figure, dpi=150, metadata={"Software": None})


if __name__ == "__main__":
    with job(snakemake):
        main(
            tables=snakemake.input.tables,
            complexes_thinning=snakemake.output.complexes_thinning,
            complexes_thinning_means=snakemake.output.complexes_thinning_means,
            thinning_cpu=snakemake.output.thinning_cpu,
            figure=snakemake.output.figure,
            logs=snakemake.params.logs,
        )
