"""Figures of rows in another order, of rows with an unknown value, and of surfaces that are turned."""

import figure_cases
import numpy as np
import pandas as pd
import pytest
from figure_cases import PICTURES
from matplotlib.text import Text
from scipy.spatial.transform import Rotation

from conftest import ball
from sparsurf.orientation import rigid_fit
from sparsurf.surfaces.surface import Surface
from sparsurf_study.report.figures import (
    changes,
    distributions,
    over_time,
    pair_figures,
)


def shuffled(value):
    """A table or a list in another order; anything else as it is."""
    if isinstance(value, pd.DataFrame):
        return value.sample(frac=1, random_state=2, ignore_index=True)
    return value[::-1] if isinstance(value, list) else value


def data_of(figure):
    """What a figure shows, in an order that does not depend on its rows: lines, points, bars, pictures and texts."""
    shown = [" ".join(text.get_text().split()) for text in figure.findobj(Text)]
    for ax in figure.axes:
        for line in ax.lines:
            xy = np.column_stack([np.asarray(x, float) for x in line.get_data()])
            xy = xy[np.isfinite(xy).all(axis=1)]
            joined = line.get_linestyle() not in ("None", "")
            shown.append(as_text(xy if joined else xy[np.lexsort(xy.T)]))
        for points in ax.collections:
            xy = np.asarray(points.get_offsets(), float)
            bands = [as_text(path.vertices) for path in points.get_paths()] if len(xy) < 2 else []
            shown += [as_text(xy[np.lexsort(xy.T)]), *bands]
        shown += [as_text(image.get_array()) for image in ax.images]
        shown += [
            as_text([bar.get_height(), bar.get_width(), bar.get_x()])
            for bar in ax.patches
            if hasattr(bar, "get_x")
        ]
    return sorted(shown)


def as_text(numbers):
    """Numbers as text, without the last digits, which depend on the order of a sum."""
    numbers = np.ma.filled(np.ma.asarray(numbers, float), np.nan)
    return np.array2string(np.round(numbers, 6) + 0.0, threshold=10**6, floatmode="fixed", precision=6)


OF_TABLES = {  # figure: the function that draws it in figure_cases, by its module
    "number_of_dots": (figure_cases.number_of_dots, "figure"),
    "d_over_grid": (figure_cases.d_over_grid, "figure"),
    "ensemble": (figure_cases.over_time, "ensemble_figure"),
    "simulation": (figure_cases, "simulation_figure"),
    "compare": (figure_cases, "comparison_figure"),
    "pairs": (figure_cases.pair_figures, "over_pairs"),
    "required_dots_of_many": (figure_cases.required_dots, "figure"),
    "distributions": (figure_cases.distributions, "figure"),
}


@pytest.mark.parametrize("name", OF_TABLES)
def test_rows_in_another_order_give_the_same_figure(name, monkeypatch):
    module, function = OF_TABLES[name]
    expected, draw = data_of(PICTURES[name]()), getattr(module, function)
    monkeypatch.setattr(module, function, lambda *arguments, **keys: draw(*map(shuffled, arguments), **keys))
    assert data_of(PICTURES[name]()) == expected


def test_frames_in_another_order_give_the_same_picture_of_residues(monkeypatch):
    """The residues stay in the order of their molecule."""
    expected, draw = data_of(PICTURES["residues_over_time"]()), over_time.residues_figure
    monkeypatch.setattr(over_time, "residues_figure", lambda rows, residues: draw(shuffled(rows), residues))
    assert data_of(PICTURES["residues_over_time"]()) == expected


