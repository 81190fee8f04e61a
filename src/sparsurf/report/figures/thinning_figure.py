"""What maps from few centres are worth: correlation and AUC against n_S and against cost."""

from string import ascii_uppercase

from matplotlib.ticker import FuncFormatter, NullFormatter

from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import LINES, SPARE, styled
from sparsurf.sampling.samplers import called

PANELS = [("correlation", "correlation with the map\nof all dots"), ("auc", "AUC of the smoothed map")]
AGAINST = [("n_S_percent", "centres (% of the dots)"), ("seconds", "CPU seconds for both sides")]
ABSENT = "none: the partners do not touch\n(or touch everywhere)"  # dots inside and outside of the interface
RECOVERED = (0, (3, 1.5))  # dashes of maps whose patches are cut from the surface recovered from the centres


@styled
def thinning_figure(table, subject):
    """Correlation and AUC (mean of both sides and all draws) against n_S and against cost.

    Parameters
    ----------
    table : DataFrame of `thinning.thinning`, or of many
    subject : str

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = layout.sheet(layout.PAGE, 124)
    layout.text(
        figure, 16, 1, f"{subject}; both partners averaged. Dotted line and star: all dots as centres."
    )
    mean = table.groupby(["sampler", "surface", "percent"], sort=False).mean(numeric_only=True).reset_index()
    whole, thin = mean[mean["sampler"] == "all"].iloc[0], mean[mean["sampler"] != "all"]
    handles = {}
    for row, (value, label) in enumerate(PANELS):
        for column, (against, axis) in enumerate(AGAINST):
            layout.letter(figure, 3 + 88 * column, 6 + 50 * row, ascii_uppercase[2 * row + column])
            ax = layout.axes(figure, 16 + 88 * column, 8 + 50 * row, 72, 40)
            for place, ((sampler, surface), rows) in enumerate(
                thin.groupby(["sampler", "surface"], sort=False)
            ):
                colour, width, marker = LINES.get(sampler, (SPARE[place % len(SPARE)], 0.8, "*"))
                dashes = RECOVERED if surface == "recovered" else "-"
                name = called(sampler).words + (", recovered" if surface == "recovered" else "")
                style = {"color": colour, "linewidth": width, "marker": marker, "linestyle": dashes}
                rows = rows.sort_values(against)
                handles[name] = ax.plot(rows[against], rows[value], label=name, **style)[0]
            ax.set(xlabel=axis, ylabel=label if column == 0 else "")
            if mean[value].isna().all():
                ax.set(xticks=[], yticks=[])
                ax.text(0.5, 0.5, ABSENT, transform=ax.transAxes, ha="center", va="center")
                continue
            ax.set_xscale("log")
            if against == "seconds":
                ax.plot(whole["seconds"], whole[value], "k*", markersize=6)
                ax.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
                ax.xaxis.set_minor_formatter(NullFormatter())
            else:
                shown = sorted(thin["percent"].unique())
                ax.set_xticks(shown, [f"{x:g}" for x in shown])
                ax.minorticks_off()
                ax.axhline(whole[value], color="black", linewidth=0.5, linestyle=":")
    rows = 1 + (thin["surface"] == "recovered").any()  # a column for each sampler, as it is and recovered
    layout.legend(figure, 4, 112, list(handles.values()), ncols=min(4, -(-len(handles) // rows)))
    return figure
