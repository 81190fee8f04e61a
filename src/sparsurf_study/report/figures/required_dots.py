"""How many dots are enough: the error of the surface that each model reconstructs, by dots per Å^2, and the minimal subsets."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.ticker import FixedLocator, NullLocator

from sparsurf.arguments import INTERPOLANT, SPHERES
from sparsurf.recovery.law import MEASURED, MEASURED_FROM, MEASURED_TO, error_at
from sparsurf.registry import FARTHEST
from sparsurf.views import layout
from sparsurf.views.layout import styled
from sparsurf.views.numbers import number
from sparsurf_study.analysis.tables import read_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sparsurf_study.report.figures.results import Results

WORDS = {INTERPOLANT: "interpolant", SPHERES: "spheres"}  # the models of `recover`
COLOURS = {INTERPOLANT: layout.PALETTE[1], SPHERES: layout.PALETTE[0]}
DASHES: dict[bool, Any] = {False: (None, None), True: (4, 2)}  # without hydrogens, and with them
ERRORS_DRAWN = {
    "mean": "mean error",
    "high_99": "error of 99 % of the surface",
}  # the columns of recovered.csv
SPAN = 0.1, 3.0  # dots per Å^2 at least shown
DENSITIES = [0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5]  # ticks, dots per Å^2
DISTANCES = [digit * 10.0**k for k in range(-5, 1) for digit in (1, 2, 5)]  # ticks, Å
MARKERS: dict[str, Any] = {
    "linestyle": "none",
    "zorder": 3,
    "markeredgecolor": "black",
    "markeredgewidth": 0.5,
}


def read(folder: Path) -> dict[Any, Any]:
    """Read the share, density, model and errors of the minimal subset of a surface from its folder."""
    return read_table(folder / "recovered.csv").iloc[0].to_dict()


def draw(results: Results) -> Figure:
    """Draw the figure of one surface."""
    return figure([results.recovered_errors.iloc[0].to_dict()], results.name)


@styled
def figure(surfaces: list[dict[Any, Any]], name: str = "") -> Figure:
    """Draw both errors of the minimal subset of each surface, and those of evenly spread dots; `name` is the head.

    Each is drawn in the colour of the model that reconstructs the surface, so that a subset is compared at the same model.
    """
    table = pd.DataFrame(surfaces)
    middle = table.median(numeric_only=True)
    prefix, error = (f"median of {len(table)}: ", "error") if len(table) > 1 else ("", "mean error")
    message = f"{prefix}{number(middle['n_S_percent'], 1)} % of the dots, {error} {middle['mean']:.3f} Å"
    drawing = layout.constrained(layout.PAGE_WIDTH, 86, layout.headed(name, message))
    low, high = min(SPAN[0], 0.8 * table["density"].min()), max(SPAN[1], 1.25 * table["density"].max())
    density = np.geomspace(max(low, MEASURED_FROM), min(high, MEASURED_TO), 50).clip(
        MEASURED_FROM, MEASURED_TO
    )
    panels = drawing.subplots(1, len(ERRORS_DRAWN), sharey=True)
    for k, (ax, (column, title)) in enumerate(zip(panels, ERRORS_DRAWN.items(), strict=True)):
        layout.panel_title(ax, "AB"[k], title)
        for sampler, model, hydrogens in MEASURED:
            if sampler == FARTHEST:
                errors = [error_at(float(x), hydrogens=hydrogens, reconstruction=model)[k] for x in density]
                label = f"evenly spread dots, {WORDS[model]}{', with hydrogens' if hydrogens else ''}"
                ax.plot(density, errors, color=COLOURS[model], dashes=DASHES[hydrogens], label=label)
        for model in table["reconstruction"].unique():
            rows, label = table[table["reconstruction"] == model], f"minimal subset, {WORDS[model]}"
            ax.plot(rows["density"], rows[column], "o", color=COLOURS[model], label=label, **MARKERS)
        ax.set(xscale="log", yscale="log", xlabel="dots kept per Å²")
        for axis, ticks in ((ax.xaxis, DENSITIES), (ax.yaxis, DISTANCES)):
            axis.set_major_locator(FixedLocator(ticks))
            axis.set_minor_locator(NullLocator())
            axis.set_major_formatter("{x:g}")
    panels[0].set_ylabel("distance from the reconstructed surface (Å)")
    handles = panels[0].get_legend_handles_labels()[0]
    drawing.legend(handles=handles, loc="outside lower left", ncols=2, handlelength=2.2)
    return layout.fix_layout(drawing)
