"""Figure 4 of the paper with patches around any dots, not around kept ones only."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sparsurf.report.figures import layout
from sparsurf.report.figures.rough_and_flat import KEPT, figure, message

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sparsurf.report.figures.results import Results


def draw(results: Results) -> Figure:
    """Draw Z by roughness around any dots."""
    panels = [panel for panel in results.rough_and_flat["panels"] if KEPT not in panel[0]]
    name = layout.headed(results.name, message(panels))
    return figure(panels, [], results.rough_and_flat["references"], name=name)