def test_each_of_three_chains_ends_with_a_line_and_is_named():
    residues = pd.DataFrame({"chain": [*"AAAABBCCC"], "residue": [*map(str, [1, 2, 3, 4, 5, 6, 2, 3, 4])]})
    residues = residues.assign(mean_roughness=0.1 * np.arange(9), sd_roughness=0.01)
    rows = pd.DataFrame(np.random.default_rng(0).random((2, 9)))
    rows.insert(0, "time_ps", [0.0, 100.0])
    rows.insert(0, "frame", [0, 1])
    ax = over_time.residues_figure(rows, residues).axes[0]
    assert sorted(line.get_ydata()[0] for line in ax.lines) == [3.5, 5.5]
    names = [text.get_text() for text in ax.get_yticklabels()]
    assert names == ["A 1", "A 2", "A 3", "A 4", "B 5", "B 6", "C 2", "C 3", "C 4"]


def test_an_unknown_value_is_left_out_of_a_distribution(monkeypatch):
    """It is neither the largest value nor a zero."""

    def measures(rows):
        with monkeypatch.context() as patch:
            draw = distributions.figure
            patch.setattr(distributions, "figure", lambda table: draw(rows(table)))
            return data_of(PICTURES["distributions"]())

    found = measures(lambda table: table.drop(index=7).reindex(table.index))
    assert found == measures(lambda table: table.drop(index=7)) != measures(lambda table: table)


def turned(surface, turn, shift):
    return Surface(turn.apply(surface.points) + shift, turn.apply(surface.normals))


def partners():
    """Two balls of 300 dots that nearly touch along (1, 2, -1), without another symmetry: the first is stretched."""
    unit = ball(300)[1]
    along = np.array([1.0, 2, -1]) / 6**0.5
    points = unit * [6, 5, 4]
    normals = unit / [6, 5, 4]
    first = Surface(points, normals / np.linalg.norm(normals, axis=1)[:, None])
    second = Surface(4 * unit + 10 * along, unit)
    return [first, second], [first.points @ along > 4, (second.points - 10 * along) @ along < -3]


@pytest.mark.parametrize("touch", [True, False])
def test_an_opened_pair_shows_the_sides_that_face_each_other_however_it_is_turned(touch):
    surfaces, touching = partners()
    if not touch:
        touching = [np.zeros_like(mask) for mask in touching]
    pages = pair_figures.partners_opened(surfaces, touching)
    opened = pair_figures.side_by_side(surfaces, pages, [0, 0])
    left, right = opened.points[:300], opened.points[300:]
    assert left[:, 0].max() < right[:, 0].min()
    for side, (page, of_page) in enumerate(zip(pages, (slice(0, 300), slice(300, 600)), strict=True)):
        own, normals = surfaces[side], opened.normals[of_page]
        rotation, _ = rigid_fit(own.points, opened.points[of_page])
        assert np.linalg.det(page) == pytest.approx(1) and np.allclose(own.normals @ rotation, normals)
        towards = surfaces[1 - side].points.mean(axis=0) - own.points.mean(axis=0)
        assert (towards @ rotation / np.linalg.norm(towards))[2] > 0.9  # to the viewer
    turn = Rotation.from_euler("xyz", [30, 110, 200], degrees=True)
    again = [turned(surface, turn, [30, -10, 5]) for surface in surfaces]
    pages = pair_figures.partners_opened(again, touching)
    of_turned = pair_figures.side_by_side(again, pages, [0, 0])
    assert np.allclose(of_turned.points, opened.points, atol=1e-6)
    assert np.allclose(of_turned.normals, opened.normals, atol=1e-6)


def test_two_forms_are_seen_alike_from_above_what_changes_most():
    """The second is turned and moved, and comes to lie on the first."""
    drawn = {}

    def note(name, forms, table):
        drawn["seen"], drawn["forms"] = changes.seen_alike(forms), forms

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figure_cases, "changes_figure", note)
        PICTURES["changes"]()
    (points, normals), (other, of_other) = drawn["seen"]
    assert np.allclose(points, other, atol=0.05) and np.allclose(normals, of_other, atol=0.01)
    change = drawn["forms"][0][3]
    most = change >= np.nanquantile(change, 0.9)
    assert normals[most].mean(axis=0)[2] > 0.99 * np.linalg.norm(normals[most].mean(axis=0))
