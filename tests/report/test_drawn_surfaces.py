"""The figures of one surface show what they are given: subsets, distances, grids, frames, and the book of two partners."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from matplotlib import colormaps
from matplotlib.colors import to_hex
from test_figures import FINE, distances, grid, patch, sphere

import draw_figures
import draw_frames
from conftest import make_blob
from drawn import colour_of, legend_of, words_of
from sparsurf.recovery.readings import READINGS
from sparsurf.report.figures import (
    book,
    d_over_grid,
    frames,
    layout,
    number_of_dots,
    recovered,
    render,
    results,
    rough_and_flat,
    roughness,
    rules,
    subsets,
)
from sparsurf.sampling.combination import Combination
from sparsurf.study.evaluator import Evaluator
from sparsurf.study.rough_and_flat import by_roughness
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.surface import Surface

VERMILLION, BLUE, GREY = "#D55E00", "#0072B2", "#4D4D4D"


def pictures(figure):
    """The rendered pictures, (R, C, 3) int each."""
    return [np.asarray(ax.images[0].get_array(), int) for ax in figure.axes if ax.images]


def share_of(picture, name):
    """Share of the pixels that have the hue of a colour, whatever the lamp does to it."""
    wanted = np.array([int(name[k : k + 2], 16) for k in (1, 3, 5)], float)
    coloured = np.ptp(picture, axis=2) > 50
    hue = picture - picture.min(axis=2, keepdims=True)
    wanted -= wanted.min()
    cosine = (hue @ wanted) / (np.linalg.norm(hue, axis=2) * np.linalg.norm(wanted) + 1e-9)
    return (coloured & (cosine > 0.97)).mean()


# ---- the frames of a trajectory


def test_frames_are_coloured_by_cluster_and_the_chosen_ones_ringed():
    plane = np.array([[0.0, 0, 9], [1, 1, 9], [20, 0, 9], [21, 1, 9], [0, 20, 9]])
    labels, chosen = np.array([3, 3, 5, 5, 9]), [1, 2]
    shares = [0.5, 0.3, 0.1, 0.06]
    figure = frames.frames_projection(plane, labels, chosen, ["c1", "c2"], shares, {2: 0.4, 3: 0.6, 4: 0.5})
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
    for n in (frames.NAMED, frames.NAMED + 1):
        names = [f"c{k}" for k in range(n)]
        ax = frames.frames_projection(plane, np.zeros(60, int), range(n), names, [], {}).axes[0]
        assert (len(ax.texts) > 0) == (n == frames.NAMED)


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
    draw_frames.main({name: tmp_path / f"{name}.csv" for name in tables}, {"png": "frames.png"})
    assert [each.tolist() for each in seen[:5]] == [
        [[1, 4], [2, 5], [3, 6]], [0, 0, 1], [1, 2], ["c1", "c2"], [0.7, 0.3]
    ]  # fmt: skip
    assert seen[5] == {2: 0.5}


def test_a_single_conformation_has_no_axes():
    for plane in ([[0.0]], np.zeros((3, 2))):
        figure = frames.frames_projection(plane, [0] * len(plane), [0], ["c1"], [0.0], {1: np.nan})
        assert not figure.axes
        words = [text.get_text() for text in figure.texts]
        assert words == ["One conformation: there are no frames to choose from."]
    two = frames.frames_projection(np.eye(2), [0, 0], [0], ["c1"], [1.0], {1: np.nan})
    assert len(two.axes) == 2  # one cluster has no silhouette


# ---- the grid


def test_the_n_s_that_is_expected_of_a_single_delta_is_a_dash():
    figure = number_of_dots.figure(grid(delta=[2]))
    expected, simulated = figure.axes[0].lines[:2]
    assert (expected.get_marker(), simulated.get_marker()) == ("_", "o")


def test_every_panel_shows_the_n_s_of_its_alpha_and_beta():
    table = grid().sample(frac=1, random_state=0)
    figure = number_of_dots.figure(table)
    panels = [ax for ax in figure.axes if ax.lines]
    alphas, betas, gammas = ([0.2, 1], [0, 0.4, 1], [0, 2, 10])
    shades = [to_hex(c).upper() for c in colormaps["viridis"](np.linspace(0, 0.92, 3))]
    for k, ax in enumerate(panels):
        alpha, beta = alphas[k // 3], betas[k % 3]
        for g, gamma in enumerate(gammas):
            own = table[(table.alpha == alpha) & (table.beta == beta) & (table.gamma == gamma)]
            own = own.sort_values("delta")
            line, points = ax.lines[2 * g : 2 * g + 2]
            np.testing.assert_allclose(line.get_xydata(), own[["delta", "n_S_expected"]] / [1, 10])
            np.testing.assert_allclose(points.get_xydata(), own[["delta", "n_S_percent"]])
            assert colour_of(line) == colour_of(points) == shades[g]
        assert ax.get_title() == (f"β = {beta:g}" if k < 3 else "")
        assert [t.get_text() for t in ax.texts] == ([f"α = {alpha:g}"] if k % 3 == 2 else [])
        assert ax.get_ylim() == (0, 102)
    rows = [ax.get_position().y0 for ax in panels]
    assert rows[0] > rows[3]
    assert [text for text, _ in legend_of(figure)] == [
        "γ = 0", "γ = 2", "γ = 10", "expected (closed form)", "simulated",
    ]  # fmt: skip
    assert [colour for _, colour in legend_of(figure)][:3] == shades


def test_maps_of_d_show_the_values_at_their_gamma_and_delta():
    table = grid(beta=[0, 1], gamma=[0, 2, 10], delta=[0, 5, 10])
    figure = d_over_grid.figure(table)
    part = table[table.alpha == 1]
    maps = [ax for ax in figure.axes if ax.images]
    for k, (reading, beta) in enumerate([(r, b) for r in ("kept", "surface") for b in (0, 1)]):
        ax = maps[k]
        assert ax.get_title() == f"β = {beta:g}" and ax.get_xlabel() == "δ"
        image = np.asarray(ax.images[0].get_array())
        assert ax.images[0].get_extent() == [0, 10, 0, 10] and ax.images[0].origin == "lower"
        for row in part[part.beta == beta].itertuples():
            value = image[round(row.gamma * 10), round(row.delta * 10)]
            assert value == pytest.approx(getattr(row, f"d_{reading}"))
        stars = [line for line in ax.lines if line.get_marker() in "o*"]
        own = part[part.beta == beta]
        top = own.loc[own[f"d_{reading}"].idxmax()]
        assert stars[0].get_xydata().tolist() == [[top.delta, top.gamma]]
        whole = part.loc[part[f"d_{reading}"].idxmax()]
        assert stars[0].get_marker() == ("*" if whole.beta == beta else "o")
    # signs mix under `kept`: white at 0; under `surface` they do not
    assert maps[0].images[0].cmap.name == "RdBu_r" and maps[2].images[0].cmap.name == "viridis"
    norm, values = maps[0].images[0].norm, part["d_kept"]
    assert norm.vmin == -norm.vmax and norm.vmax == pytest.approx(values.abs().max())
    assert maps[2].images[0].norm.vmin == part["d_surface"].min()
    said = [words for words in words_of(figure) if len(words) > 1]
    for words, reading in zip(said, ("kept", "surface"), strict=True):
        top = part.loc[part[f"d_{reading}"].idxmax()]
        assert words.startswith(READINGS[reading].words) and f"γ = {top.gamma:g}, δ = {top.delta:g}" in words
        assert f"{top[f'd_{reading}']:.2f}".replace("-", "−") in words
    less = d_over_grid.figure(grid(alpha=[0.2, 0.4], gamma=FINE))
    assert any("α = 0.4 (the largest of the grid)" in words for words in words_of(less))


# ---- rough and flat


def test_boxes_show_the_bins_of_roughness():
    r, z = distances(500)
    yardsticks = {"empty_patch": 80.6, "null_model": 6.5, "floors": {"fresh dots": 0.5}}
    figure = rough_and_flat.figure(
        [("any dots", r, z[0], z[1])], [patch()], np.random.default_rng(0), yardsticks, bins=5
    )
    ax = figure.axes[-1]
    edges = np.linspace(r.min(), r.max(), 6)
    _, chosen = rough_and_flat._equal_bins(r, np.random.default_rng(0), 5)
    n = min(len(dots) for dots in chosen.values())
    assert f"any dots; n = {n}" in words_of(figure)
    boxes = [p for p in ax.patches]
    assert len(boxes) == 10
    for side, values, colour in ((0, z[0], VERMILLION), (1, z[1], BLUE)):
        for k in range(5):
            corners = boxes[5 * side + k].get_path().vertices
            low, high = np.quantile(values[chosen[k]], [0.25, 0.75])
            assert (corners[:, 1].min(), corners[:, 1].max()) == pytest.approx((low, high))
            middle = (corners[:, 0].min() + corners[:, 0].max()) / 2
            assert edges[k] < middle < edges[k + 1]
            assert (middle < edges[k : k + 2].mean()) == (side == 0)
            assert to_hex(boxes[5 * side + k].get_facecolor()).upper() == colour
    medians = [
        line.get_ydata()[0] for line in ax.lines if line.get_linewidth() == 1 and len(line.get_ydata()) == 2
    ]
    assert {round(np.median(z[0][dots]), 9) for dots in chosen.values()} <= {round(m, 9) for m in medians}
    np.testing.assert_allclose(ax.get_xticks(), edges)
    said = [words for words, _ in legend_of(figure)]
    assert said == ["$Z_{tS}(j)$, sampled", "$Z_{tR}(j)$, random", "null model, 6.50", "fresh dots, 0.50"]
    assert [c for _, c in legend_of(figure)][:2] == [VERMILLION, BLUE]


def test_few_values_are_drawn_as_they_are():
    r, z = distances(7)
    figure = rough_and_flat.figure([("t", r, z[0], z[1])], [patch()], np.random.default_rng(0), bins=2)
    ax = figure.axes[-1]
    dots = [line for line in ax.lines if line.get_marker() == "o"]
    assert len(dots) == 2
    _, chosen = rough_and_flat._equal_bins(r, np.random.default_rng(0), 2)
    for line, values, colour in zip(dots, z, (VERMILLION, BLUE), strict=False):
        np.testing.assert_allclose(line.get_ydata(), np.concatenate([values[own] for own in chosen.values()]))
        assert colour_of(line) == colour


def test_a_patch_is_shown_whole_sampled_and_random():
    r, z = distances(50)
    figure = rough_and_flat.figure([("t", r, z[0], z[1])], [patch()], np.random.default_rng(0))
    titles = [(ax.get_title(), to_hex(ax.title.get_color()).upper()) for ax in figure.axes[:3]]
    assert titles == [("whole, 60 dots", GREY), ("sampled, 30 dots", VERMILLION), ("random, 20 dots", BLUE)]
    _, sampled, random = pictures(figure)
    assert share_of(sampled, VERMILLION) > 1.2 * share_of(random, BLUE) > 0
    assert share_of(sampled, BLUE) == share_of(random, VERMILLION) == 0


# ---- surfaces


def test_the_surface_has_the_colours_of_the_histogram():
    order = np.random.default_rng(0).permutation(2000)
    points, normals = (each[order] for each in sphere(2000))
    rough = np.where(points[:, 0] < 2, 0.2, 0.8) + np.linspace(0, 0.01, 2000)
    figure = roughness.figure(points, normals, rough)
    _, bar, histogram = figure.axes
    counts, edges = np.histogram(rough, 50)
    assert [p.get_height() for p in histogram.patches] == counts.tolist()
    np.testing.assert_allclose([p.get_x() for p in histogram.patches], edges[:-1])
    assert histogram.lines[0].get_xdata()[0] == pytest.approx(rough.mean())
    assert histogram.texts[0].get_text() == f"mean {rough.mean():.2f}"
    low, middle, high = np.quantile(rough, [0.01, 0.5, 0.99])
    low = min(low, middle - 0.1)  # at least 0.2 wide
    assert bar.get_ylim() == pytest.approx((low, high))
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
    points, normals = sphere(600)
    kept = [
        np.arange(600),
        np.arange(0, 600, 2),
        np.arange(0, 600, 6),
        np.arange(0, 600, 3),
        np.arange(0, 600, 12),
    ]
    names = ["whole", "best", "random", "below half", "random too"]
    back = [(f"back {k}", points, normals, np.full(600, 0.02 + 0.03 * k)) for k in range(2)]
    figure = subsets.figure(points, normals, list(zip(names, kept, strict=True)), back)
    said = {text.get_text(): text for text in figure.texts}
    for name, dots, colour in zip(names, kept, (GREY, VERMILLION, BLUE, VERMILLION, BLUE), strict=True):
        text = said[f"{name}\n{len(dots)} dots"]
        assert to_hex(text.get_color()).upper() == colour
    place = {
        name: said[f"{name}\n{len(dots)} dots"].get_position() for name, dots in zip(names, kept, strict=True)
    }
    assert place["best"][0] == place["below half"][0] < place["random"][0] == place["random too"][0]
    assert (
        place["whole"][0] < place["best"][0]
        and place["best"][1] == place["random"][1] > place["below half"][1]
    )
    _, best, random, below, too = pictures(figure)[:5]
    assert share_of(best, VERMILLION) > 1.5 * share_of(below, VERMILLION) > 0 == share_of(best, BLUE)
    assert share_of(random, BLUE) > 1.5 * share_of(too, BLUE) > 0 == share_of(random, VERMILLION)
    letters = [w for w in words_of(figure) if len(w) == 1]
    assert letters == list("ABCDEFG")
    assert "back 0\nmean distance from A 0.020 Å" in said and "back 1\nmean distance from A 0.050 Å" in said
    assert figure.axes[-1].get_xlim() == (0, 0.1)


def test_the_recovered_surface_has_the_colours_of_its_distance():
    whole = sphere(900)
    kept = tuple(each[::10] for each in whole)
    near, far = (recovered.figure(whole, kept, whole, np.full(900, d), list("abc")) for d in (0.0, 0.4))
    # grey; dots upon a pale surface; the colours of the distance
    for figure, name in ((near, "#440154"), (far, "#FDE725")):
        grey, dots, back = pictures(figure)
        assert np.ptp(grey, axis=2).max() < 5
        assert 0.004 < share_of(dots, VERMILLION) < 0.015 and share_of(back, VERMILLION) == 0
        assert share_of(back, name) > 0.2
        assert words_of(figure) == ["A", "a", "B", "b", "C", "c"]
    assert near.axes[-1].get_ylim() == (0, 0.3)


# ---- the book of two partners


def plates(distance=2.0):
    """Two plates that face each other, 20 x 10 Å; the second looks down on the first."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(0.0, 10, 0.5), np.arange(0.0, 20, 0.5)))
    up = np.tile([0.0, 0, 1], (len(x), 1))
    lower = Surface(np.column_stack([x, y, 0 * x]), up)
    return lower, Surface(np.column_stack([x, y, 0 * x + distance]), -up)


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
    figure = book.book_figure("x", surfaces, both)
    bar = figure.axes[2]
    values = np.concatenate([each["propensity_smoothed"] for each in both])
    assert bar.get_ylim() == pytest.approx(tuple(np.quantile(values, [0.01, 0.99])))
    first, second, left, right = pictures(figure)
    blue, yellow = "#440154", "#FDE725"
    # the second partner's values are the higher half of the common scale
    assert share_of(second, yellow) > 0 == share_of(second, blue)
    assert share_of(first, blue) > 0 == share_of(first, yellow)
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
    assert words_of(figure)[0].startswith(
        "x: partner 1 left"
    ) and "interface: dots\nthat touch the\nother partner" in words_of(figure)


