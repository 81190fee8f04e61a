"""The maps from few centres over some complexes, and their figure."""

from measures.tables import joined, of_logs, store
from sparsurf.report.figures.pair_figures import thinning_figure
from sparsurf.workflow.jobs import run


def main(inputs, outputs, logs):
    """Write the table, means over the complexes and the figure."""
    table = joined(inputs["tables"])
    means = table.groupby(["sampler", "surface", "percent"], sort=False)
    means = means[["n_S_percent", "correlation", "auc", "seconds"]].mean().reset_index()
    of_all = means.loc[means["sampler"] == "all", "seconds"].iloc[0]
    found = {"complexes_thinning": table, "thinning_cpu": of_logs(logs)}
    found["complexes_thinning_means"] = means.assign(times_less=of_all / means["seconds"])
    store(found, outputs, "%.4g")
    figure = thinning_figure(table, f"mean of {', '.join(table['complex'].unique())}")
    figure.savefig(outputs["complexes_thinning_figure"], dpi=150, metadata={"Software": None})


if __name__ == "__main__":
    run(main, snakemake)
