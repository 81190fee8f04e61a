"""The figures of one surface show what they are given: subsets, distances, grids, frames, and the book of two partners."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from matplotlib import colormaps
from matplotlib.cbook import boxplot_stats
from matplotlib.colors import to_hex
from test_figures import distances, grid, patch, sphere

import draw_figures
import draw_frames
from conftest import make_blob
from drawn import colour_of, legend_of, words_of
from sparsurf.recovery.readings import READINGS
from sparsurf.report.figures import (
    d_over_grid,
    frames,
    layout,
    number_of_dots,
    pair_figures,
    render,
    results,
    rough_and_flat,
    roughness,
    subsets,
)
from sparsurf.sampling.combination import Combination
from sparsurf.study.prepared_surface import prepare_surface
from sparsurf.study.rough_and_flat import by_roughness
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.surface import Surface

VERMILLION, BLUE, GREY = "#D55E00", "#0072B2", "#4D4D4D"
BLACK, BOX = "#000000", "#A0A0A0"  # of uniform dots and of their boxes


def pictures(figure):
    """The rendered pictures, (R, C, 3) int each."""
    return [np.asarray(ax.images[0].get_array(), int) for ax in figure.axes if ax.images]


def share_of(picture, name):
    """Share of the pixels that have the hue of a colour."""
    return of_hue(picture, name).mean()


def of_hue(picture, name):
    """Pixels that have the hue of a colour, whatever the lamp does to it."""
    wanted = np.array([int(name[k : k + 2], 16) for k in (1, 3, 5)], float)
    coloured = np.ptp(picture, axis=2) > 50
    hue = picture - picture.min(axis=2, keepdims=True)
    wanted -= wanted.min()
    cosine = (hue @ wanted) / (np.linalg.norm(hue, axis=2) * np.linalg.norm(wanted) + 1e-9)
    return coloured & (cosine > 0.97)


# ---- the frames of a trajectory


def test_frames_are_coloured_by_cluster_and_the_chosen_ones_ringed():
    plane = np.array([[0.0, 0, 9], [1, 1, 9], [20, 0, 9], [21, 1, 9], [0, 20, 9]])
    labels, chosen = np.array([3, 3, 5, 5, 9]), [1, 2]
    shares = [0.5, 0.3, 0.1, 0.06]
    figure = frames.frames_projection(
        plane, labels, chosen, ["c1", "c2"], shares, {2: 0.4, 3: 0.6, 4: 0.5}, "p"
    )
    assert words_of(figure)[0] == "p: 2 of 5 frames chosen"
    ax, explained, silhouette = figure.axes
    every, ringed = ax.collections
    np.testing.assert_array_equal(every.get_offsets(), plane[:, :2])
    np.testing.assert_array_equal(ringed.get_offsets(), plane[chosen, :2])
    colours = [to_hex(c).upper() for c in every.get_facecolors()]
    assert colours == [layout.PALETTE[k] for k in (0, 0, 1, 1, 2)]
    assert [to_hex(c).upper() for c in ringed.get_facecolors()] == layout.PALETTE[:2]
    assert (ax.get_xlabel(), ax.get_ylabel()) == (
        "PC 1 (Å), 50 % of the variance", "PC 2 (Å), 30 % of the variance",
    )  # fmt: skip
    assert {t.get_text(): tuple(t.xy) for t in ax.texts} == {"c1": (1, 1), "c2": (20, 0)}
    assert [bar.get_height() for bar in explained.patches] == [50, 30, 10, 6]
    middles = [bar.get_x() + bar.get_width() / 2 for bar in explained.patches]
    np.testing.assert_allclose(middles, [1, 2, 3, 4])
    np.testing.assert_allclose(explained.lines[0].get_xydata(), [[1, 50], [2, 80], [3, 90], [4, 96]])
    assert len({to_hex(bar.get_facecolor()) for bar in explained.patches[:2]}) == 1
    assert to_hex(explained.patches[1].get_facecolor()) != to_hex(explained.patches[2].get_facecolor())
    assert silhouette.lines[0].get_xydata().tolist() == [[2, 0.4], [3, 0.6], [4, 0.5]]
    assert silhouette.lines[1].get_xydata().tolist() == [[3, 0.6]]  # as many clusters as there are labels
    assert silhouette.get_title() == "K = 3 chosen"


def test_many_conformations_are_not_named():
    plane = np.random.default_rng(0).normal(size=(60, 2))
    for n in (frames.MAX_NAMED, frames.MAX_NAMED + 1):
        names = [f"c{k}" for k in range(n)]
        ax = frames.frames_projection(plane, np.zeros(60, int), range(n), names, [], {}).axes[0]
        assert (len(ax.texts) > 0) == (n == frames.MAX_NAMED)


def test_chosen_frames_are_found_by_their_numbers(tmp_path, monkeypatch):
    tables = {
        "projection": {
            "frame": [0, 10, 20],
            "pc1": [1.0, 2.0, 3.0],
            "pc2": [4.0, 5.0, 6.0],
            "cluster": [0, 0, 1],
        },
        "frames": {"conformation": ["c1", "c2"], "frame": [10, 20]},
        "explained": {"explained": [0.7, 0.3]},
        "silhouette": {"K": [2], "silhouette": [0.5]},
    }
    for name, columns in tables.items():
        pd.DataFrame(columns).to_csv(tmp_path / f"{name}.csv", index=False)
    seen = []
    monkeypatch.setattr(draw_frames, "frames_projection", lambda *given: seen.extend(given))
    monkeypatch.setattr(draw_frames.layout, "save", lambda *_: None)
    draw_frames.main(**{name: tmp_path / f"{name}.csv" for name in tables}, png="frames.png", name="p")
    assert [np.asarray(each).tolist() for each in seen[:5]] == [
        [[1, 4], [2, 5], [3, 6]], [0, 0, 1], [1, 2], ["c1", "c2"], [0.7, 0.3]
    ]  # fmt: skip
    assert seen[5:] == [{2: 0.5}, "p"]


def test_frames_that_are_all_the_same_have_no_axes():
    for plane in ([[0.0]], np.zeros((3, 2))):
        figure = frames.frames_projection(plane, [0] * len(plane), [0], ["c1"], [0.0], {1: np.nan}, "p")
        assert not figure.axes
        words = [text.get_text() for text in figure.texts]
        assert words == ["p", "All frames are the same."]
    two = frames.frames_projection(np.eye(2), [0, 0], [0], ["c1"], [1.0], {1: np.nan})
    assert len(two.axes) == 2  # one cluster has no silhouette


# ---- the grid


def test_tiles_place_data_as_axes_of_their_own_would():
    figure = layout.sheet(100, 80)
    tiles = layout.Tiles(figure, 10, 5, (2, 3), (20, 15), (4, 6), (-1, 3), (0, 50))
    for row, column in ((0, 0), (1, 2)):
        own = layout.axes(figure, 10 + 24 * column, 5 + 21 * row, 20, 15)
        own.set(xlim=(-1, 3), ylim=(0, 50))
        points = np.array([[-1.0, 0], [3, 50], [0.5, 20]])
        there = tiles.ax.transData.transform(tiles.places(row, column, *points.T))
        np.testing.assert_allclose(there, own.transData.transform(points), atol=1e-6)
        left, right, bottom, top = tiles.extent(row, column)
        box = tiles.ax.transData.transform([(left, bottom), (right, top)])
        np.testing.assert_allclose(box, own.get_window_extent().get_points(), atol=1e-6)
    tiles.ticks(np.array([0, 1, 2]), np.array([0, 50]))
    shown = {text.get_text(): tiles.ax.transData.transform(text.get_position()) for text in tiles.ax.texts}
    middle = tiles.ax.transData.transform(tiles.places(1, 2, [2.0], [0.0]))[0]
    assert shown["2"][0] == pytest.approx(middle[0]) and shown["2"][1] < middle[1]
    assert len(tiles.ax.texts) == 3 * 3 + 2 * 2


def test_the_n_s_that_is_expected_of_a_single_delta_is_a_dash():
    figure = number_of_dots.figure(grid(delta=[2]))
    expected, drawn = figure.axes[0].lines[:2]
    assert (expected.get_marker(), drawn.get_marker()) == ("_", "o")


def test_every_panel_shows_the_n_s_of_its_alpha_and_beta(monkeypatch):
    table, placed = grid().sample(frac=1, random_state=0), []
    places = layout.Tiles.places

    def note(self, row, column, x, y):
        placed.append((row, column, np.column_stack([x, y])))
        return places(self, row, column, x, y)

    monkeypatch.setattr(layout.Tiles, "places", note)
    figure = number_of_dots.figure(table)
    ax = figure.axes[0]
    cells = [(a, b, g) for g in (0, 2, 10) for a in (0.2, 1) for b in (0, 0.4, 1)]
    for k, (alpha, beta, gamma) in enumerate(cells):
        own = table[(table.alpha == alpha) & (table.beta == beta) & (table.gamma == gamma)]
        own = own.sort_values("delta")
        expected, drawn = placed[2 * k : 2 * k + 2]
        assert expected[:2] == drawn[:2] == ([0.2, 1].index(alpha), [0, 0.4, 1].index(beta))
        np.testing.assert_allclose(expected[2], own[["delta", "n_S_expected"]] / [1, 10])
        np.testing.assert_allclose(drawn[2], own[["delta", "n_S_percent"]])
    shades = [to_hex(c).upper() for c in colormaps["viridis"](np.linspace(0, 0.92, 3))]
    assert [colour_of(line) for line in ax.lines] == np.repeat(shades, 2).tolist()
    assert (
        len(ax.lines[0].get_xydata()) == 6 * 4 and len(ax.lines[1].get_xydata()) == 6 * 3
    )  # a break after each
    assert legend_of(figure)[:3] == [(f"γ = {g}", shade) for g, shade in zip((0, 2, 10), shades, strict=True)]


def test_maps_of_d_show_the_values_at_their_gamma_and_delta():
    table = grid(beta=[0, 1], gamma=[0, 2, 10], delta=[0, 5, 10])
    figure = d_over_grid.figure(table)
    part = table[table.alpha == 1]
    rows = [ax for ax in figure.axes if ax.images]
    for ax, reading in zip(rows, ("kept", "full"), strict=True):
        stars = [line for line in ax.lines if line.get_marker() in "o*"]
        whole = part.loc[part[f"d_{reading}"].idxmax()]
        for image, star, beta in zip(ax.images, stars, (0, 1), strict=True):
            values, (left, right, bottom, top) = np.asarray(image.get_array()), image.get_extent()
            own = part[part.beta == beta]
            for row in own.itertuples():
                assert values[round(row.gamma * 10), round(row.delta * 10)] == pytest.approx(
                    getattr(row, f"d_{reading}")
                )
            best = own.loc[own[f"d_{reading}"].idxmax()]
            place = left + (right - left) * best.delta / 10, bottom + (top - bottom) * best.gamma / 10
            np.testing.assert_allclose(star.get_xydata(), [place])
            assert star.get_marker() == ("*" if whole.beta == beta else "o") and image.origin == "lower"
        assert [t.get_text() for t in ax.texts if t.get_text().startswith("β")] == ["β = 0", "β = 1"]
        assert ax.images[0].get_extent()[1] < ax.images[1].get_extent()[0]
    # one scale for both readings, in which signs mix: white at 0
    both = [row.images[0] for row in rows]
    assert {image.cmap.name for image in both} == {"RdBu_r"} and both[0].norm is both[1].norm
    largest = part[["d_kept", "d_full"]].abs().to_numpy().max()
    assert both[0].norm.vmin == -both[0].norm.vmax and both[0].norm.vmax == pytest.approx(largest)
    head, *said = [words for words in words_of(figure) if len(words) > 1]
    better = [(part[f"d_low_{r}"] > 0).sum() for r in ("kept", "full")]
    assert (
        head
        == f"{better[0]} of {len(part)} with α = 1 beat a uniform subset among the kept dots, {better[1]} on the full surface"
    )
    for words, reading in zip(said, ("kept", "full"), strict=True):
        top = part.loc[part[f"d_{reading}"].idxmax()]
        assert words.startswith(READINGS[reading].words) and f"γ = {top.gamma:g}, δ = {top.delta:g}" in words
        value, low, high = (f"{top[f'd_{end}{reading}']:.2f}" for end in ("", "low_", "high_"))
        assert f"{value} ({low} to {high})".replace("-", "−") in words


# ---- rough and flat


def test_boxes_show_the_bins_of_roughness():
    r, z = distances(500)
    references = {"Z_empty": 80.6, "Z_mean_descriptor": 6.5, "floors": {"fresh dots": 0.5}}
    figure = rough_and_flat.figure([("any dots", r, z[0], z[1])], [patch()], references, bins=5)
    ax = figure.axes[-1]
    edges = np.linspace(r.min(), r.max(), 6)
    chosen = {k: np.flatnonzero(np.digitize(r, edges[1:-1]) == k) for k in range(5)}
    n = [len(dots) for dots in chosen.values()]
    assert f"any dots\n{min(n)} to {max(n)} patches a bin" in words_of(figure)
    for side, values, colour in ((0, z[0], VERMILLION), (1, z[1], BOX)):
        bars, (middles, stems, _) = ax.containers[side].patches, ax.collections[3 * side : 3 * side + 3]
        wanted = [np.quantile(values[chosen[k]], [0.25, 0.5, 0.75]) for k in range(5)]
        np.testing.assert_allclose(
            [(bar.get_y(), bar.get_y() + bar.get_height()) for bar in bars], np.array(wanted)[:, [0, 2]]
        )
        np.testing.assert_allclose([line[0, 1] for line in middles.get_segments()], np.array(wanted)[:, 1])
        for k, bar in enumerate(bars):
            middle = bar.get_x() + bar.get_width() / 2
            assert edges[k] < middle < edges[k + 1] and (middle < edges[k : k + 2].mean()) == (side == 0)
            assert to_hex(bar.get_facecolor()).upper() == colour
        beyond = ax.lines[side].get_ydata()
        of_matplotlib = boxplot_stats(
            [values[chosen[k]] for k in range(5)]
        )  # an oracle for whiskers and outliers
        np.testing.assert_allclose(
            np.sort(beyond), np.sort(np.concatenate([b["fliers"] for b in of_matplotlib]))
        )
        lows, highs = (segments[:, :, 1] for segments in np.split(np.array(stems.get_segments()), 2))
        np.testing.assert_allclose(lows, [(b["whislo"], b["q1"]) for b in of_matplotlib])
        np.testing.assert_allclose(highs, [(b["q3"], b["whishi"]) for b in of_matplotlib])
    np.testing.assert_allclose(ax.get_xticks(), edges)
    said = [words for words, _ in legend_of(figure)]
    assert said == [
        "$Z_{tS}(j)$, sampled",
        "$Z_{tR}(j)$, uniform",
        "mean patch for all, 6.50",
        "fresh dots, 0.50",
    ]
    assert [c for _, c in legend_of(figure)][:2] == [VERMILLION, BOX]


def test_few_values_are_drawn_as_they_are():
    r, z = distances(7)
    figure = rough_and_flat.figure([("t", r, z[0], z[1])], [patch()], bins=2)
    ax = figure.axes[-1]
    dots = [line for line in ax.lines if line.get_marker() == "o"]
    assert len(dots) == 2
    order = np.argsort(r > (r.min() + r.max()) / 2, kind="stable")  # bin by bin
    for line, values, colour in zip(dots, z, (VERMILLION, BOX), strict=False):
        np.testing.assert_allclose(line.get_ydata(), values[order])
        assert colour_of(line) == colour


def test_a_patch_is_shown_whole_sampled_and_uniform():
    r, z = distances(50)
    figure = rough_and_flat.figure([("t", r, z[0], z[1])], [patch()])
    titles = [(ax.get_title(), to_hex(ax.title.get_color()).upper()) for ax in figure.axes[:3]]
    assert titles == [("whole\n60 dots", GREY), ("sampled\n30 dots", VERMILLION), ("uniform\n20 dots", BLACK)]
    _, sampled, random = pictures(figure)
    dark = [(picture < 40).all(axis=2).mean() for picture in (sampled, random)]
    assert share_of(sampled, VERMILLION) > 1.2 * (dark[1] - dark[0]) > 0 == share_of(random, VERMILLION)


# ---- surfaces


def test_the_surface_has_the_colours_of_the_histogram():
    order = np.random.default_rng(0).permutation(2000)
    points, normals = (each[order] for each in sphere(2000))
    rough = np.where(points[:, 0] < 2, 0.2, 0.88) + np.linspace(0, 0.01, 2000)
    figure = roughness.figure(points, normals, rough)
    _, bar, histogram = figure.axes
    counts, edges = np.histogram(rough, 50)
    assert [p.get_height() for p in histogram.patches] == counts.tolist()
    np.testing.assert_allclose([p.get_x() for p in histogram.patches], edges[:-1])
    assert histogram.lines[0].get_xdata()[0] == pytest.approx(rough.mean())
    assert histogram.texts[0].get_text() == f"mean {rough.mean():.2f}"
    low, high = render.ROUGHNESS_LIMITS
    assert bar.get_ylim() == pytest.approx((low, high))  # whatever the surface
    middles = (edges[[0, 25, 49]] + edges[[1, 26, 50]]) / 2
    wanted = colormaps["viridis"](np.clip((middles - low) / (high - low), 0, 1))
    shown = [histogram.patches[k].get_facecolor() for k in (0, 25, 49)]
    np.testing.assert_allclose(shown, wanted)
    image = pictures(figure)[0]
    ink = np.ptp(image, axis=2) > 30
    rows, columns = np.nonzero(ink)
    yellow = image[rows, columns, 0] > image[rows, columns, 2] + 60
    # the view may be mirrored, but one side is dark and the other bright
    assert 0.2 < yellow.mean() < 0.7
    assert abs(columns[yellow].mean() - columns[~yellow].mean()) > 0.25 * np.ptp(columns)


def test_every_subset_stands_in_its_cell_with_its_number_and_colour():
    points, normals = sphere(900)
    whole = Surface(points, normals)
    kept = [slice(0, None, 2), slice(1, None, 6), slice(0, None, 12)]
    colours, names = (VERMILLION, BLUE, "#009E73"), ("best", "uniform", "minimal")
    cells = [(n, Surface(points[k], normals[k]), c) for n, k, c in zip(names, kept, colours, strict=True)]
    distance = np.where(points[:, 0] < 0, 0.001, 0.3) + np.arange(900) / 1e5
    figure = subsets.figure(whole, cells, ("back", whole, distance), "p/c1")
    said = {text.get_text().split("\n")[0]: text for text in figure.texts}
    for name, subset, colour in cells:
        assert said[name].get_text() == f"{name}\n{len(subset)} dots, {len(subset) / 9:.3g} %"
        assert to_hex(said[name].get_color()).upper() == colour
    places = {name: said[name].get_position() for name in ("the surface", *names, "back")}
    assert places["the surface"][0] == places["minimal"][0] < places["best"][0] == places["back"][0]
    assert places["best"][1] == places["uniform"][1] > places["minimal"][1] == places["back"][1]
    _, *drawn, back = pictures(figure)
    for picture, colour in zip(drawn, colours, strict=True):
        others = set(colours) - {colour}
        assert share_of(picture, colour) > 0 == max(share_of(picture, other) for other in others)
    assert share_of(drawn[0], VERMILLION) > 1.5 * share_of(drawn[1], BLUE)
    assert share_of(back, "#440154") > 0.02 and share_of(back, "#FDE725") > 0.02
    *_, histogram = figure.axes
    counts = [bar.get_height() for bar in histogram.patches]
    assert sum(counts) == 900 and counts[-1] == (distance >= subsets.MAX_DISTANCE * 39.5 / 40).sum()
    assert histogram.lines[0].get_xdata()[0] == pytest.approx(distance.mean())
    assert [w for w in words_of(figure) if len(w) == 1] == list("ABCDEF")
    assert words_of(figure)[0] == "p/c1: 75 dots recover the surface to 0.16 Å on average"
    without = subsets.figure(whole, cells)
    assert [w for w in words_of(without) if len(w) == 1] == list("ABCD") and len(pictures(without)) == 4


# ---- the book of two partners


def plates(distance=2.0):
    """Two plates that face each other, 20 x 10 Å; the second looks down on the first."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(0.0, 10, 0.5), np.arange(0.0, 20, 0.5)))
    up = np.tile([0.0, 0, 1], (len(x), 1))
    lower = Surface(np.column_stack([x, y, 0 * x]), up)
    return lower, Surface(np.column_stack([x, y, 0 * x + distance]), -up)