def test_the_book_of_partners_apart_shows_the_similarity():
    surfaces = plates(60.0)
    figure = book.book_figure("x", surfaces, tables(surfaces, touching=False))
    bars = [ax for ax in figure.axes if not ax.images]
    assert ["similarity" in ax.get_ylabel() for ax in bars] == [False, True]
    assert bars[1].get_ylim() == pytest.approx((80.5, 100), abs=0.6)
    assert not any("interface" in words for words in words_of(figure))


@pytest.mark.parametrize("larger", [0, 1])
def test_both_pages_have_one_scale(larger):
    both = list(plates())
    small = both[1 - larger]
    both[1 - larger] = Surface(small.points[:100], small.normals[:100])
    figure = book.book_figure("x", both, tables(both))
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
        render.closing_radius(100 * dense) == render.LARGEST
        and render.closing_radius(dense / 1e3) == render.DOT
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
    assert layout.pixels(25.4, 50.8) == (600, 300)  # rows, columns at 300 per inch


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


def test_a_figure_draws_its_part_of_the_results():
    points, normals = sphere(300)
    rough = np.linspace(0.3, 0.9, 300)
    table = grid().drop(columns="d_kept").assign(d_recovered=-0.001)
    own = results.Results(
        Surface(points, normals),
        rough,
        table,
        {"surface": {}},
        [("whole", np.arange(300))],
        {"panels": [], "patches": []},
    )
    assert [p.get_height() for p in roughness.draw(own).axes[2].patches] == np.histogram(rough, 50)[
        0
    ].tolist()
    assert len([ax for ax in number_of_dots.draw(own).axes if ax.lines]) == 6
    words = words_of(d_over_grid.draw(own))
    drawn = [name for name in READINGS for w in words if w.startswith(READINGS[name].words)]
    assert drawn == ["surface", "recovered"]
    assert any("highest $d$ = 0.00 at" in w for w in words)
    assert own.recovered == ()
    assert "whole\n300 dots" in words_of(subsets.draw(own))


