"""The figure of how many dots are enough shows its tables: one surface, a few side by side, the median of many."""

import numpy as np
import pandas as pd
import pytest
from test_figures import surface_tables

from drawn import colour_of, words_of
from sparsurf.report.figures import enough, layout

COLOURS = {
    ("farthest", "as_written"): "#56B4E9",
    ("farthest", "recovered"): "#0072B2",
    ("uniform", "as_written"): "#000000",
}


def curves_in(ax):
    """The curves that are drawn, by colour; floors are drawn across and dashed."""
    return {
        colour_of(line): line.get_xydata()
        for line in ax.lines
        if not line.is_dashed() and len(line.get_xydata()) > 1
    }


def texts_in(ax):
    return {text.get_text(): text for text in ax.texts}


def test_one_surface_shows_its_cloud_curves_and_floors():
    tables = surface_tables()
    figure = enough.figure([tables])
    (ax,) = figure.axes
    np.testing.assert_array_equal(
        ax.collections[0].get_offsets(), tables.grid[["n_S_percent", "Z_tS_as_written"]]
    )
    drawn = curves_in(ax)
    for key, rows in tables.curves.groupby(["sampler", "reading"]):
        np.testing.assert_array_equal(drawn[COLOURS[key]], rows[["n_S_percent", "Z"]])
    assert len(drawn) == 3 and ax.get_xscale() == "log" and ax.get_ylim()[0] == 0
    floors = {line.get_ydata()[0]: line.get_linewidth() for line in ax.lines if line.is_dashed()}
    assert sorted(floors) == sorted(tables.floors["Z"]) and max(floors, key=floors.get) == 0.5
    assert words_of(figure)[0] == "p/c1"
    texts = texts_in(ax)
    assert "8 % of the dots are enough" in texts and any("200 combinations" in words for words in texts)
    arrow = next(t for t in ax.texts if not t.get_text() and getattr(t, "arrow_patch", None))
    assert tuple(arrow.xy) == (8.0, 0.5)
    for name, z in tables.floors.set_index("floor")["Z"].items():
        assert texts[enough.FLOORS.get(name, name)].xy == (1, z)


def test_a_grid_of_another_reading_has_no_cloud():
    tables = surface_tables()
    tables = tables._replace(grid=tables.grid.drop(columns="Z_tS_as_written"))
    (ax,) = enough.figure([tables]).axes
    assert len(ax.collections[0].get_offsets()) == 0 and not any(
        "combinations" in words for words in texts_in(ax)
    )


def test_the_answer_is_that_of_the_floor_that_is_asked_for():
    tables = surface_tables()
    other = tables.enough.assign(n_S_percent=[8.0, 3.0, 1.4], Z=[0.5, 0.7, 0.9])
    wrong = other.assign(reading="as_written", n_S_percent=60.0)
    tables = tables._replace(enough=pd.concat([wrong, other]))
    for floor, words in (("turned", "3 %"), ("atoms moved 0.1 Å", "1.4 %")):
        ax = enough.figure([tables], floor).axes[0]
        assert f"{words} of the dots are enough" in texts_in(ax)
    shown = tables.grid.assign(Z_tS_as_coded=7.0)
    ax = enough.figure([tables._replace(grid=shown)], reading="as_coded").axes[0]
    assert (ax.collections[0].get_offsets()[:, 1] == 7).all()


def test_words_cover_no_curve_and_no_other_words():
    ax = enough.figure([surface_tables()]).axes[0]
    dots = np.concatenate([ax.transData.transform(line) for line in curves_in(ax).values()])
    inside = [text for text in ax.texts if text.get_text() and not hasattr(text, "xy")]
    boxes = [text.get_window_extent() for text in inside]
    assert len(boxes) == 5
    for k, box in enumerate(boxes):
        assert box.count_contains(dots) == 0 == box.count_overlaps(boxes[:k])


def test_a_few_surfaces_have_a_panel_each_on_one_scale():
    few = [surface_tables(f"p/c{k}", 1 + k / 10) for k in range(5)]
    axes = enough.figure(few).axes
    assert len(axes) == 5 and len({ax.get_ylim() for ax in axes}) == 1
    for ax, tables in zip(axes, few, strict=True):
        assert ax.get_title() == f"{tables.name}: 8 % are enough"
        own = tables.curves[(tables.curves["sampler"] == "uniform")]
        np.testing.assert_array_equal(curves_in(ax)["#000000"], own[["n_S_percent", "Z"]])
        ring = next(line for line in ax.lines if len(line.get_xydata()) == 1)
        assert ring.get_xydata().tolist() == tables.enough[["n_S_percent", "Z"]].iloc[:1].to_numpy().tolist()


