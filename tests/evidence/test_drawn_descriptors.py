"""The figures of the descriptors show the numbers of their tables."""

import numpy as np
import pandas as pd
import pytest

import draw_descriptors
from conftest import ROOT
from drawn import colour_of, legend_of
from measures import descriptors_figures
from sparsurf.report.figures import layout

TABLES = ("changes", "samplers")
DESCRIPTORS = {key: pd.read_csv(ROOT / "evidence" / "tables" / f"descriptors_{key}.csv") for key in TABLES}


def test_steadiness_shows_means_with_their_ends():
    rows = [
        (name, change, k + d)
        for d, name in enumerate(draw_descriptors.COLOURS)
        for k, change in enumerate("ab")
    ]
    changes = pd.DataFrame(rows, columns=["descriptor", "change", "ratio"])
    changes = changes.assign(ratio_low=changes["ratio"] - 0.1, ratio_high=changes["ratio"] + 0.2)
    orders = pd.DataFrame([(name, n, (n + 1) / 30) for name in draw_descriptors.COLOURS for n in range(21)])
    orders.columns = ["descriptor", "n", "ratio"]
    orders = orders.assign(lowest=orders["ratio"] / 2, highest=2 * orders["ratio"])
    left, right = draw_descriptors.steadiness(changes, orders).axes
    bars = [patch.get_height() for patch in left.patches]
    assert bars == changes["ratio"].tolist()
    ends = [path.vertices[:, 1] for bar in left.collections for path in bar.get_paths()]
    wanted = changes[["ratio_low", "ratio_high"]].to_numpy()
    assert np.array(ends) == pytest.approx(wanted)
    assert np.array_equal(
        right.lines[1].get_ydata(), orders.loc[orders["descriptor"] == "rotation_robust", "ratio"]
    )
    assert right.get_yscale() == "log"


def test_samplers_are_drawn_in_units_of_each_surfaces_floor_and_averaged():
    figure = descriptors_figures.samplers(DESCRIPTORS["changes"], DESCRIPTORS["samplers"])
    table, changes = DESCRIPTORS["samplers"], DESCRIPTORS["changes"]
    assert table["surface"].nunique() > 1
    for ax, descriptor in zip(figure.axes, ("published", "rotation_robust"), strict=True):
        same = changes[(changes["descriptor"] == descriptor) & (changes["density"] == 5.35)]
        floor = dict(same.loc[same["change"] == "turned, fresh dots", ["surface", "Z"]].to_numpy())
        assert ax.get_title() == f"{descriptor}: floor {np.mean([*floor.values()]):.2f}"
        for k, name in enumerate(("farthest", "poisson", "uniform", "paper")):
            own = table[(table["descriptor"] == descriptor) & (table["sampler"] == name)]
            parts = [own[own["surface"] == surface] for surface in floor]
            percents = np.mean([part["n_S_percent"] for part in parts], axis=0)
            ratios = np.mean([part["Z"] / floor[part["surface"].iloc[0]] for part in parts], axis=0)
            np.testing.assert_allclose(ax.lines[k].get_xdata(), percents)
            np.testing.assert_allclose(ax.lines[k].get_ydata(), ratios)
            assert colour_of(ax.lines[k]) == layout.PALETTE[k]
        assert ax.lines[4].get_ydata()[0] == 1 and (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    names = ["farthest point", "Poisson disk", "uniform subset", "paper's sampling"]
    assert legend_of(figure) == list(zip(names, layout.PALETTE, strict=False))
