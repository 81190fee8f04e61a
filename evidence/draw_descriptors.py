"""Figures of the descriptors: how far position and dots move each, and samplers under each."""

import pandas as pd

from measures import descriptors_figures
from sparsurf.report.figures.layout import PAGE, PALETTE, axes, legend, letter, sheet, styled
from sparsurf.workflow.jobs import run

COLOURS = {"published": PALETTE[1], "steady": PALETTE[0]}


@styled
def steadiness(changes, orders):
    """Change against the difference of two patches, by what changes (a) and by order (b): means and 95 % over structures."""
    figure = sheet(PAGE, 70)
    left, right = axes(figure, 14, 8, 66, 46), axes(figure, 103, 8, 76, 46)
    kinds = list(changes["change"].unique())
    for d, (name, colour) in enumerate(COLOURS.items()):
        own = changes[changes["descriptor"] == name].set_index("change").loc[kinds]
        error = [own["ratio"] - own["ratio_low"], own["ratio_high"] - own["ratio"]]
        place = [k + 0.36 * (d - 0.5) for k in range(len(kinds))]
        left.bar(place, own["ratio"], 0.32, yerr=error, color=colour, capsize=2, label=name)
        own = orders[orders["descriptor"] == name]
        right.semilogy(own["n"], own["ratio"], color=colour, marker="o")
        right.fill_between(own["n"], own["lowest"], own["highest"], color=colour, alpha=0.2, linewidth=0)
    left.set_xticks(range(len(kinds)), [kind.replace(", ", ",\n") for kind in kinds])
    left.set_ylabel("change / difference of two patches")
    right.set(xlabel="order n", ylabel="variance by position and dots /\nvariance between patches")
    right.set_xticks(range(0, 21, 5))
    letter(figure, 2, 2, "a")
    letter(figure, 88, 2, "b")
    legend(figure, 14, 65, left.get_legend_handles_labels()[0], ncols=2)
    return figure


def main(inputs, outputs):
    """Draw both from the stored tables."""
    stored = {name.removeprefix("descriptors_"): pd.read_csv(path) for name, path in inputs.items()}
    lowest = stored["changes"]["density"].min()
    means = (stored[f"{key}_means"] for key in ("changes", "orders"))
    figures = {"steadiness": steadiness(*(table[table["density"] == lowest] for table in means))}
    figures["samplers"] = descriptors_figures.samplers(stored)
    for name, figure in figures.items():
        figure.savefig(outputs[f"descriptors_{name}"], dpi=200, metadata={"Software": None})


if __name__ == "__main__":
    run(main, snakemake)