def agreement(*limits):
    """agreement.csv of the smoothed map and a baseline, by the limits of the AUC of each partner."""
    rows = [
        {
            "partner": side,
            "score": "propensity_smoothed",
            "auc": np.nan_to_num(low + high) / 2,
            "low": low,
            "high": high,
            "blocks": 9,
        }
        for side, (low, high) in enumerate(limits, 1)
    ]
    table = pd.DataFrame(rows, columns=["partner", "score", "auc", "low", "high", "blocks"])
    return pd.concat([table, table.assign(score="protrusion")])


def tables(surfaces, touching=True):
    """propensity.csv of each partner: low where y is small, and an interface there."""
    out = []
    for k, surface in enumerate(surfaces):
        y = surface.points[:, 1]
        table = pd.DataFrame({"propensity_smoothed": y + 20 * k, "similarity_smoothed": 100 - y})
        out.append(table.assign(interface=((y < 5) & touching).astype(int)))
    return out


def test_the_book_shows_propensity_above_the_interface():
    surfaces = plates()
    both = tables(surfaces)
    figure = pair_figures.book_figure("x", surfaces, both, agreement((0.5, 0.9), (0.1, 0.4)))
    bar = figure.axes[2]
    assert bar.get_ylim() == pytest.approx((0, 100)) and bar.get_ylabel().startswith("rank of the smoothed")
    assert pair_figures.ranks(pd.Series([3.0, 9.0, 3.0, 1.0])).tolist() == [62.5, 100, 62.5, 25]
    first, second, left, right = pictures(figure)
    blue, yellow = "#440154", "#FDE725"
    # each partner has the whole scale, though all values of the second are higher; good matches lie at the interface
    for page, below in ((first, left), (second, right)):
        good, poor, touching = (
            np.argwhere(of_hue(*each)).mean(axis=0)
            for each in ((page, blue), (page, yellow), (below, VERMILLION))
        )
        assert np.linalg.norm(good - touching) < 0.5 * np.linalg.norm(poor - touching)
    for page in (left, right):
        ink = (page < 250).any(axis=2)
        assert share_of(page, VERMILLION) / ink.mean() == pytest.approx(0.25, abs=0.03)  # y < 5 of 20
    # what touches lies at the same height, equally far from the hinge
    (row, column), (other_row, other) = (
        np.argwhere(np.ptp(p, axis=2) > 50).mean(axis=0) for p in (left, right)
    )
    assert row == pytest.approx(other_row, abs=2) and column == pytest.approx(
        left.shape[1] - 1 - other, abs=2
    )
    assert abs(column - other) > 50
    assert words_of(figure)[:3] == [
        "x: matching patches do not mark the interface, and lie away from it on partner 2",
        "partner 1, seen from partner 2: AUC 0.70 (0.50 to 0.90)",
        "partner 2, seen from partner 1: AUC 0.25 (0.10 to 0.40)",
    ]
    assert "interface: dots\nclose to the\nother partner" in words_of(figure)


