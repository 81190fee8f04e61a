"""Figures of the descriptors: how far position and dots change each, and samplers with each."""

import pandas as pd
from matplotlib.figure import Figure

from measures import descriptors_figures
from sparsurf.report.figures.layout import PAGE, PALETTE, axes, legend, letter, sheet, styled
from sparsurf.workflow.jobs import job

COLOURS = {"published": PALETTE[1], "rotation_robust": PALETTE[0]}


@styled
def steadiness(changes: pd.DataFrame, orders: pd.DataFrame) -> Figure:
    """Draw the change relative to the difference of two patches, by kind of change (a) and by order (b).

    Means over the structures, with 95 % intervals in (a) and ranges in (b).
    """
    figure = sheet(PAGE, 70)
    left, right = axes(figure, 14, 8, 66, 46), axes(figure, 103, 8, 76, 46)
    kinds = list(changes["change"].unique())
    for d, (name, colour) in enumerate(COLOURS.items()):
        rows = changes[changes["descriptor"] == name].set_index("change").loc[kinds]
        error = [rows["ratio"] - rows["ratio_low"], rows["ratio_high"] - rows["ratio"]]
        x = [k + 0.36 * (d - 0.5) for k in range(len(kinds))]
        left.bar(x, rows["ratio"], 0.32, yerr=error, color=colour, capsize=2, label=name)
        rows = orders[orders["descriptor"] == name]
        right.semilogy(rows["n"], rows["ratio"], color=colour, marker="o")
        right.fill_between(rows["n"], rows["lowest"], rows["highest"], color=colour, alpha=0.2, linewidth=0)
    left.set_xticks(range(len(kinds)), [kind.replace(", ", ",\n") for kind in kinds])
    left.set_ylabel("change / difference of two patches")
    right.set(xlabel="order n", ylabel="variance by position and dots /\nvariance between patches")
    right.set_xticks(range(0, 21, 5))
    letter(figure, 2, 2, "a")
    letter(figure, 88, 2, "b")
    legend(figure, 14, 65, left.get_legend_handles_labels()[0], ncols=2)
    return figure


def main(
    changes_path: str,
    changes_means: str,
    orders_means: str,
    samplers_path: str,
    steadiness_figure: str,
    samplers_figure: str,
) -> None:
    """Draw both figures from the stored tables; the first at the lowest density."""
    changes = pd.read_csv(changes_path)
    lowest = changes["density"].min()
    at_lowest = [
        table[table["density"] == lowest] for table in map(pd.read_csv, (changes_means, orders_means))
    ]
    steadiness(*at_lowest).savefig(steadiness_figure, dpi=200, metadata={"Software": None})
    samplers = descriptors_figures.samplers(changes, pd.read_csv(samplers_path))
    samplers.savefig(samplers_figure, dpi=200, metadata={"Software": None})


if __name__ == "__main__":
    with job(snakemake):
        main(
            changes_path=snakemake.input.changes,
            changes_means=snakemake.input.changes_means,
            orders_means=snakemake.input.orders_means,
            samplers_path=snakemake.input.samplers,
            steadiness_figure=snakemake.output.steadiness,
            samplers_figure=snakemake.output.samplers,
        )
