"""The figure of the exponent: Z relative to that of evenly distributed dots, against k."""

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
    figure = layout.sheet(layout.PAGE, 112)
    for row, sampler in enumerate(SAMPLERS):
        for column, reading in enumerate(READINGS):
            ax = layout.axes(figure, 18 + 84 * column, 9 + 50 * row, 68, 36)
            rows = table[(table["sampler"] == sampler) & (table["reading"] == reading)]
            for k, (percent, line) in enumerate(rows.groupby("percent")):
                error = [line["ratio"] - line["ratio_low"], line["ratio_high"] - line["ratio"]]
                style = {
                    "color": PALETTE[k],
                    "marker": "o",
                    "capsize": 2,
                    "label": f"{percent:g} % of the dots",
                }
                ax.errorbar(line["k"], line["ratio"], error, **style)
            ax.axhline(1, color="black", linewidth=0.5)
            ax.set(ylabel="Z over that at k = 0" if not column else "", title=f"{sampler}, {WORDS[reading]}")
            if row:
                ax.set(xlabel="k: density goes with $(1 - R)^k$")
            if not row and not column:
                ax.legend()
            layout.letter(figure, 4 + 84 * column, 3 + 50 * row, "ABCD"[2 * row + column])
    return figure


def main(means: str, figure: str) -> None:
    """Draw the figure from the stored means."""
    exponents(pd.read_csv(means)).savefig(figure, dpi=200, metadata={"Software": None})


if __name__ == "__main__":
    with job(snakemake):
        main(means=snakemake.input.means, figure=snakemake.output.figure)
