"""The figure of how many dots are enough shows its tables: one surface, a few side by side, the median of many."""

import numpy as np
import pandas as pd
import pytest
from test_figures import surface_tables

from drawn import colour_of, legend_of, words_of
from sparsurf.columns import missing_columns
from sparsurf.report.figures import required_dots

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


def names_in(figure):
    """Entries of the legend, each on one line."""
    return [words.replace("\n", " ") for words, _ in legend_of(figure)]


def test_one_surface_shows_its_cloud_curves_and_floors():
    tables = surface_tables()
    figure = required_dots.figure([tables])
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
    assert ax.get_title() == "8 % of the dots are enough"
    ring = next(line for line in ax.lines if len(line.get_xydata()) == 1)
    assert ring.get_xydata().tolist() == [[8.0, 0.5]]
    assert names_in(figure) == [
        "paper's sampling, all combinations", "farthest point dots as they are",
        "the surface recovered from the same dots", "uniform subset", "enough",
        "atoms moved 0.1 Å: 0.90", "the molecule rotated: 0.70", "fresh dots of the same surface: 0.50",
    ]  # fmt: skip
    floors = figure.legends[0].legend_handles[5:]
    drawn = sorted((line for line in ax.lines if line.is_dashed()), key=lambda line: -line.get_ydata()[0])
    for line, entry in zip(drawn, floors, strict=True):
        assert line._dash_pattern == entry._dash_pattern and colour_of(line) == colour_of(entry)
    assert [colour_of(line) for line in drawn] == ["#777777", "#777777", "#000000"]


def test_the_combinations_as_coded_have_their_own_panel():
    tables = surface_tables()
    tables = tables._replace(grid=tables.grid.assign(Z_tS_as_coded=tables.grid["Z_tS_as_written"] + 7.0))
    written, coded = required_dots.figure([tables]).axes
    for ax, reading in ((written, "as written"), (coded, "as coded")):
        column = f"Z_tS_{reading.replace(' ', '_')}"
        np.testing.assert_array_equal(ax.collections[0].get_offsets(), tables.grid[["n_S_percent", column]])
        assert ax.get_ylabel().endswith(reading)
    assert coded.get_xlim() == written.get_xlim()
    assert curves_in(coded) == {} and coded.get_ylim()[1] > 7
    floors = [line.get_ydata()[0] for line in coded.lines if line.is_dashed()]
    assert sorted(floors) == sorted(tables.floors["Z"])


def test_a_grid_of_another_reading_has_no_cloud():
    tables = surface_tables()
    tables = tables._replace(grid=tables.grid.drop(columns="Z_tS_as_written"))
    figure = required_dots.figure([tables])
    assert len(figure.axes[0].collections[0].get_offsets()) == 0
    assert not any("combinations" in words for words in names_in(figure))


def test_the_answer_is_that_of_the_floor_that_is_requested():
    tables = surface_tables()
    other = tables.required_dots.assign(n_S_percent=[8.0, 3.0, 1.4], Z=[0.5, 0.7, 0.9])
    wrong = other.assign(reading="as_written", n_S_percent=60.0)
    tables = tables._replace(required_dots=pd.concat([wrong, other]))
    for floor, words in (("turned", "3 %"), ("atoms moved 0.1 Å", "1.4 %")):
        ax = required_dots.figure([tables], floor).axes[0]
        assert f"{words} of the dots are enough" == ax.get_title()
    shown = tables.grid.assign(Z_tS_as_coded=7.0)
    ax = required_dots.figure([tables._replace(grid=shown)], reading="as_coded").axes[0]
    assert (ax.collections[0].get_offsets()[:, 1] == 7).all()


def test_a_few_surfaces_have_a_panel_each_on_one_scale():
    few = [surface_tables(f"p/c{k}", 1 + k / 10) for k in range(5)]
    axes = required_dots.figure(few).axes
    assert len(axes) == 5 and len({ax.get_ylim() for ax in axes}) == 1
    for ax, tables in zip(axes, few, strict=True):
        assert ax.get_title() == f"{tables.name}\n8 % of the dots are enough"
        own = tables.curves[(tables.curves["sampler"] == "uniform")]
        np.testing.assert_array_equal(curves_in(ax)["#000000"], own[["n_S_percent", "Z"]])
        ring = next(line for line in ax.lines if len(line.get_xydata()) == 1)
        assert (
            ring.get_xydata().tolist()
            == tables.required_dots[["n_S_percent", "Z"]].iloc[:1].to_numpy().tolist()
        )


