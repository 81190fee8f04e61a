"""The figure of the centres: d of the best combination of each range, and of the centres filled up uniformly."""

import pandas as pd
from matplotlib.figure import Figure

from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import PALETTE, styled
from sparsurf.workflow.jobs import job

LINES = {"d": "the best combination", "d_centres": "centres of patches, filled up uniformly"}
TICKS = (2, 5, 10, 20, 50, 100)  # % of the dots
TITLES = {"as_coded": "as coded", "as_written": "as written", "recovered": "recovered"}


@styled
def centres(table: pd.DataFrame) -> Figure:
    """Draw a panel for each reading: means over proteins with 95 % intervals against n_S."""
    figure = layout.constrained(layout.PAGE, 76)
    panels = figure.subplots(1, len(TITLES))
    for ax, letter, (reading, title) in zip(panels, "ABC", TITLES.items(), strict=True):
        rows = table[table["reading"] == reading]
        for colour, (key, label) in zip(PALETTE, LINES.items(), strict=False):
            error = [rows[key] - rows[f"{key}_low"], rows[f"{key}_high"] - rows[key]]
            ax.errorbar(
                rows["n_S_percent"], rows[key], error, color=colour, marker="o", capsize=2, label=label
            )
        ax.axhline(0, color="black", linewidth=0.5)
        ax.set(xlabel="dots kept / %", xscale="log")
        ax.set_xticks(TICKS, [f"{tick:g}" for tick in TICKS], minor=False)
        ax.minorticks_off()
        layout.panel_title(ax, letter, title)
    panels[0].set_ylabel("d")
    handles = panels[0].get_legend_handles_labels()[0]
    figure.legend(handles=handles, loc="outside lower left", ncols=2)
    return figure


def main(means: str, figure: str) -> None:
    """Draw the figure from the stored means."""
    centres(pd.read_csv(means)).savefig(figure, dpi=200, metadata={"Software": None})


if __name__ == "__main__":
    with job(snakemake):
        main(means=snakemake.input.means, figure=snakemake.output.figure)
