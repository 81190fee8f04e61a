"""Tables and figure of the centres, and of dense surfaces, by hand."""

import numpy as np
import pandas as pd
import pytest

from draw_centres import TITLES, centres
from measures.recovery import dense_means
from tabulate_centres import means


def by_range(reading, number, d, d_centres, n_above=0):
    """Rows of centres.csv for some proteins."""
    same = {
        "n_S_percent": 5.0 * number,
        "d_mean": 0.0,
        "d_centres_mean": 0.0,
        "n_combinations": 4,
        "n_below": 1,
    }
    return pd.DataFrame(
        {"reading": reading, "range": number, "d": d, "d_centres": d_centres, "n_above": n_above} | same
    )


def test_ranges_are_averaged_over_the_proteins_that_have_a_winner():
    table = pd.concat([by_range("as_written", 1, [0.1, 0.2, np.nan], [0.3, 0.5, np.nan], n_above=[2, 0, 1]),
                       by_range("as_written", 2, [1.0, 1.0, 1.0], [0.0, 0.0, 0.0])])  # fmt: skip
    found = means(table).set_index("range")
    assert found["n"].to_list() == [2, 3]
    assert found.loc[1, ["d", "d_centres"]].to_list() == pytest.approx([0.15, 0.4])
    assert found.loc[1, ["n_above", "n_below"]].to_list() == [25, 25]  # % of 12 combinations


def test_the_figure_has_a_panel_for_each_reading_and_both_lines():
    rows = [
        by_range(reading, k, [0.1 * k, 0.3 * k, 0.2 * k], [0.0, 0.1, 0.2])
        for reading in TITLES
        for k in (1, 2)
    ]
    panels = centres(means(pd.concat(rows))).axes
    titles = [ax.get_title(loc="left").split("  ")[1] for ax in panels]
    assert titles == list(TITLES.values())
    best, control = (line.get_xydata() for line in panels[1].lines[::3][:2])
    assert np.allclose(best, [[5, 0.2], [10, 0.4]]) and np.allclose(control, [[5, 0.1], [10, 0.1]])


def test_dense_surfaces_are_summarised_by_kind_with_the_factor_of_one_density():
    columns = ["hydrogens", "requested_density", "density", "N", "n_S", "n_S_at_5.35"]
    rows = [
        ("keep", "auto", 5.4, 1000, 50, 50),
        ("keep", "20", 20.0, 4000, 100, 200),
        ("keep", "20", 20.0, 2000, 100, 800),
    ]
    found = dense_means(pd.DataFrame(rows, columns=columns)).set_index("requested_density").loc["20"]
    assert found[["n", "N", "n_S", "n_S_percent"]].to_list() == [2, 3000, 100, 3.75]
    assert found[["times", "fewest", "most"]].to_list() == pytest.approx([4, 2, 8])
