"""All panels of Figure 2 of the paper."""

from sparsurf.report.figures.number_of_dots import figure


def draw(results):
    """n_S of every combination."""
    return figure(results.grid, results.name)
