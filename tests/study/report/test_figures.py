"""Every figure looks as its stored picture; texts stay apart; three figures are followed from data to artist.

A figure that is to look otherwise: BASELINE=new pytest tests/study/report/test_figures.py, and look at the pictures in baseline/.
"""

import json
import re
from itertools import product
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from figure_cases import AWKWARD, PICTURES, enough, grid, sphere, trajectory
from matplotlib import __version__, colormaps, rcParams
from matplotlib.image import imread
from matplotlib.text import Text

from drawn import MADE_BY, check_texts, differs, of_another_matplotlib
from small_study import run_script
from sparsurf import registry
from sparsurf.arguments import INTERPOLANT, SPHERES
from sparsurf.recovery.law import error_at
from sparsurf.sampling.combination import Combination
from sparsurf.settings import Settings
from sparsurf.surfaces.formats.colours import ROUGHNESS_LIMITS
from sparsurf.surfaces.surface import Surface
from sparsurf.views import layout
from sparsurf_study.report.figures import (
    d_over_grid,
    frames,
    over_time,
    pair_figures,
    rough_and_flat,
    roughness,
    subsets,
)
from sparsurf_study.report.numbers import better_than_uniform

BASELINE = Path(__file__).with_name("baseline")


def test_every_stored_picture_is_of_a_figure():
    assert {path.stem for path in BASELINE.glob("*.png")} == {*PICTURES}


WORDS = {  # with numbers that follow from the invented tables by hand
    "frames": ["p: 3 of 300 frames chosen", "PC 1 (Å), 50 % of the variance", "PC 2 (Å), 20 % of the variance"],
    # 27 combinations with α = 1, without that of the most dots
    "d_over_grid": [
        "p/c1: 11 of 26 combinations with α = 1 beat a random subset among the kept dots, none on the full surface",
        "among the kept dots, α = 1: highest at β = 0, γ = 2, δ = 0, 72 % of the dots",
        "on the full surface, α = 1: highest at β = 0, γ = 0, δ = 0, 100.3 % of the dots, more than in any range",
    ],
    "d_over_grid_recovered": ["0 of 26 combinations with α = 0.4 beat a random subset on the full surface, 9 recovered",
                              "recovered, α = 0.4 (the largest of the grid): highest at β = 0, γ = 10, δ = 0, 14 % of the dots"],
    "rough_and_flat": ["mean patch for all, 1.50", "fresh dots, 0.50"],
    "subsets": ["p/c1: 45 dots reconstruct the surface", "the surface 400 dots",
                "the paper's best, (1, 0, 6, 0) 200 dots, 50.0 %", "random subset of the same size 200 dots, 50.0 %"],
    "required_dots": ["p/c1: 13.0 % of the dots, mean error 0.020 Å"],
    "required_dots_of_many": ["median of 7: 16.0 % of the dots, error 0.017 Å"],
    "ensemble": ["mean 40.00, sd 0.71", "mean 0.6000, sd 0.0071", "mean 1.02, sd 0.14", "mean −0.96, sd 0.13",
                 "α = 1, β = 0, γ = 6, δ = 4", "moving mean, 5 frames"],
    # 1.6 times the Z, which falls with the square root of the number
    "compare": ["same Z: 2.6 times fewer dots", "mean descriptor for every patch: 3.50", "fresh dots of the surface: 0.40"],
    "pairs": ["AUC of complementarity 0.50 (0.25 to 0.75), of protrusion 0.75 (0.50 to 1.00)"],
    "book": ["x: matching patches do not mark the interface, and lie away from it on partner 2",
             "partner 1, seen from partner 2: AUC 0.70 (0.50 to 0.90)",
             "partner 2, seen from partner 1: AUC 0.25 (0.10 to 0.40)"],
    "changes": ["opening: 2 of 7 residues change more than their floor, about 0 would by chance"],
    "changes, all over": ["opening: most residues change more than their floor (7 of 8, about 0 would by chance)"],
    "table1": ["2.6–12 %   (0.4, 0.2, 10, 10)", "90–99.7 %   (1, 0.2, 0, 0)", "40 runs as published"],
}  # fmt: skip


@pytest.mark.parametrize("name", [*PICTURES, *AWKWARD])
@pytest.mark.filterwarnings("error")
def test_a_figure_looks_as_before_and_its_texts_are_apart_and_have_their_numbers(name, tmp_path, monkeypatch):
    """A number of a text is too small for the comparison with the stored picture, which is of one matplotlib."""
    figure = (PICTURES | AWKWARD)[name]()
    check_texts(figure, monkeypatch)
    if name in PICTURES and not of_another_matplotlib():
        assert not differs(figure, BASELINE / f"{name}.png", tmp_path)
    texts = {" ".join(text.get_text().split()) for text in figure.findobj(Text)}
    assert not {" ".join(words.split()) for words in WORDS.get(name, ())} - texts, texts
    if name in PICTURES and of_another_matplotlib():
        pytest.skip(f"pictures are of matplotlib {MADE_BY}, not {__version__}")


