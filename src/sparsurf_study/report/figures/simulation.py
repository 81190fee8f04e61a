"""Figure of a simulation: did it reach its targets, and how far did the protein move."""

from __future__ import annotations

from string import ascii_uppercase
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from sparsurf.views import layout
from sparsurf.views.layout import PAGE_WIDTH, PALETTE, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ENERGIES = {
    "temperature_K": "temperature (K)",
    "pressure_bar": "pressure (bar)",
    "density_kg_m3": "density (kg m$^{-3}$)",
    "potential_kJ_mol": "potential energy (MJ mol$^{-1}$)",
}
MOTION = {"rmsd": "Cα RMSD to the first frame (Å)", "radius_of_gyration": "radius of gyration (Å)"}
STAGE_LABELS = {"nvt": "NVT, protein held", "npt": "NPT, protein held", "production": "production"}
TARGET: dict[str, Any] = {"color": "black", "linewidth": 0.6, "linestyle": (0, (4, 2))}
WINDOWS_OF_SERIES = 20  # per series; the moving mean is over one


@styled
def simulation_figure(energies: pd.DataFrame, motion: pd.DataFrame, judged: pd.DataFrame) -> Figure:
    """Draw temperature, pressure, density and energy of the stages in sequence, RMSD and radius of gyration."""
    energies, motion = (table.sort_values("time_ps", kind="stable") for table in (energies, motion))
    target = judged.set_index("quantity")["target"]
    figure = layout.constrained(PAGE_WIDTH, 110)
    panels = figure.subplots(2, 3).ravel()
    for ax, letter, title in zip(panels, ascii_uppercase, (ENERGIES | MOTION).values(), strict=False):
        layout.panel_title(ax, letter, title)
        ax.xaxis.set_major_locator(MaxNLocator(4))
        ax.yaxis.set_major_locator(MaxNLocator(4))
    scale, unit = _unit(energies.loc[energies["stage"] != "minimise", "time_ps"].max())
    for ax, column in zip(panels, ENERGIES, strict=False):
        begin = 0.0
        for colour, stage in zip(PALETTE, STAGE_LABELS, strict=False):
            rows = energies[energies["stage"] == stage]
            values = rows[column] / (1000 if column.startswith("potential") else 1)
            _series(ax, (begin + rows["time_ps"].to_numpy()) / scale, values, colour)
            begin += rows["time_ps"].max()
        if column in target:
            ax.axhline(target[column], **TARGET)
        ax.set_xlabel(f"time ({unit})")
    scale, unit = _unit(motion["time_ps"].max())
    for ax, column in zip(panels[len(ENERGIES) :], MOTION, strict=True):
        _series(ax, motion["time_ps"].to_numpy() / scale, motion[column], PALETTE[2])
        ax.set_xlabel(f"time of the production ({unit})")
    colours = dict(zip(STAGE_LABELS.values(), PALETTE, strict=False))
    handles = [Line2D([], [], color=colour, label=name) for name, colour in colours.items()]
    handles.append(Line2D([], [], **TARGET, label="target"))
    figure.legend(handles=handles, loc="outside upper left", ncols=4)
    return layout.fix_layout(figure)


def _unit(longest: float) -> tuple[float, str]:
    """Return picoseconds per unit, and the unit."""
    return (1000.0, "ns") if longest >= 10_000 else (1.0, "ps")


def _series(ax: Axes, time: np.ndarray, values: pd.Series, colour: str) -> None:
    """Draw all values pale and their moving mean dark."""
    is_long = len(values) >= 3 * WINDOWS_OF_SERIES
    ax.plot(time, values, color=colour, linewidth=0.4, alpha=0.45 if is_long else 1.0)
    if is_long:
        window = max(3, len(values) // WINDOWS_OF_SERIES)
        smooth = values.rolling(window, center=True, min_periods=window // 2 + 1).mean()
        ax.plot(time, np.asarray(smooth), color=colour, linewidth=1.0)
