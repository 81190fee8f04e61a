"""Every figure looks as its stored picture; texts stay apart; three figures are followed from data to artist.

A figure that is to look otherwise: BASELINE=new pytest tests/study/report/test_figures.py, and look at the pictures in baseline/.
"""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from figure_cases import AWKWARD, PICTURES, enough, grid
from matplotlib import __version__, colormaps, rcParams
from matplotlib.image import imread

from drawn import MADE_BY, check_texts, differs, of_another_matplotlib
from sparsurf.views import layout, render
from sparsurf_study.report.figures import d_over_grid, pair_figures, rough_and_flat, roughness
from sparsurf_study.report.numbers import better_than_uniform

BASELINE = Path(__file__).with_name("baseline")


@pytest.mark.parametrize("name", PICTURES)
@pytest.mark.skipif(
    of_another_matplotlib(), reason=f"pictures are of matplotlib {MADE_BY}, not {__version__}"
)
def test_a_figure_looks_as_before(name, tmp_path):
    assert not differs(PICTURES[name](), BASELINE / f"{name}.png", tmp_path)


def test_every_stored_picture_is_of_a_figure():
    assert {path.stem for path in BASELINE.glob("*.png")} == {*PICTURES}


@pytest.mark.parametrize("name", [*PICTURES, *AWKWARD])
@pytest.mark.filterwarnings("error")
def test_texts_are_apart_and_inside(name, monkeypatch):
    check_texts((PICTURES | AWKWARD)[name](), monkeypatch)


def test_the_law_and_the_subset_are_drawn_where_they_are():
    (ax,) = enough().axes
    drawn = [line.get_xydata() for line in ax.lines]
    law, high_99, with_hydrogens, mean, high = drawn
    assert law[:, 0] * law[:, 1] == pytest.approx(np.full(len(law), 0.0125))
    assert with_hydrogens[:, 0] * with_hydrogens[:, 1] == pytest.approx(np.full(len(law), 0.015))
    assert high_99[:, 1] / law[:, 1] == pytest.approx(np.full(len(law), 5.2))
    assert (mean.tolist(), high.tolist()) == ([[0.7, 0.02]], [[0.7, 0.1]])
    assert ax.get_title() == "13 % of the dots, mean error 0.020 Å"


def test_a_cell_of_the_map_has_the_colour_of_its_d():
    """At the largest alpha; gamma and delta have other steps and other values."""
    table = grid(gamma=[0, 2, 10], delta=[0, 5, 10])
    rows = [ax for ax in d_over_grid.figure(table).axes if ax.images]
    for ax, reading in zip(rows, ("kept", "full"), strict=True):
        for image, beta in zip(ax.images, (0, 0.4, 1), strict=True):
            for cell in table[(table.alpha == 1) & (table.beta == beta)].itertuples():
                shown = image.get_array()[round(cell.gamma * 10), round(cell.delta * 10)]
                assert shown == pytest.approx(getattr(cell, f"d_{reading}"))
    largest = table[table.alpha == 1][["d_kept", "d_full"]].abs().to_numpy().max()
    for image in (rows[0].images[0], rows[1].images[0]):  # red above 0 for both readings, on one scale
        assert (image.cmap.name, image.norm.vmin, image.norm.vmax) == ("RdBu_r", -largest, largest)


def test_the_combination_that_keeps_the_most_dots_is_better_only_if_it_is_alone():
    table = pd.DataFrame({"n_S_percent": [10.0, 99.9, 40.0], "d_kept": [0.5, 0.5, -0.5]})
    assert better_than_uniform(table, "kept") == (1, 2)  # as in the ranges
    assert better_than_uniform(table[1:2], "kept") == (1, 1)


def test_the_histogram_counts_the_roughness_in_the_colours_of_the_surface():
    points = np.random.default_rng(0).normal(size=(300, 3))
    rough = np.random.default_rng(1).beta(5, 2, 300)
    _, bar, histogram = roughness.figure(points, points, rough).axes
    counts, edges = np.histogram(rough, 50)
    assert [patch.get_height() for patch in histogram.patches] == counts.tolist()
    assert histogram.lines[0].get_xdata()[0] == pytest.approx(rough.mean())
    low, high = render.ROUGHNESS_LIMITS
    wanted = colormaps["viridis"](np.clip(((edges[:-1] + edges[1:]) / 2 - low) / (high - low), 0, 1))
    np.testing.assert_allclose([patch.get_facecolor() for patch in histogram.patches], wanted)
    assert bar.get_ylim() == pytest.approx((low, high))  # whatever the surface


@pytest.mark.parametrize("name", ["d_over_grid"])
def test_files_repeat_byte_by_byte(name, tmp_path):
    figure, before = PICTURES[name](), dict(rcParams)
    for folder, drawing in (("a", figure), ("b", figure), ("c", PICTURES[name]())):
        (tmp_path / folder).mkdir()
        for suffix in ("svg", "png"):
            layout.save(drawing, tmp_path / folder / f"v1.2_figure.{suffix}")
    for suffix in ("svg", "png"):
        first, *others = [(tmp_path / f / f"v1.2_figure.{suffix}").read_bytes() for f in "abc"]
        assert all(other == first for other in others) and b"dc:date" not in first and b"tIME" not in first
    text = (tmp_path / "a" / "v1.2_figure.svg").read_text()
    assert ElementTree.fromstring(text).tag.endswith("svg") and "<text" in text
    assert abs(imread(tmp_path / "a" / "v1.2_figure.png").shape[1] - figure.get_figwidth() * layout.DPI) < 1
    assert dict(rcParams) == before


def test_titles_follow_from_the_numbers():
    for places, words in (
        (("above", "above"), "matching patches lie at the interface"),
        (("around", "above"), "matching patches lie at the interface of partner 2 only"),
        (("below", "below"), "matching patches lie away from the interface"),
        (
            ("below", "around"),
            "matching patches do not mark the interface, and lie away from it on partner 1",
        ),
        ((), ""),
    ):
        assert pair_figures.where_matches_lie(dict(enumerate(places, 1))) == words
    r = np.linspace(0.2, 0.8, 20)
    for gains, words in (
        ([(1, 1)], "the sampling errs less on rough and flat patches"),
        ([(1, -1), (0.5, -2)], "the sampling errs less on rough patches"),
        ([(-1, -1)], "a random subset errs less everywhere"),
        ([(1, 1), (-1, -1)], "the sampling errs less than a random subset one way, more the other"),
    ):
        panels = [
            (f"t, {way}", r, np.full(20, 3.0), 3 + np.where(r > 0.5, flat, rough))
            for way, (rough, flat) in zip(("one way", "the other"), gains, strict=False)
        ]
        assert rough_and_flat.message(panels) == words


def test_the_name_of_a_reference_keeps_away_from_the_curves():
    """At the right, unless the curves come down to the line there."""
    r = np.linspace(0.1, 0.9, 200)
    for z, side in ((4 - 3.9 * r, "left"), (0.1 + 3.9 * r, "right")):
        figure = rough_and_flat.figure([("t", r, z, z + 0.1)], {"floors": {"fresh dots": 0.5}})
        (name,) = [text for text in figure.axes[0].texts if text.get_text() == "fresh dots, 0.50"]
        assert name.get_ha() == side