def test_the_figures_of_a_surface_are_drawn_from_its_own_results(study, tmp_path, monkeypatch):
    """The best combination among the kept dots, one random subset of its size, and the minimal subset with its error."""
    folder, drawn = study / "results/small/still/f0", {}
    monkeypatch.setattr(layout, "save", lambda figure, path: drawn.setdefault(Path(path).stem, figure))
    inputs = {name: folder / f"{name}.csv" for name in ("roughness", "grid", "minimal", "recovered")}
    inputs |= {
        "surface": folder / "surface.npz",
        "reconstructed": folder / "reconstructed.npz",
        "best": folder / "best.json",
    }
    outputs = {name: tmp_path / f"{name}.png" for name in ("required_dots", "rough_and_flat", "subsets")}
    outputs |= {"svg": [], "bins": tmp_path / "bins.csv"}
    outputs |= {f"picture_{name}": tmp_path / f"{name}.png" for name in ("sampled", "minimal")}
    params = Settings().model_dump(include={"patches", "minimal", "sampling"}, exclude_none=True)
    params |= {"evaluation": {"test_dots": 20}, "seed": 20261120}
    run_script("draw_figures", tmp_path, inputs, outputs, params, protein="still", conformation="f0")
    best = json.loads(inputs["best"].read_text())
    winner = best["kept"]["unrestricted"]
    minimal, recovered = pd.read_csv(inputs["minimal"]), pd.read_csv(inputs["recovered"]).iloc[0]
    texts = {
        name: {" ".join(text.get_text().split()) for text in figure.findobj(Text)}
        for name, figure in drawn.items()
    }
    head = f"{recovered['n_S_percent']:.1f} % of the dots, mean error {recovered['mean']:.3f} Å"
    assert any(words.endswith(head) for words in texts["required_dots"])
    head = f"{len(minimal)} dots reconstruct the surface to {recovered['mean']:.3f} Å on average"
    assert any(words.endswith(head) for words in texts["subsets"])
    sampled, uniform, few = (
        next(words for words in texts["subsets"] if words.startswith(begin))
        for begin in (
            "the paper's sampling, highest d among the kept dots",
            "random subset of",
            f"minimal subset, {registry.TABLE['sampler'][recovered['sampler']].label}",
        )
    )
    kept = {int(re.search(r"([\d,]+) dots, ", words)[1].replace(",", "")) for words in (sampled, uniform)}
    assert str(Combination.from_row(winner)) in sampled and len(kept) == 1
    assert kept.pop() == pytest.approx(winner["n_S"], rel=0.1) and f" {len(minimal)} dots, " in few
    assert f"fresh dots, {best['references']['floors']['fresh dots']:.2f}" in texts["rough_and_flat"]
    pd.testing.assert_frame_equal(pd.read_csv(outputs["bins"]), pd.read_csv(folder / "rough_and_flat.csv"))
    distance = drawn["subsets"].axes[
        -1
    ]  # of the dots from the reconstructed surface, measured as in the table
    assert distance.lines[0].get_xdata()[0] == pytest.approx(recovered["mean"], rel=0.1)