def test_side_by_side_each_kind_of_floor_is_drawn_once():
    """The lowest of the frames, and the floor that defines what is enough though it is not the lowest of its kind."""
    names = [
        "frames 100 ps apart",
        "atoms moved 0.3 Å",
        "frames 1 ps apart",
        "turned",
        "atoms moved 0.1 Å",
        "fresh dots",
    ]
    floors = pd.DataFrame({"floor": names, "Z": [1.4, 1.2, 1.1, 0.9, 0.7, 0.5]})
    two = [surface_tables(f"{name}/c1")._replace(floors=floors) for name in "pq"]
    moved = two[0].required_dots.assign(floor="atoms moved 0.3 Å")
    two = [tables._replace(required_dots=pd.concat([tables.required_dots, moved])) for tables in two]
    for floor, drawn in (
        ("fresh dots", [1.1, 0.9, 0.7, 0.5]),
        ("atoms moved 0.3 Å", [1.2, 1.1, 0.9, 0.7, 0.5]),
    ):
        figure = required_dots.figure(two, floor)
        for ax in figure.axes:
            assert [line.get_ydata()[0] for line in ax.lines if line.is_dashed()] == drawn
        assert [ax.get_title().split("\n")[0] for ax in figure.axes] == ["p", "q"]
    assert len([line for line in required_dots.figure(two[:1]).axes[0].lines if line.is_dashed()]) == 6


def test_many_surfaces_share_a_panel_of_medians_with_a_band():
    factors = np.array([0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.9])
    many = [surface_tables(f"p/c{k}", factor) for k, factor in enumerate(factors)]
    only = pd.DataFrame({"floor": ["fresh dots", "alone"], "Z": [0.5 * factors[-1], 3.0]})
    many[-1] = many[-1]._replace(floors=only)
    figure = required_dots.figure(many)
    (ax,) = figure.axes
    one = surface_tables()
    for key, rows in one.curves.groupby(["sampler", "reading"]):
        x, z = curves_in(ax)[COLOURS[key]].T
        wanted = np.interp(np.log(x), np.log(rows["n_S_percent"]), rows["Z"])
        np.testing.assert_allclose(z, 1.1 * wanted)  # the median factor
        assert (x >= 1).all() and (x <= 90).all()
    band = ax.collections[1].get_paths()[0].vertices
    at = band[np.isclose(band[:, 0], required_dots.ALONG[0]), 1]
    middle = ax.lines[0].get_ydata()[0] / 1.1  # the median, of the factor 1.1
    assert (at.min(), at.max()) == pytest.approx(np.quantile(factors, required_dots.BAND) * middle)
    floors = [line.get_ydata()[0] for line in ax.lines if line.is_dashed()]
    assert max(floors) < 1.5 and np.isclose(floors, 0.55).any()  # `alone` is known of one surface only
    assert len(ax.collections[0].get_offsets()) == 7 * 200
    assert "7 surfaces" in words_of(figure)[0]


def test_the_tables_of_a_surface_are_read_from_its_folder(tmp_path):
    folder = tmp_path / "p" / "c1"
    folder.mkdir(parents=True)
    written = []
    for name, table in zip(required_dots.Tables._fields[1:], surface_tables()[1:], strict=True):
        written.append(table.assign(**dict.fromkeys(missing_columns(f"{name}.csv", table), 0)))
        written[-1].to_csv(folder / f"{name}.csv", index=False)
    found = required_dots.read(folder)
    assert found.name == "p/c1"
    for table, wanted in zip(found[1:], written, strict=True):
        pd.testing.assert_frame_equal(table, wanted.reset_index(drop=True))
    assert required_dots.read(folder, sampled=False).grid is None  # that of an earlier study


def test_the_answer_shows_its_interval():
    tables = surface_tables(rows=0)
    ends = {"n_S_percent_low": 6.04, "n_S_percent_high": 11.6}
    figure = required_dots.figure([tables._replace(required_dots=tables.required_dots.assign(**ends))])
    (ax,) = figure.axes
    assert ax.get_title() == "8 % of the dots are enough (6 to 12 %)"
    assert ax.collections[-1].get_segments()[0].tolist() == [[6.04, 0.5], [11.6, 0.5]]
    assert "enough, bar: 95 % interval" in names_in(figure)


def test_without_a_grid_there_is_no_cloud():
    figure = required_dots.figure([surface_tables(rows=0)])
    ax = figure.axes[0]
    assert not any(len(each.get_offsets()) for each in ax.collections) and len(curves_in(ax)) == 3
    assert not [words for words in names_in(figure) if "sampling" in words]
    assert ax.get_xlim()[0] == 0.9 and ax.get_title() == "8 % of the dots are enough"
    both = required_dots.figure([surface_tables("p/c1", rows=0), surface_tables("p/c2", rows=0)])
    assert not [words for words in names_in(both) if "sampling" in words]
