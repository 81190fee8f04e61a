"""The figure of finding sites: hit rate against dots kept."""

import pandas as pd
from matplotlib.figure import Figure

from measures.sites import CHANNELS, COMPOSITION, PUBLISHED
from sparsurf.report.figures import layout
from sparsurf.workflow.jobs import job

COLOURS = dict(zip(CHANNELS, ("#56B4E9", "#0072B2", "#D55E00"), strict=True))
LINES = {name: (colour, 1.6, "o", "-") for name, colour in COLOURS.items()}  # colour, width, marker, dashes
LINES |= {COMPOSITION: (layout.GREY, 0.8, "s", "--"), PUBLISHED: (layout.GREY, 0.8, "^", ":")}
PANELS = {"interface": "places of the interface", "elsewhere": "other places"}


@layout.styled
def draw(means: pd.DataFrame) -> Figure:
    """Draw two panels: places of the interface and other places."""
    figure = layout.sheet(layout.PAGE, 76)
    percents, handles = sorted(means["percent"].unique()), {}
    for column, (places, words) in enumerate(PANELS.items()):
        ax = layout.axes(figure, 16 + 88 * column, 6, 72, 48)
        rows_of_panel = means[means["places"] == places].sort_values("percent")
        for name, (colour, width, marker, dashes) in LINES.items():
            rows = rows_of_panel[rows_of_panel["channels"] == name]
            style = {"color": colour, "linewidth": width, "marker": marker, "linestyle": dashes}
            handles[name] = ax.plot(rows["percent"], rows["first"], label=name, **style)[0]
            ax.fill_between(
                rows["percent"], rows["first_low"], rows["first_high"], color=colour, alpha=0.1, linewidth=0
            )
        chance = rows_of_panel.groupby("percent")["chance"].mean()
        handles["chance"] = ax.plot(
            chance.index, chance, color="black", linewidth=0.5, linestyle=":", label="chance"
        )[0]
        ax.set(xscale="log", ylim=(0, 1), xlabel="dots kept on both forms (%)", title=words)
        ax.set_ylabel("first hit right (share)" if column == 0 else "")
        ax.set_xticks(percents, [f"{x:g}" for x in percents])
        ax.minorticks_off()
    layout.legend(figure, 4, 66, list(handles.values()), ncols=3)
    return figure


def main(means_path: str, figure: str) -> None:
    """Draw the share of places whose first hit is right."""
    means = pd.read_csv(means_path)
    draw(means[means["scope"] == "in turn"]).savefig(figure, dpi=150, metadata={"Software": None})


if __name__ == "__main__":
    with job(snakemake):
        main(means_path=snakemake.input.means, figure=snakemake.output.figure)