def test_many_surfaces_share_a_panel_of_medians_with_a_band():
    factors = np.array([0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.9])
    many = [surface_tables(f"p/c{k}", factor) for k, factor in enumerate(factors)]
    only = pd.DataFrame({"floor": ["fresh dots", "alone"], "Z": [0.5 * factors[-1], 3.0]})
    many[-1] = many[-1]._replace(floors=only)
    figure = enough.figure(many)
    (ax,) = figure.axes
    one = surface_tables()
    for key, rows in one.curves.groupby(["sampler", "reading"]):
        x, z = curves_in(ax)[COLOURS[key]].T
        wanted = np.interp(np.log(x), np.log(rows["n_S_percent"]), rows["Z"])
        np.testing.assert_allclose(z, 1.1 * wanted)  # the median factor
        assert (x >= 1).all() and (x <= 90).all()
    band = ax.collections[1].get_paths()[0].vertices
    at = band[np.isclose(band[:, 0], enough.ALONG[0]), 1]
    middle = ax.lines[0].get_ydata()[0] / 1.1  # the median, of the factor 1.1
    assert (at.min(), at.max()) == pytest.approx(np.quantile(factors, enough.BAND) * middle)
    floors = [line.get_ydata()[0] for line in ax.lines if line.is_dashed()]
    assert max(floors) < 1.5 and np.isclose(floors, 0.55).any()  # `alone` is known of one surface only
    assert len(ax.collections[0].get_offsets()) == 7 * 200
    assert "7 surfaces" in words_of(figure)[0]


def test_labels_are_moved_apart_no_farther_than_they_need():
    room = np.full(4, 2.0)
    np.testing.assert_allclose(layout.apart(np.array([2.0, 6, 10, 14]), room, 20), [2, 6, 10, 14])
    close = layout.apart(np.array([5.0, 5.0, 5.2, 15]), room, 20)
    assert (np.diff(close) > 1.999).all() and close[3] == 15
    assert abs(close[:3].mean() - 5.07) < 0.1
    at_end = layout.apart(np.array([19.0, 19.5, 20]), room[:3], 20)
    assert at_end[-1] <= 19 + 1e-9 and (np.diff(at_end) > 1.99).all()


def test_a_box_goes_where_it_covers_least():
    figure = layout.sheet(100, 100)
    ax = layout.axes(figure, 0, 0, 100, 100)
    ax.get_figure().dpi = 300
    size = np.array([100.0, 40])
    busy = np.array([[300.0, 300], [310, 300], [600, 600]])
    places = [(5.0, 5), (300, 300), (600, 600), (900, 900)]
    assert layout.free_place(ax, size, places, busy, [])[0].tolist() == [900, 900]
    place, cost = layout.free_place(ax, size, places[:3], busy, [])
    assert place.tolist() == [600, 600] and cost == 1
    assert layout.free_place(ax, size, places, busy, [(np.array([880.0, 890]), size)])[0].tolist() == [
        600,
        600,
    ]
    assert layout.free_place(ax, size, places[:1], busy, [])[1] == np.inf  # beyond the axes


def test_the_tables_of_a_surface_are_read_from_its_folder(tmp_path):
    folder = tmp_path / "p" / "c1"
    folder.mkdir(parents=True)
    for name, table in zip(enough.Tables._fields[1:], surface_tables()[1:], strict=True):
        table.to_csv(folder / f"{name}.csv", index=False)
    found = enough.read(folder)
    assert found.name == "p/c1"
    for table, wanted in zip(found[1:], surface_tables()[1:], strict=True):
        pd.testing.assert_frame_equal(table, wanted.reset_index(drop=True))
    assert enough.read(folder, sampled=False).grid is None  # that of an earlier study


def test_without_a_grid_there_is_no_cloud():
    figure = enough.figure([surface_tables(rows=0)])
    ax = figure.axes[0]
    assert not any(len(each.get_offsets()) for each in ax.collections) and len(curves_in(ax)) == 3
    assert not [words for words in texts_in(ax) if "sampling" in words]
    assert ax.get_xlim()[0] == 0.9 and "8 % of the dots are enough" in texts_in(ax)
    assert not [
        words for words in words_of(enough.figure([surface_tables(rows=0)] * 2)) if "sampling" in words
    ]