def test_the_title_of_a_pair_says_where_matching_patches_lie():
    for places, words in (
        (("above", "above"), "matching patches lie at the interface"),
        (("around", "above"), "matching patches lie at the interface of partner 2 only"),
        (("above", "below"), "matching patches lie at the interface of partner 1 only"),
        (("below", "below"), "matching patches lie away from the interface"),
        (
            ("below", "around"),
            "matching patches do not mark the interface, and lie away from it on partner 1",
        ),
        (("unknown", "unknown"), "matching patches do not mark the interface"),
        ((), ""),
    ):
        assert pair_figures.where_matches_lie(dict(enumerate(places, 1))) == words


def test_the_book_of_partners_apart_shows_the_similarity():
    surfaces = plates(60.0)
    figure = pair_figures.book_figure("x", surfaces, tables(surfaces, touching=False), agreement())
    bars = [ax for ax in figure.axes if not ax.images]
    assert ["similarity" in ax.get_ylabel() for ax in bars] == [False, True]
    assert bars[1].get_ylim() == (0, 100)
    assert not any("interface" in words for words in words_of(figure))


@pytest.mark.parametrize("larger", [0, 1])
def test_both_pages_have_one_scale(larger):
    both = list(plates())
    small = both[1 - larger]
    both[1 - larger] = Surface(small.points[:100], small.normals[:100])
    figure = pair_figures.book_figure("x", both, tables(both), agreement((0.5, 0.9), (0.1, 0.4)))
    widths = [ax.get_xlim()[1] - ax.get_xlim()[0] for ax in figure.axes if ax.images]
    assert widths == pytest.approx([widths[0]] * 4)
    assert widths[0] > 19.5  # Å: the larger one has room


