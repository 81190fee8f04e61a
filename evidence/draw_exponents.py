"""The figure of the exponent: Z relative to that of evenly distributed dots, against k."""

from itertools import product

import pandas as pd
from matplotlib.figure import Figure

from measures.exponents import READINGS, SAMPLERS
from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import PALETTE, styled
from sparsurf.workflow.jobs import job

WORDS = {"as_written": "the dots as they are", "recovered": "the surface recovered from them"}


@styled
def exponents(table: pd.DataFrame) -> Figure:
    """Draw a column for each way to use the dots, a row for each sampler, a line for each n_S."""
    gain = 100 * (1 - table["ratio"].min())
    figure = layout.constrained(layout.PAGE, 112, f"no exponent lowers Z by more than {gain:.0f} %")
    panels = figure.subplots(2, 2, sharex=True)
    places = product(SAMPLERS, READINGS)
    for ax, letter, (sampler, reading) in zip(panels.flat, "ABCD", places, strict=True):
        rows = table[(table["sampler"] == sampler) & (table["reading"] == reading)]
        for colour, (percent, line) in zip(PALETTE, rows.groupby("percent"), strict=False):
            error = [line["ratio"] - line["ratio_low"], line["ratio_high"] - line["ratio"]]
            label = f"{percent:g} % of the dots"
            ax.errorbar(line["k"], line["ratio"], error, color=colour, marker="o", capsize=2, label=label)
        ax.axhline(1, color="black", linewidth=0.5)
        layout.panel_title(ax, letter, f"{sampler}, {WORDS[reading]}")
    figure.supxlabel("k: density goes with $(1 - R)^k$", fontsize=7)
    figure.supylabel("Z over that at k = 0", fontsize=7)
    panels[0, 0].legend()
    return figure


def main(means: str, figure: str) -> None:
    """Draw the figure from the stored means."""
    exponents(pd.read_csv(means)).savefig(figure, dpi=200, metadata={"Software": None})


if __name__ == "__main__":
    with job(snakemake):
        main(means=snakemake.input.means, figure=snakemake.output.figure)
