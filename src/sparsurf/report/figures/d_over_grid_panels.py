"""All panels of Figure 3 of the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sparsurf.report.figures.d_over_grid import figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sparsurf.report.figures.results import Results


def draw(results: Results) -> Figure:
    """Draw a map for every beta."""
    return figure(results.grid, results.name)