# ---- what they all share


def test_the_lamp_is_above_on_the_left():
    points, normals = sphere(4000, 8.0)
    points = points / [1.4, 1.0, 0.8]
    camera = render.Camera(np.eye(3), np.zeros(3), 8.0, (160, 160))
    image = render.picture(render.draw_surface(points, normals, render.PALE, camera)).astype(float)[..., 0]
    quarter = {(v, h): image[50 + 45 * v, 50 + 45 * h] for v in (0, 1) for h in (0, 1)}
    assert quarter[0, 0] == max(quarter.values()) and quarter[1, 1] == min(quarter.values())


def test_discs_are_as_large_as_the_gaps_between_most_dots():
    rng = np.random.default_rng(0)
    dense = np.column_stack([rng.uniform(0, 10, (2000, 2)), np.zeros(2000)])
    radius = render.closing_radius(dense)
    eighth = np.sqrt(8 / (np.pi * 20))  # Å, at 20 dots per Å^2, on average
    assert 1.15 * eighth < radius < 2 * eighth
    assert (
        render.closing_radius(100 * dense) == render.MAX_DISC_RADIUS
        and render.closing_radius(dense / 1e3) == render.DOT_RADIUS
    )


def test_hollows_and_the_edge_of_what_lies_in_front_are_dark():
    depth = np.zeros((200, 200))
    depth[90:110, 90:110] = -20.0  # 2 Å deep at 10 pixels per Å
    dark = render._darkness(depth, 10.0)
    assert dark[100, 100] < 0.75 and dark[20, 20] == pytest.approx(1)
    behind = np.zeros((200, 200))
    behind[:, 100:] = -100.0  # a step of 10 Å
    dark = render._darkness(behind, 10.0)
    assert dark[100, 101] < 0.5 * dark[100, 190] and dark[100, 101] < 0.7 * dark[100, 104]
    assert (render._darkness(np.full((4, 4), -np.inf), 10.0) == 1).all()