def test_frames_are_drawn_where_their_tables_say():
    """Every tenth frame was read, and the chosen ones are named by their number in the trajectory."""
    number, rng = np.arange(0, 400, 10), np.random.default_rng(0)
    plane = rng.normal(size=(40, 2)) * [9, 2]
    projection = pd.DataFrame(
        {"frame": number, "pc1": plane[:, 0], "pc2": plane[:, 1], "cluster": number // 200}
    )
    chosen = pd.DataFrame({"conformation": ["f0200", "f0030"], "frame": [200, 30]})
    silhouette = pd.DataFrame({"K": [3, 2], "silhouette": [0.3, 0.7]})
    explained = pd.DataFrame({"explained": [0.6, 0.25, 0.1]})
    figure = frames.figure_of_tables(chosen, silhouette, projection, explained, "p")
    plot, variance, clusters = figure.axes
    every, ringed = plot.collections
    assert np.array_equal(every.get_offsets(), plane) and np.array_equal(ringed.get_offsets(), plane[[20, 3]])
    colours = every.get_facecolors()[:, :3]
    assert len(np.unique(colours[:20], axis=0)) == 1 != len(np.unique(colours, axis=0))
    named = {text.get_text(): text.xy for text in plot.texts}
    assert named == {"f0030": pytest.approx(tuple(plane[3])), "f0200": pytest.approx(tuple(plane[20]))}
    assert [bar.get_height() for bar in variance.patches] == pytest.approx([60, 25, 10])
    assert variance.lines[0].get_ydata() == pytest.approx([60, 85, 95])
    assert clusters.lines[0].get_xydata().tolist() == [[2, 0.7], [3, 0.3]]
    assert clusters.lines[1].get_xydata().tolist() == [[2, 0.7]] and clusters.get_title() == "K = 2 chosen"


@pytest.mark.parametrize(
    ("step", "label", "last"),
    [(100.0, "time (ps)", 9900), (200.0, "time (ns)", 19.8), (np.nan, "frame", 297)],
)
def test_time_has_its_unit(step, label, last):
    table = trajectory().assign(time_ps=step * np.arange(100))
    figure = over_time.ensemble_figure(table, (1, 0, 6, 4), "p")
    shown = [ax for ax in figure.axes if ax.get_xlabel()]
    assert {ax.get_xlabel() for ax in shown} == {label}
    assert shown[0].lines[0].get_xdata()[-1] == pytest.approx(last)


def test_the_law_and_the_subset_are_drawn_where_they_are():
    """Of both models, so that a subset is compared with evenly spread dots that are reconstructed as it is."""
    for quantity, (ax, error) in enumerate(zip(enough().axes, (0.02, 0.1), strict=True)):
        *laws, subset = ax.lines
        for line, (hydrogens, model) in zip(
            laws, product((False, True), (INTERPOLANT, SPHERES)), strict=True
        ):
            density, drawn = line.get_xydata().T
            expected = [error_at(x, hydrogens=hydrogens, reconstruction=model)[quantity] for x in density]
            assert drawn == pytest.approx(expected)
            assert (density.min(), density.max()) == pytest.approx((0.15, 2.4))  # as far as was measured
            is_alike = line.get_color() == subset.get_color()
            assert is_alike == (model == SPHERES)  # the model of the subset
        assert subset.get_xydata().tolist() == [[0.7, error]]


def test_a_dot_of_a_pair_is_the_mean_of_its_partners():
    """Of three pairs whose partners differ by 0.2, for each score; the mean of all with its interval is drawn above them."""
    ax = PICTURES["pairs"]().axes[0]
    dots, _, means = (
        [line.get_xdata() for line in ax.lines[:-1] if line.get_marker() == mark]
        for mark in (".", "None", "o")
    )
    for of_pairs, mean, wanted in zip(dots, means, ([0.4, 0.5, 0.6], [0.65, 0.75, 0.85]), strict=True):
        assert sorted(of_pairs) == pytest.approx(wanted) and mean == pytest.approx([np.mean(wanted)])


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
    # the interval of the first reaches below 0, and that of the last is not known
    table = table.assign(d_kept=[0.5, 0.5, 0.2], d_low_kept=[-0.1, 0.4, np.nan])
    assert better_than_uniform(table, "kept") == (1, 2)


def test_the_histogram_counts_the_roughness_in_the_colours_of_the_surface():
    points = np.random.default_rng(0).normal(size=(300, 3))
    rough = np.random.default_rng(1).beta(5, 2, 300)
    _, bar, histogram = roughness.figure(points, points, rough).axes
    counts, edges = np.histogram(rough, 50)
    assert [patch.get_height() for patch in histogram.patches] == counts.tolist()
    assert histogram.lines[0].get_xdata()[0] == pytest.approx(rough.mean())
    low, high = ROUGHNESS_LIMITS
    wanted = colormaps["viridis"](np.clip(((edges[:-1] + edges[1:]) / 2 - low) / (high - low), 0, 1))
    np.testing.assert_allclose([patch.get_facecolor() for patch in histogram.patches], wanted)
    assert bar.get_ylim() == pytest.approx((low, high))  # whatever the surface


def test_residues_over_time_have_the_colours_of_the_surface():
    image = PICTURES["residues_over_time"]().axes[0].images[0]
    assert (image.norm.vmin, image.norm.vmax) == ROUGHNESS_LIMITS  # whatever the frames
    assert np.nanmax(image.get_array()) < ROUGHNESS_LIMITS[1]


def test_most_distances_fill_more_than_two_bars_of_the_histogram():
    """Those of a surface from few dots: most are a thousand times smaller than the largest."""
    distance = np.random.default_rng(0).lognormal(np.log(0.0015), 1.2, 3000)
    distance[:30] = 0.4
    points, normals = sphere(3000)
    whole = Surface(points, normals)
    drawn = subsets.figure(whole, [("some", whole[::9], "black")], ("back", whole, distance, np.arange(3000)))
    heights = np.array([bar.get_height() for bar in drawn.axes[-1].patches])
    assert heights.sum() == 3000 and (heights > 0.01 * heights.max()).sum() > 15


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


@pytest.mark.parametrize("slope", [-1, 1])
def test_the_name_of_a_reference_keeps_away_from_the_curves(slope):
    """The curves come down to the line at one of its ends."""
    r = np.linspace(0.1, 0.9, 200)
    z = 2.05 + slope * 3.9 * (r - 0.5)
    figure = rough_and_flat.figure([("t", r, z, z + 0.1)], {"floors": {"fresh dots": 0.5}})
    ax = figure.axes[0]
    (name,) = [text for text in ax.texts if text.get_text() == "fresh dots, 0.50"]
    box = name.get_window_extent()
    curves = [line.get_path().interpolated(50) for line in ax.lines if len(line.get_xdata()) > 2]
    assert len(curves) == 2 and not any(
        box.contains(*place) for path in curves for place in ax.transData.transform(path.vertices)
    )
