"""Figures of rows and dots in another order, with an unknown value, and of surfaces that are turned."""

import functools
from dataclasses import replace

import figure_cases
import numpy as np
import pandas as pd
import pytest
from figure_cases import PICTURES
from matplotlib.text import Text
from scipy.spatial.transform import Rotation

from conftest import ball
from sparsurf.molecules.molecule import Molecule
from sparsurf.orientation import rigid_fit
from sparsurf.surfaces.surface import Surface
from sparsurf.views import layout
from sparsurf_study.report.figures import (
    changes,
    distributions,
    over_time,
    pair_figures,
)


@pytest.fixture(autouse=True)
def coarse_pictures(monkeypatch):
    """Pictures of fewer pixels: they are compared with one another alone."""
    monkeypatch.setattr(layout, "DPI", 100)


def shuffled(value):
    """A table or a list in another order; anything else as it is."""
    if isinstance(value, pd.DataFrame):
        return value.sample(frac=1, random_state=2, ignore_index=True)
    return value[::-1] if isinstance(value, list) else value


def data_of(figure, pictures=True):
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
        shown += [as_text(image.get_array()) for image in ax.images if pictures]
        shown += [
            as_text([bar.get_height(), bar.get_width(), bar.get_x()])
            for bar in ax.patches
            if hasattr(bar, "get_x")
        ]
    return sorted(shown)


def as_text(numbers):
    """Numbers as text, without the last digits, which depend on the order of a sum."""
    numbers = np.ma.filled(np.ma.asarray(numbers, float), np.nan)
    return str((np.round(numbers, 6) + 0.0).tolist())


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
    (points, normals, _), (other, of_other, turn) = drawn["seen"]
    of_second = drawn["forms"][1][1]
    assert np.allclose(of_second.normals @ turn.T, of_other)
    assert np.allclose(points, other, atol=0.05) and np.allclose(normals, of_other, atol=0.01)
    change = drawn["forms"][0][3]
    most = change >= np.nanquantile(change, 0.9)
    assert normals[most].mean(axis=0)[2] > 0.99 * np.linalg.norm(normals[most].mean(axis=0))


SHIFT = np.array([30.0, -20, 10])  # Å, of turned dots


def rearranged(value, order=None, turn=None, bend=0.0):
    """Arguments of a figure with their dots in another order, or turned, or bent; tables of as many rows follow their dots.

    `order` is a function of the number of dots, and `turn` a rotation.
    """
    if isinstance(value, list | tuple):
        return type(value)(rearranged(part, order, turn, bend) for part in value)
    if isinstance(value, Molecule) and turn is not None:
        return replace(value, xyz=turn.apply(value.xyz[0])[None] + SHIFT)
    rows = (
        None
        if order is None or not hasattr(value, "__len__") or isinstance(value, str)
        else order(len(value))
    )
    if isinstance(value, Surface):
        points, normals = value.points, value.normals
        points = points + bend * (points @ [0.2, 0.4, -0.3])[:, None] ** 2 * [1.0, 0.5, 0.3]
        if turn is not None:
            points, normals = turn.apply(points) + SHIFT, turn.apply(normals)
        surface = replace(value, points=points, normals=normals)
        return surface if rows is None else surface[rows]
    if rows is None or not isinstance(value, np.ndarray | pd.DataFrame):
        return value
    if isinstance(value, np.ndarray) and value.dtype.kind == "i":  # numbers of the dots
        return np.argsort(rows)[value[rows]]
    return value.iloc[rows].reset_index(drop=True) if isinstance(value, pd.DataFrame) else value[rows]


def shuffled_rows(n):
    """The numbers of n rows in another order, the same for everything that has n rows."""
    return np.random.default_rng(n).permutation(n)


OF_DOTS = {  # figure: the module and the function that draws it in figure_cases, and how many arguments come with dots
    "roughness": (figure_cases.roughness, "figure", 2),
    "subsets": (figure_cases.subsets, "figure", 3),
    "rough_and_flat": (figure_cases.rough_and_flat, "figure", 1),
    "book": (pair_figures, "book_figure", 3),
    "book_apart": (pair_figures, "book_figure", 3),
    "changes": (figure_cases, "changes_figure", 2),
}


@functools.cache
def drawn(name):
    """A figure as it is, with which others are compared."""
    return PICTURES[name]()


def drawn_from(name, monkeypatch, **changes):
    """A figure of `figure_cases` whose dots were `rearranged`."""
    module, function, n_changed = OF_DOTS[name]
    draw = getattr(module, function)

    def draw_changed(*arguments):
        if name == "roughness":
            arguments = Surface(*arguments[:2]), *arguments[2:]
        arguments = *(rearranged(value, **changes) for value in arguments[:n_changed]), *arguments[n_changed:]
        if name == "roughness":
            arguments = arguments[0].points, arguments[0].normals, *arguments[1:]
        return draw(*arguments)

    with monkeypatch.context() as patch:
        patch.setattr(module, function, draw_changed)
        return PICTURES[name]()


def assert_alike(figure, expected):
    """Compare numbers, words and pictures of two figures; rounding may move the rim of a disc across a pixel."""
    assert data_of(figure, pictures=False) == data_of(expected, pictures=False)
    for picture, other in zip(pictures_of(figure), pictures_of(expected), strict=True):
        assert (np.abs(picture - other) > 2).mean() < 2e-3