def test_places_are_millimetres_from_the_upper_left_corner():
    figure = layout.sheet(100, 50)
    box = layout.axes(figure, 10, 5, 40, 20).get_position()
    assert (box.x0, box.x1, box.y0, box.y1) == pytest.approx((0.1, 0.5, 0.5, 0.9))
    assert layout.text(figure, 10, 5, "a").get_position() == pytest.approx((0.1, 0.9))
    assert layout.letter(figure, 10, 5, "a").get_fontweight() == "bold"
    assert layout.pixels(25.4, 50.8) == (400, 200)  # rows, columns at 200 per inch


def test_a_scale_bar_has_the_length_that_it_names():
    for width, wanted in ((30.0, 10), (24.0, 5), (12.0, 2), (4.0, 1)):
        camera = render.Camera(np.eye(3), np.zeros(3), 100 / width, (50, 100))
        ax = layout.axes(layout.sheet(50, 50), 0, 0, 50, 25)
        layout.show(ax, np.zeros((50, 100, 3), np.uint8), camera)
        (line,) = ax.lines
        assert np.ptp(line.get_xdata()) == pytest.approx(wanted) and line.get_xdata()[0] == pytest.approx(
            -width / 2
        )
        assert ax.texts[0].get_text() == f"{wanted} Å"
        assert ax.get_xlim() == pytest.approx((-width / 2, width / 2)) == tuple(ax.images[0].get_extent()[:2])
        assert ax.get_ylim() == pytest.approx((-width / 4, width / 4))