def test_the_rough_patch_is_rougher_than_the_flat_one_and_few_dots_lie_where_it_is_rough(
    tmp_path, monkeypatch
):
    surface = Surface(*make_blob(1500))
    settings = {"patches": {"R_patch": 4.0, "R_zernike": 6.0, "D_link": 1.1}, "evaluation": {"test_dots": 2}}
    settings |= {"sampling": {"moved_centre": True, "every_patch": True}, "seed": 1}
    evaluator = Evaluator.from_settings(surface, settings, None, "p/c1", 1)
    unrestricted = {"alpha": 1, "beta": 0, "gamma": 6, "delta": 0}
    other = unrestricted | {"gamma": 0}  # of another reading: not what is drawn
    best = {"recovered": {"unrestricted": other}, "kept": {"unrestricted": unrestricted}, "yardsticks": {}}
    inputs = {name: str(tmp_path / name) for name in ("surface", "roughness", "grid", "best")}
    write_npz(inputs["surface"], surface)
    pd.DataFrame({"roughness": evaluator.roughness}).to_csv(inputs["roughness"], index=False)
    pd.DataFrame({"d": [0.0]}).to_csv(inputs["grid"], index=False)
    Path(inputs["best"]).write_text(json.dumps(best))
    shown = []
    monkeypatch.setattr(draw_figures, "DRAWS", 2)
    monkeypatch.setattr(draw_figures, "_recovered", lambda surface, title, kept: (title, kept.tolist()))
    monkeypatch.setattr(draw_figures, "import_module", lambda _: SimpleNamespace(draw=shown.append))
    monkeypatch.setattr(draw_figures.layout, "save", lambda *_: None)
    draw_figures.main(inputs, {"bins": tmp_path / "bins.csv", "subsets": "x.png"}, settings, "p/c1", 1)
    titles = [title for title, _ in shown[0].subsets]
    assert titles == [
        "all dots",
        "sampled, (1, 0, 6, 0)",
        "random, as many",
        "sampled, (1, 1, 10, 0)",
        "random, as many",
    ]
    for k, combination in ((1, (1, 0, 6, 0)), (3, (1, 1, 10, 0))):
        for offset, dots in enumerate(evaluator.pair(combination, 0)):
            assert np.array_equal(shown[0].subsets[k + offset][1], dots)
    (rough, *_), (flat, *_) = shown[0].rough_and_flat["patches"]
    assert rough.startswith("rough patch, R = ") and flat.startswith("flat patch, R = ")
    assert float(rough.split(" = ")[1]) < float(flat.split(" = ")[1])
    # few dots are made a surface again, the sampled ones and as many uniform ones
    few = [dots.tolist() for dots in evaluator.pair((1, 1, 10, 0), 0)]
    assert shown[0].recovered == [("recovered from D", few[0]), ("recovered from E", few[1])]
    # 40 test dots by roughness for each of the grid; drawn is the first draw, a row for each reading, around kept dots first
    bins = pd.read_csv(tmp_path / "bins.csv")
    assert bins[~bins["bin"].str.endswith("half")].groupby("around")["n"].sum().tolist() == [80, 80]
    best_one = Combination(1.0, 0.0, 6.0, 0.0)
    places = [(reading, kept) for reading in ("kept", "recovered") for kept in (True, False)]
    for (title, *drawn), (reading, kept) in zip(shown[0].rough_and_flat["panels"], places, strict=True):
        assert title == f"{'kept' if kept else 'any'} dots, {READINGS[reading].words}"
        found = by_roughness(evaluator, best_one, [reading], 80, 2, kept)
        for values, expected in zip(drawn, (found.roughness[0], *found.z[reading][:, 0]), strict=True):
            assert np.array_equal(values, expected)
    for _, points, _, *within in shown[0].rough_and_flat["patches"]:
        for places, dots in zip(within, evaluator.pair(best_one, 0), strict=True):
            of_patch = (points[:, None] == surface.points[dots]).all(axis=2).any(axis=1)
            assert places.tolist() == np.flatnonzero(of_patch).tolist()


def test_arrows_between_rules_meet_the_sides_that_face_each_other():
    # boxes of 31 x 22 mm, 37.5 and 31 mm apart, from 1 mm on
    assert rules._ends((0, 0), (1, 0)) == ((32, 12), (38.5, 12))
    assert rules._ends((0, 0), (0, 1)) == ((16.5, 23), (16.5, 32))
    assert rules._ends((0, 1), (0, 0)) == ((16.5, 32), (16.5, 23))
    (x, y), (u, v) = rules._ends((0, 1), (1, 0))
    assert (x, u) == (32, 38.5) and y == pytest.approx(43 - 6.6) and v == pytest.approx(12 + 6.6)
    figure = rules.draw()
    said = [t.get_text() for t in figure.axes[0].texts]
    assert said[::2] == list(rules.STAGES) and said[1::2] == [
        "\n".join(own) for *_, own in rules.STAGES.values()
    ]
    assert len(figure.axes[0].patches) == len(rules.STAGES) + len(rules.ARROWS)
