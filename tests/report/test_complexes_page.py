"""The page on many complexes follows from the stored tables; the book opens along its hinge."""

import numpy as np
import pandas as pd
import pytest

from conftest import ROOT, make_blob
from drawn import check_texts
from sparsurf.report.complexes_page import TABLES, complexes_markdown
from sparsurf.report.figures.book import book_figure, opened
from sparsurf.report.figures.thinning_figure import thinning_figure
from sparsurf.surfaces.surface import Surface

DOCS = ROOT / "docs"


def stored():
    return {name: pd.read_csv(DOCS / "tables" / f"{name}.csv") for name in TABLES}


def test_the_stored_page_is_that_of_the_stored_tables():
    assert complexes_markdown(stored()) == (DOCS / "complexes.md").read_text(encoding="utf-8")


def test_the_page_says_what_the_numbers_say():
    tables = stored()
    means = tables["complexes_means"]
    bound = (
        (means["group"] == "bound")
        & means["descriptor"].str.startswith("published")
        & (means["map"] == "smoothed")
    )
    own = bound & (means["score"] == "complementarity")
    for mean, low, high, words in (
        (0.55, 0.53, 0.57, "above a coin, by little"),
        (0.59, 0.55, 0.63, "above a coin, by little"),
        (0.60, 0.55, 0.65, "above a coin. "),
        (0.52, 0.49, 0.55, "not to be told"),
        (0.49, 0.46, 0.52, "not to be told"),
        (0.45, 0.41, 0.49, "below a coin"),
    ):
        means.loc[own, ["mean", "low", "high"]] = mean, low, high
        assert words in complexes_markdown(tables).split("\n")[2]
    means.loc[
        means["score"].isin(["flatness", "planarity", "protrusion", "hydropathy", "centroid"]), "mean"
    ] = 0.3
    assert "None of the simple properties does better" in complexes_markdown(tables)
    variants = tables["complexes_variants"]
    variants.loc[variants["score"] == "hydropathy + protrusion", "mean"] = 0.3
    assert "hydropathy and protrusion raises their mean from 0.300 to" in complexes_markdown(tables)


def test_a_book_opens_along_its_hinge():
    # two plates face each other, 2 Å apart in z; the right edge of the left page lies on the left edge of the right one
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(10.0), np.arange(20.0)))
    lower = Surface(np.column_stack([x, y, 0 * x]), np.tile([0.0, 0, 1], (200, 1)))
    upper = Surface(np.column_stack([x, y, 0 * x + 2]), np.tile([0.0, 0, -1], (200, 1)))
    left, right = opened((lower, upper), (np.ones(200, bool), np.ones(200, bool)))
    for page, plate in ((left, lower), (right, upper)):
        assert np.allclose(page @ page.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(page) > 0
        assert np.allclose(page[2], plate.normals[0])  # the inner side looks at the viewer
        assert np.allclose(page[1], [0, 1, 0])  # the longer side stands upright
    assert np.allclose(lower.points @ left[0], -(upper.points @ right[0]))
    turned = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])  # the plates stand upright now
    both = [Surface(plate.points @ turned.T, plate.normals @ turned.T) for plate in (lower, upper)]
    for page, plate in zip(opened(both, (np.ones(200, bool),) * 2), both, strict=True):
        assert np.allclose(page[2], plate.normals[0])
    apart = opened((lower, Surface(np.add(upper.points, [0, 0, 50]), upper.normals)))
    assert np.allclose(apart[0][2], [0, 0, 1])


@pytest.mark.parametrize("touching", [True, False])
def test_the_book_keeps_its_texts_apart(touching, monkeypatch):
    points, normals = make_blob(300)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    surfaces = [Surface(points + np.array([shift, 0, 0]), normals) for shift in (0, 21)]
    rng = np.random.default_rng(1)
    tables = [
        pd.DataFrame({"propensity_smoothed": rng.random(300), "similarity_smoothed": rng.random(300)}).assign(
            interface=(np.arange(300) < 50) * touching
        )
        for _ in surfaces
    ]
    check_texts(book_figure("1abc", surfaces, tables), monkeypatch)


def test_the_figure_of_thinning_draws_every_sampler_once(monkeypatch):
    rows = [
        (sampler, percent, surface, 0.9 + percent / 200, 0.6, 1 + percent)
        for sampler in ("farthest", "new")
        for surface in ("full", "recovered")
        for percent in (1.0, 5.0)
    ]
    table = pd.DataFrame(
        [("all", 100.0, "full", 1.0, 0.62, 300.0), *rows],
        columns=["sampler", "percent", "surface", "correlation", "auc", "seconds"],
    )
    figure = thinning_figure(table.assign(n_S_percent=table["percent"]), "two proteins")
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == ["farthest point", "farthest point, recovered", "new", "new, recovered"]
    check_texts(figure, monkeypatch)
    first = figure.axes[0].get_lines()[0]
    assert first.get_xdata().tolist() == [1.0, 5.0]
    assert first.get_ydata().tolist() == [0.905, 0.925]