def test_ticks_leave_out_what_has_no_room():
    ax = layout.axes(layout.sheet(50, 50), 0, 0, 50, 50)
    values = np.arange(9)
    for room, shown in ((1000, 1), (12, 2), (9, 3)):  # 2.6 mm each
        layout.ticks(ax.xaxis, values, room)
        assert ax.get_xticks().tolist() == values[::shown].tolist()
        assert [t.get_text() for t in ax.get_xticklabels()] == [f"{v}" for v in values[::shown]]
    layout.ticks(ax.yaxis, np.array([0.1, 0.2, 0.4, 0.6, 1.0]), 18)  # 0.2 lies 2 mm above 0.1
    assert ax.get_yticks().tolist() == [0.1, 0.4, 0.6, 1.0]


def test_a_figure_draws_its_part_of_the_results():
    points, normals = sphere(300)
    rough = np.linspace(0.3, 0.9, 300)
    table = grid().drop(columns="d_kept").assign(d_recovered=-0.001)
    own = results.Results("p/c1", Surface(points, normals), rough, table)
    counts = np.histogram(rough, 50)[0].tolist()
    assert [bar.get_height() for bar in roughness.draw(own).axes[2].patches] == counts
    words = words_of(d_over_grid.draw(own))
    drawn = [name for name in READINGS for w in words if w.startswith(READINGS[name].words)]
    assert drawn == ["full", "recovered"]
    assert any(w.endswith("highest $d$ = 0.00 at β = 0, γ = 0, δ = 0: 100.3 % of the dots") for w in words)
    for module, head in (
        (roughness, "p/c1: mean roughness 0.60"),
        (d_over_grid, "p/c1: 0 of 27 with α = 1 beat a uniform subset on the full surface, 0 recovered"),
        (number_of_dots, "p/c1"),
    ):
        assert words_of(module.draw(own))[0] == head


