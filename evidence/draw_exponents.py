"""The figure of the exponent: Z against k, over that of evenly spread dots."""

import pandas as pd

from measures.exponents import READINGS, SAMPLERS
from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import PALETTE, styled
from sparsurf.workflow.jobs import run

WORDS = {"as_written": "the dots as they are", "recovered": "the surface recovered from them"}


@styled
def exponents(table):
    """A column for each way to use the dots, a row for each sampler, a line for each n_S."""
    figure = layout.sheet(layout.PAGE, 112)
    for row, sampler in enumerate(SAMPLERS):
        for column, reading in enumerate(READINGS):
            ax = layout.axes(figure, 18 + 84 * column, 9 + 50 * row, 68, 36)
            own = table[(table["sampler"] == sampler) & (table["reading"] == reading)]
            for k, (percent, line) in enumerate(own.groupby("percent")):
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


def main(inputs, outputs):
    """Draw it."""
    figure = exponents(pd.read_csv(inputs["exponents_means"]))
    figure.savefig(outputs["exponents"], dpi=200, metadata={"Software": None})


if __name__ == "__main__":
    run(main, snakemake)
