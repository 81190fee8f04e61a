"""How many dots are enough: the error of the reconstructed surface against the dots per Å^2, and the minimal subsets."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.ticker import FixedLocator, NullLocator

from sparsurf.recovery.law import MEASURED_FROM, MEASURED_TO, error_at
from sparsurf.views import layout
from sparsurf.views.layout import styled
from sparsurf.views.numbers import number
from sparsurf_study.analysis.tables import read_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sparsurf_study.report.figures.results import Results

MEAN, HIGH = "#0072B2", "#E69F00"
SPAN = 0.1, 3.0  # dots per Å^2 at least shown
DENSITIES = [0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5]  # ticks, dots per Å^2
DISTANCES = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2]  # ticks, Å
MARKERS: dict[str, Any] = {
    "linestyle": "none",
    "zorder": 3,
    "markeredgecolor": "black",
    "markeredgewidth": 0.5,
}


def read(folder: Path) -> dict[Any, Any]:
    """Read the share, density and errors of the minimal subset of a surface from its folder."""
    return read_table(folder / "recovered.csv").iloc[0].to_dict()


def draw(results: Results) -> Figure:
    """Draw the figure of one surface."""
    return figure([results.recovered_errors.iloc[0].to_dict()], results.name)


@styled
def figure(surfaces: list[dict[Any, Any]], name: str = "") -> Figure:
    """Draw the mean error and that of 99 % of the minimal subset of each surface, with the law as lines; `name` is the head."""
    table = pd.DataFrame(surfaces)
    drawing = layout.constrained(134, 84, name)
    ax = drawing.add_subplot()
    low, high = min(SPAN[0], 0.8 * table["density"].min()), max(SPAN[1], 1.25 * table["density"].max())
    density = np.geomspace(max(low, MEASURED_FROM), min(high, MEASURED_TO), 50).clip(
        MEASURED_FROM, MEASURED_TO
    )
    for hydrogens, dashes, suffix in ((False, (), ""), (True, (4, 2), ", with hydrogens")):
        errors = np.array([error_at(float(x), hydrogens=hydrogens) for x in density]).T
        for error, colour, quantity in zip(errors, (MEAN, HIGH), ("mean", "99 %"), strict=True):
            line: dict[str, Any] = {"color": colour, "linewidth": 1.0, "dashes": dashes or (None, None)}
            ax.plot(density, error, label=f"evenly spread: {quantity}{suffix}", **line)
    size = 6 if len(table) == 1 else 4
    for column, marker, colour, label in (("mean", "o", MEAN, "mean"), ("high_99", "s", HIGH, "99 %")):
        points: dict[str, Any] = {"color": colour, "markersize": size, "label": f"minimal subset: {label}"}
        ax.plot(table["density"], table[column], marker, **points, **MARKERS)
    ax.set(
        xscale="log",
        yscale="log",
        xlabel="dots kept per Å²",
        ylabel="deviation of the reconstructed surface (Å)",
    )
    for axis, ticks in ((ax.xaxis, DENSITIES), (ax.yaxis, DISTANCES)):
        axis.set_major_locator(FixedLocator(ticks))
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter("{x:g}")
    middle = table.median(numeric_only=True)
    prefix = f"median of {len(table)}: " if len(table) > 1 else ""
    ax.set_title(
        f"{prefix}{number(middle['n_S_percent'], 1)} % of the dots, {'' if prefix else 'mean '}error {middle['mean']:.3f} Å",
        color=MEAN, fontweight="bold", fontsize=8, loc="left",
    )  # fmt: skip
    drawing.legend(loc="outside lower left", ncols=3, handlelength=2.2)
    return layout.fix_layout(drawing)
