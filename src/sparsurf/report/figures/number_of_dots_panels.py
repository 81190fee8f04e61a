"""All panels of Figure 2 of the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sparsurf.report.figures.number_of_dots import figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sparsurf.report.figures.results import Results


def draw(results: Results) -> Figure:
    """Draw n_S of every combination."""
    return figure(results.grid, results.name)
