"""The figure of how many dots are enough shows its tables: one surface, a few side by side, the median of many."""

import numpy as np
import pandas as pd
import pytest
from test_figures import surface_tables

from drawn import colour_of, legend_of, words_of
from sparsurf.columns import missing_columns
from sparsurf.report.figures import required_dots
from sparsurf.report.numbers import share

COLOURS = {
    ("farthest", "full"): "#56B4E9",
    ("farthest", "recovered"): "#0072B2",
    ("uniform", "full"): "#000000",
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
    np.testing.assert_array_equal(ax.collections[0].get_offsets(), tables.grid[["n_S_percent", "Z_tS_full"]])
    drawn = curves_in(ax)
    for key, rows in tables.curves.groupby(["sampler", "reading"]):
        np.testing.assert_array_equal(drawn[COLOURS[key]], rows[["n_S_percent", "Z"]])
    assert len(drawn) == 3 and ax.get_xscale() == "log" and ax.get_ylim()[0] == 0
    floors = {line.get_ydata()[0]: line.get_linewidth() for line in ax.lines if line.is_dashed()}
    assert (
        sorted(floors) == [0.5, 0.9] and max(floors, key=floors.get) == 0.5
    )  # the molecule rotated is not shown
    assert words_of(figure)[0] == "p/c1"
    assert ax.get_title() == "Z near the floor: 8 %"
    ring = next(line for line in ax.lines if len(line.get_xydata()) == 1)
    assert ring.get_xydata().tolist() == [[8.0, 0.5]]
    assert names_in(figure) == [
        "paper's sampling, all combinations, on the full surface", "farthest point dots as they are",
        "the surface recovered from the same dots", "uniform subset", "near the floor",
        "atoms moved 0.1 Å: 0.90", "fresh dots of the same surface: 0.50",
    ]  # fmt: skip
    floors = figure.legends[0].legend_handles[5:]
    drawn = sorted((line for line in ax.lines if line.is_dashed()), key=lambda line: -line.get_ydata()[0])
    for line, entry in zip(drawn, floors, strict=True):
        assert line._dash_pattern == entry._dash_pattern and colour_of(line) == colour_of(entry)
    assert [colour_of(line) for line in drawn] == ["#777777", "#000000"]


def test_the_combinations_kept_have_their_own_panel():
    """Beside their uniform subsets; the mean patch is shown for both readings."""
    tables = surface_tables()
    grid = tables.grid.assign(Z_tS_kept=tables.grid["Z_tS_full"] + 7.0)
    d = np.where(np.arange(len(grid)) < 30, 1.0, -2.0)
    grid = grid.assign(d_kept=d, Z_tR_kept=grid["Z_tS_kept"] + d, d_full=-d)
    tables = tables._replace(grid=grid, mean_patch=1.7)
    figure = required_dots.figure([tables])
    written, coded = figure.axes
    for cloud, column in (
        (written.collections[0], "Z_tS_full"),
        (coded.collections[0], "Z_tR_kept"),
        (coded.collections[1], "Z_tS_kept"),
    ):
        np.testing.assert_array_equal(cloud.get_offsets(), grid[["n_S_percent", column]])
    assert (
        coded.get_title()
        == "among the kept dots (another scale)\n30 of 200 beat uniform dots\nall are worse than the mean patch"
    )
    assert [text.get_text() for text in written.texts] == [
        "on the full surface: 170 of 200 beat uniform dots"
    ]
    high = tables._replace(mean_patch=grid["Z_tS_kept"].median())
    n = grid["n_S_percent"][np.minimum(grid["Z_tS_kept"], grid["Z_tR_kept"]) < high.mean_patch].min()
    title = required_dots.figure([high]).axes[1].get_title()
    assert title.endswith(f"\nbelow {share(n)} % worse than the mean patch")
    assert [ax.get_ylabel()[-10:] for ax in (written, coded)] == [
        "on the full surface",
        ", among the kept dots",
    ]
    assert coded.get_xlim() == written.get_xlim()
    assert curves_in(coded) == {} and coded.get_ylim()[1] > grid["Z_tR_kept"].max()
    floors = [sorted(line.get_ydata()[0] for line in ax.lines if line.is_dashed()) for ax in figure.axes]
    assert floors == [[0.5, 0.9, 1.7], [0.5, 1.7]]
    assert names_in(figure)[-1] == "the mean patch in place of every patch: 1.70"


def test_a_grid_of_another_reading_has_no_cloud():
    tables = surface_tables()
    tables = tables._replace(grid=tables.grid.drop(columns="Z_tS_full"))
    figure = required_dots.figure([tables])
    assert len(figure.axes[0].collections[0].get_offsets()) == 0
    assert not any("combinations" in words for words in names_in(figure))


def test_the_answer_is_that_of_the_floor_that_is_requested():
    tables = surface_tables()
    other = tables.required_dots.assign(n_S_percent=[8.0, 3.0, 1.4], Z=[0.5, 0.7, 0.9])
    wrong = other.assign(reading="full", n_S_percent=60.0)
    tables = tables._replace(required_dots=pd.concat([wrong, other]))
    for floor, words in (("turned", "3 %"), ("atoms moved 0.1 Å", "1.4 %")):
        ax = required_dots.figure([tables], floor).axes[0]
        assert f"Z near the floor: {words}" == ax.get_title()
    shown = tables.grid.assign(Z_tS_kept=7.0)
    ax = required_dots.figure([tables._replace(grid=shown)], reading="kept").axes[0]
    assert (ax.collections[0].get_offsets()[:, 1] == 7).all()


def test_a_few_surfaces_have_a_panel_each_on_one_scale():
    few = [surface_tables(f"p/c{k}", 1 + k / 10) for k in range(5)]
    axes = required_dots.figure(few).axes
    assert len(axes) == 5 and len({ax.get_ylim() for ax in axes}) == 1
    for ax, tables in zip(axes, few, strict=True):
        assert ax.get_title() == f"{tables.name}\nZ near the floor: 8 %"
        own = tables.curves[(tables.curves["sampler"] == "uniform")]
        np.testing.assert_array_equal(curves_in(ax)["#000000"], own[["n_S_percent", "Z"]])
        ring = next(line for line in ax.lines if len(line.get_xydata()) == 1)
        assert (
            ring.get_xydata().tolist()
            == tables.required_dots[["n_S_percent", "Z"]].iloc[:1].to_numpy().tolist()
        )


def test_few_noise_floors_are_drawn():
    """The closest frames, the atoms that moved farthest, and the one that defines what is enough."""
    names = [
        "frames 100 ps apart",
        "atoms moved 0.3 Å",
        "frames 2 ps apart",
        "turned",
        "atoms moved 0.1 Å",
        "fresh dots",
    ]
    floors = pd.DataFrame({"floor": names, "Z": [1.4, 1.2, 1.1, 0.9, 0.7, 0.5]})
    two = [surface_tables(f"{name}/c1")._replace(floors=floors) for name in "pq"]
    two[0] = two[0]._replace(floors=floors[3:])  # a single structure has no frames
    moved = two[0].required_dots.assign(floor="atoms moved 0.1 Å")
    two = [tables._replace(required_dots=pd.concat([tables.required_dots, moved])) for tables in two]
    for floor, drawn in (
        ("fresh dots", [[0.5], [1.2, 1.1, 0.5]]),
        ("atoms moved 0.1 Å", [[0.7], [1.2, 1.1, 0.7]]),
    ):
        figure = required_dots.figure(two, floor)
        for ax, wanted in zip(figure.axes, drawn, strict=True):
            assert (
                sorted((line.get_ydata()[0] for line in ax.lines if line.is_dashed()), reverse=True) == wanted
            )
        assert [ax.get_title().split("\n")[0] for ax in figure.axes] == ["p", "q"]
    assert [handle.get_label() for handle in figure.legends[0].legend_handles][-3:] == [
        "atoms moved 0.3 Å",
        "frames 2 ps apart",
        "atoms moved 0.1 Å",
    ]


def test_four_surfaces_stand_two_by_two():
    axes = required_dots.figure([surface_tables(f"p/c{k}") for k in range(4)]).axes
    corners = [ax.get_position().p0.round(3) for ax in axes]
    assert corners[0][0] == corners[2][0] < corners[1][0] == corners[3][0]
    assert corners[0][1] == corners[1][1] > corners[2][1] == corners[3][1]


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
    assert (at.min(), at.max()) == pytest.approx(np.quantile(factors, [0.1, 0.9]) * middle)
    floors = [line.get_ydata()[0] for line in ax.lines if line.is_dashed()]
    assert max(floors) < 1.5 and np.isclose(floors, 0.55).any()  # `alone` is known of one surface only
    assert len(ax.collections[0].get_offsets()) == 7 * 200
    assert "7 surfaces" in words_of(figure)[0]


def test_the_tables_of_a_surface_are_read_from_its_folder(tmp_path):
    folder = tmp_path / "p" / "c1"
    folder.mkdir(parents=True)
    written = []
    for name, table in zip(required_dots.Tables._fields[1:5], surface_tables()[1:5], strict=True):
        written.append(table.assign(**dict.fromkeys(missing_columns(f"{name}.csv", table), 0)))
        written[-1].to_csv(folder / f"{name}.csv", index=False)
    found = required_dots.read(folder)
    assert found.name == "p/c1"
    for table, wanted in zip(found[1:5], written, strict=True):
        pd.testing.assert_frame_equal(table, wanted.reset_index(drop=True))
    assert required_dots.read(folder, sampled=False).grid is None  # that of an earlier study


def test_the_answer_shows_its_interval():
    tables = surface_tables(rows=0)
    ends = {"n_S_percent_low": 6.04, "n_S_percent_high": 11.6}
    figure = required_dots.figure([tables._replace(required_dots=tables.required_dots.assign(**ends))])
    (ax,) = figure.axes
    assert ax.get_title() == "Z near the floor: 8 % (6 to 12 %)"
    assert ax.collections[-1].get_segments()[0].tolist() == [[6.04, 0.5], [11.6, 0.5]]
    assert "near the floor, bar: 95 % interval" in names_in(figure)


def test_without_a_grid_there_is_no_cloud():
    figure = required_dots.figure([surface_tables(rows=0)])
    ax = figure.axes[0]
    assert not any(len(each.get_offsets()) for each in ax.collections) and len(curves_in(ax)) == 3
    assert not [words for words in names_in(figure) if "sampling" in words]
    assert ax.get_xlim()[0] == 0.9 and ax.get_title() == "Z near the floor: 8 %"
    both = required_dots.figure([surface_tables("p/c1", rows=0), surface_tables("p/c2", rows=0)])
    assert not [words for words in names_in(both) if "sampling" in words]


def test_medians_end_where_fewer_than_half_of_the_surfaces_were_measured():
    none = (np.array([]), np.array([]))
    key = ("farthest", "full")
    panels = {
        name: required_dots.Panel(none, {key: (np.array([1.0, end]), np.array([4.0, 2.0]))}, {}, (5.0, 1.0))
        for name, end in (("a", 10.0), ("b", 40.0), ("c", 40.0))
    }
    n, *_ = required_dots.median_panel(panels).lines[key]
    assert n.min() >= 1 and 30 < n.max() <= 40
