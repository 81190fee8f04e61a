"""Figure of a simulation: did it do what it was asked, and how far did the protein move."""

from string import ascii_uppercase

import numpy as np
from matplotlib.ticker import MaxNLocator

from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import PAGE, PALETTE, styled

ENERGIES = {
    "temperature_K": "temperature (K)",
    "pressure_bar": "pressure (bar)",
    "density_kg_m3": "density (kg m$^{-3}$)",
    "potential_kJ_mol": "potential energy (MJ mol$^{-1}$)",
}
MOTION = {"rmsd": "Cα RMSD to the first frame (Å)", "radius_of_gyration": "radius of gyration (Å)"}
STAGES = {"nvt": "NVT, protein held", "npt": "NPT, protein held", "production": "production"}
WINDOW = 20  # moving means are taken over one value in so many


@styled
def simulation_figure(energies, motion, judged):
    """Temperature, pressure, density and energy of the stages one after the other, RMSD and radius of gyration.

    Parameters
    ----------
    energies, motion, judged : DataFrame, see `simulation.quality`

    Returns
    -------
    matplotlib.figure.Figure
    """
    target = judged.set_index("quantity")["target"]
    figure = layout.sheet(PAGE, 110)
    scale, unit = _unit(energies.loc[energies["stage"] != "minimise", "time_ps"].max())
    for k, (column, label) in enumerate(ENERGIES.items()):
        ax = _panel(figure, k, label)
        begin = 0.0
        for colour, (stage, _) in zip(PALETTE, STAGES.items(), strict=False):
            rows = energies[energies["stage"] == stage]
            values = rows[column] / (1000 if column.startswith("potential") else 1)
            time = (begin + rows["time_ps"].to_numpy()) / scale
            begin += rows["time_ps"].max()
            _series(ax, time, values, colour)
        if column in target:
            ax.axhline(target[column], color="black", linewidth=0.6, linestyle=(0, (4, 2)))
        ax.set_xlabel(f"time ({unit})")
    scale, unit = _unit(motion["time_ps"].max())
    for k, (column, label) in enumerate(MOTION.items(), start=len(ENERGIES)):
        ax = _panel(figure, k, label)
        _series(ax, motion["time_ps"].to_numpy() / scale, motion[column], PALETTE[2])
        ax.set_xlabel(f"time of the production ({unit})")
    for x, colour, words in zip((15, 62, 109), PALETTE, STAGES.values(), strict=False):
        layout.text(figure, x, 1.5, words, color=colour, fontweight="bold")
    layout.text(figure, 137, 1.5, "dashed: target")
    return figure


def _unit(longest):
    return (1000.0, "ns") if longest >= 10_000 else (1.0, "ps")


def _panel(figure, k, label):
    x, y = 15 + 60 * (k % 3), 14 + 53 * (k // 3)
    layout.letter(figure, x - 13, y - 5, ascii_uppercase[k])
    ax = layout.axes(figure, x, y, 44, 36)
    ax.set_title(label, loc="left")
    ax.xaxis.set_major_locator(MaxNLocator(4))
    ax.yaxis.set_major_locator(MaxNLocator(4))
    return ax


def _series(ax, time, values, colour):
    """All values pale, their moving mean dark."""
    many = len(values) >= 3 * WINDOW
    ax.plot(time, values, color=colour, linewidth=0.4, alpha=0.45 if many else 1.0)
    if many:
        window = max(3, len(values) // WINDOW)
        smooth = values.rolling(window, center=True, min_periods=window // 2 + 1).mean()
        ax.plot(time, np.asarray(smooth), color=colour, linewidth=1.0)