def pictures_of(figure):
    """The pictures of dots of a figure."""
    return [image.get_array().astype(int) for ax in figure.axes for image in ax.images]


@pytest.mark.parametrize("name", OF_DOTS)
def test_dots_in_another_order_give_the_same_figure(name, monkeypatch):
    expected = drawn(name)
    assert_alike(drawn_from(name, monkeypatch, order=shuffled_rows), expected)


@pytest.mark.parametrize("name", sorted(OF_DOTS.keys() - {"rough_and_flat"}))
def test_turned_dots_give_the_same_figure(name, monkeypatch):
    """Bent ones, as the view of a symmetric surface is not determined; two forms have no symmetry."""
    bend = 0.0 if name == "changes" else 0.05
    turn = Rotation.from_euler("xyz", [30, 110, 200], degrees=True)
    expected = drawn_from(name, monkeypatch, bend=bend) if bend else drawn(name)
    assert_alike(drawn_from(name, monkeypatch, turn=turn, bend=bend), expected)


def rows_of_table_1(change, monkeypatch):
    """What the figure of Table I draws in the row of each range and combination, from tables of changed rows."""
    draw = figure_cases.table1_figure
    with monkeypatch.context() as patch:
        patch.setattr(figure_cases, "table1_figure", lambda *tables: draw(*change(*tables)))
        figure = PICTURES["table1"]()
    names, drawn = [text.get_text() for text in figure.axes[0].get_yticklabels()], {}
    for panel, ax in enumerate(figure.axes):
        for line in ax.lines:
            if line.get_transform() != ax.transData:  # the line at 0
                continue
            for x, y in np.column_stack([np.asarray(values, float) for values in line.get_data()]):
                if np.isfinite(x):
                    drawn.setdefault(names[int(y)], []).append((panel, line.get_color(), round(float(x), 9)))
    return {name: sorted(values) for name, values in drawn.items()}


def test_each_row_of_table_1_keeps_its_values_in_any_order(monkeypatch):
    expected = rows_of_table_1(lambda *tables: tables, monkeypatch)
    shuffled_alike = rows_of_table_1(
        lambda *tables: [table.iloc[shuffled_rows(len(table))] for table in tables], monkeypatch
    )
    assert shuffled_alike == expected and len(expected) == 10


def test_a_range_that_no_run_reached_shows_the_published_value_alone(monkeypatch):
    """In black: nothing says that it lies outside of the runs."""

    def without_runs(places, rows):
        places = places.assign(n_runs=places["n_runs"].where(places.index != 3, 0))
        for name in ("d", "Z_tS"):
            places.loc[3, [f"{name}_lowest", f"{name}_highest"]] = np.nan
            places[f"{name}_inside"] = places[f"{name}_inside"].astype(float).where(places.index != 3)
            rows.loc[3, f"{name}_full"] = np.nan
        return places, rows

    expected = rows_of_table_1(lambda *tables: tables, monkeypatch)
    found = rows_of_table_1(without_runs, monkeypatch)
    (changed,) = [name for name in expected if found[name] != expected[name]]
    values = pd.DataFrame(figure_cases.TABLE_1).loc[3, ["d", "Z_tS"]]
    assert found[changed] == [(k, "black", round(value, 9)) for k, value in enumerate(values)]


def test_a_patch_of_unknown_error_is_left_out_of_rough_and_flat(monkeypatch):
    """Of the curve, and of what the head says."""
    draw, drawn = figure_cases.rough_and_flat.figure, []

    def measured(change):
        with monkeypatch.context() as patch:
            patch.setattr(
                figure_cases.rough_and_flat,
                "figure",
                lambda panels, references: drawn.append(change(panels)) or draw(drawn[-1], references),
            )
            return data_of(PICTURES["rough_and_flat"]())

    roughness = figure_cases.distances()[0]
    hidden = (np.arange(500) % 7 == 3) & (np.abs(roughness - 0.5) < 0.3)  # not the ends of the axis

    def unknown(panels):
        return [(title, r, *(np.where(hidden, np.nan, z) for z in zs)) for title, r, *zs in panels]

    def left_out(panels):
        return [(title, *(values[~hidden] for values in arrays)) for title, *arrays in panels]

    assert measured(unknown) == measured(left_out) != measured(lambda panels: panels)
    assert figure_cases.rough_and_flat.message(drawn[0]) == figure_cases.rough_and_flat.message(drawn[1])


def test_a_residue_of_unknown_change_has_no_bar_and_pale_dots(monkeypatch):
    """And is not counted: of eight residues one is buried, and two change more than their floor."""
    figure = PICTURES["changes"]()
    ax = figure.axes[-1]
    bars = [bar for bar in ax.patches if bar.get_width() == 1.0]
    change = np.array([0.5, 0.2, 4.0, 0.9, np.nan, 0.3, 2.0, 0.4])
    assert np.allclose(bars[4].get_facecolor()[:3], changes.REST)
    assert any("2 of 7" in text.get_text() for text in figure.findobj(Text))
    scale = figure_cases.layout.scale(1, 4)
    colours = changes.change_colours(change, scale)
    assert np.allclose(colours[4], changes.REST) and np.allclose(colours[[0, 1, 3, 5, 7]], changes.BELOW)
    assert not np.allclose(colours[2], colours[6])