def test_the_head_of_rough_and_flat_says_where_the_sampling_errs_less():
    roughness_of_patches = np.linspace(0.2, 0.8, 20)
    flat = roughness_of_patches > 0.5
    for gains, expected in (
        ([(1, 1)], "the sampling errs less on rough and flat patches"),
        ([(1, -1), (0.5, -2)], "the sampling errs less on rough patches"),
        ([(-1, -1)], "a uniform subset errs less everywhere"),
        (
            [(1, 1), (-1, -1)],
            "less error than a uniform subset among the kept dots, more on the full surface",
        ),
        ([(1, 1), (-2, 3)], "whether the sampling errs less depends on the roughness"),
    ):
        panels = [
            (f"t, {words}", roughness_of_patches, np.full(20, 3.0), 3 + np.where(flat, on_flat, on_rough))
            for words, (on_rough, on_flat) in zip(
                ("among the kept dots", "on the full surface"), gains, strict=False
            )
        ]
        assert rough_and_flat.message(panels) == expected


def test_the_rough_patch_is_rougher_than_the_flat_one_and_few_dots_lie_where_it_is_rough(
    tmp_path, monkeypatch
):
    surface = Surface(*make_blob(1500))
    patches = {"R_patch": 4.0, "R_zernike": 6.0, "D_link": 1.1}
    prepared = prepare_surface(surface, patches, None, 1, "p/c1")
    unrestricted = {"alpha": 1, "beta": 0, "gamma": 6, "delta": 0}
    other = unrestricted | {"gamma": 0}  # of another reading: not what is drawn
    best = {
        "recovered": {"unrestricted": other},
        "kept": {"unrestricted": unrestricted},
        "references": {},
        "combinations": 1,
    }
    tables = ("grid", "curves", "floors", "required_dots")
    inputs = {name: str(tmp_path / name) for name in ("surface", "roughness", "best", "minimal", *tables)}
    write_npz(inputs["surface"], surface)
    pd.DataFrame({"roughness": prepared.roughness}).to_csv(inputs["roughness"], index=False)
    for k, name in enumerate(tables):
        pd.DataFrame({name: [float(k)], "sampler": "farthest"}).to_csv(inputs[name], index=False)
    handed_out = pd.DataFrame(surface.points[::5] + 0.125, columns=list("xyz"))
    handed_out[["nx", "ny", "nz"]] = surface.normals[::5]
    handed_out.assign(weight=5).to_csv(inputs["minimal"], index=False)
    Path(inputs["best"]).write_text(json.dumps(best))
    shown = []
    monkeypatch.setattr(draw_figures, "DRAWS", 2)
    monkeypatch.setattr(draw_figures, "recover", lambda points, normals, density, threads: (points, normals))
    monkeypatch.setattr(draw_figures, "FIGURES", {"subsets": SimpleNamespace(draw=shown.append)})
    monkeypatch.setattr(draw_figures.layout, "save", lambda *_: None)
    for own, words in (
        ({"sampler": "farthest", "floor": "turned"}, "farthest point"),
        ({"sampler": "paper", "combination": [1, 0, 6, 0]}, "paper's sampling"),
    ):
        draw_figures.main(
            **inputs,
            figures=["subsets.png"],
            bins=str(tmp_path / "bins.csv"),
            patches=patches,
            distance_from_moved_centre=True,
            chance_in_every_patch=True,
            test_dots=2,
            minimal_settings=own,
            seed=1,
            name="p/c1",
        )
        assert shown[-1].subsets[-1][0] == f"minimal.csv, {words}"
    for k, name in enumerate(tables):
        assert getattr(shown[0], name)[name].tolist() == [k]
    assert (shown[0].name, shown[0].floor) == ("p/c1", "turned")
    *pair, (_, minimal, _) = shown[0].subsets
    for (_, subset, _), dots in zip(pair, prepared.pair((1, 0, 6, 0), 0), strict=True):
        assert np.array_equal(subset.points, surface.points[dots])
    assert np.allclose(minimal.points, surface.points[::5] + 0.125)
    _, back, distance = shown[0].recovered  # of minimal.csv
    assert np.array_equal(back.points, minimal.points)
    assert np.array_equal(
        distance, draw_figures.distance_to_surface(back.points, surface.points, surface.normals)
    )
    (rough, *_), (flat, *_) = shown[0].rough_and_flat["patches"]
    assert rough.startswith("rough patch, R = ") and flat.startswith("flat patch, R = ")
    assert float(rough.split(" = ")[1]) < float(flat.split(" = ")[1])
    # 10 test dots by roughness for each of the grid; drawn is the first draw, a row for each reading, around kept dots
    bins = pd.read_csv(tmp_path / "bins.csv")
    assert bins[~bins["bin"].str.endswith("half")].groupby("around")["n"].sum().tolist() == [20, 20]
    best_one = Combination(1.0, 0.0, 6.0, 0.0)
    readings = ["kept", "recovered"]
    found = by_roughness(prepared, best_one, readings, 20, 2, True)
    for (title, *drawn), reading in zip(shown[0].rough_and_flat["panels"], readings, strict=True):
        assert title == f"patches around kept dots, {READINGS[reading].words}"
        for values, expected in zip(drawn, (found.roughness[0], *found.z[reading][:, 0]), strict=True):
            assert np.array_equal(values, expected)
    for _, points, _, *within in shown[0].rough_and_flat["patches"]:
        for places, dots in zip(within, prepared.pair(best_one, 0), strict=True):
            of_patch = (points[:, None] == surface.points[dots]).all(axis=2).any(axis=1)
            assert places.tolist() == np.flatnonzero(of_patch).tolist()
