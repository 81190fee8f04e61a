"""The page of a surface: what it stores, and what a real browser makes of it."""

import base64
import json
import zlib
from dataclasses import replace
from pathlib import Path

import matplotlib.image
import numpy as np
import pandas as pd
import pytest
from PIL import Image

import draw_pair
import draw_view
import sparsurf
from browser import Browser, programs
from sparsurf.recovery.readings import READINGS
from sparsurf.report.figures import layout, render
from sparsurf.report.viewer import packing
from sparsurf.report.viewer import page as viewer
from sparsurf.sampling import published
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.sampling.samplers import farthest
from sparsurf.study import grid as grids
from sparsurf.study import tables
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.formats import ply
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.formats.ply import KIND_COLOURS
from sparsurf.surfaces.surface import Surface

COMBINATIONS = [(1, 0, 6, 0), (0.2, 0.4, 2, 1), (0.6, 1, 0, 0), (1, 0.5, 10, 10)]
MINIMAL = [5, 70, 2999]
RESIDUES = ["LEU 212 A", "HIS 256 A"]


@pytest.fixture(scope="module")
def prepared(blob):
    """A bumpy surface whose places have three decimals, as those of a DMS file."""
    points, normals = blob[0].round(3), blob[1]
    n = len(points)
    surface = Surface(points, normals, kind=np.arange(n) % 3, atom=np.arange(n) % 2)
    return PreparedSurface(surface, d_link=1.5, name="blob")


def test_the_best_of_recovered_surfaces_can_be_chosen_where_it_was_studied():
    row = {"alpha": 1, "beta": 0, "gamma": 6, "delta": 0, "n_S_percent": 46.0, "d": 0.5, "d_cv": 0.4}
    row |= {"d_cv_low": 0.2, "d_cv_high": 0.6}
    best = {"recovered": {"unrestricted": row, "under_max_n_S": row}, "max_n_S_percent": 20}
    words = READINGS["recovered"].words
    assert [name for name, _ in viewer._presets(best)][1:] == [f"best, {words}", f"best below 20 %, {words}"]


@pytest.fixture(scope="module")
def grid(prepared):
    """The table of a small grid and its raw distances."""
    raw = grids.evaluate_grid(prepared, published.parameter_grid([0.5, 1], [0, 1], [0, 6], [0, 6]), 20, 2)
    return tables.grid_table(raw), raw


def write(prepared, grid, values=()):
    """The page of the surface, and the order of its farthest-point sampling."""
    order = farthest(prepared, len(prepared.points), prepared.stream("test"))
    text = viewer.page(
        "blob/c1", prepared.surface, prepared.roughness, prepared.cover, prepared.r_patch,
        {"farthest": order}, grid[0], tables.best_combinations(*grid, 50), RESIDUES, values, MINIMAL,
    )  # fmt: skip
    return text, order


def unpacked(text):
    """Header and columns, read back as slowly as it goes."""
    content = zlib.decompress(base64.b64decode(text))
    size = int.from_bytes(content[:4], "little")
    header, place, columns = json.loads(content[4 : 4 + size]), 4 + size, {}
    for name, length, planes, summed in header["columns"]:
        values = []
        for i in range(length):
            folded = sum(content[place + k * length + i] << 8 * k for k in range(planes))
            value = -(folded + 1) // 2 if folded % 2 else folded // 2
            values.append(value + (values[-1] if summed and values else 0))
        columns[name], place = values, place + length * planes
    assert place == len(content)
    return header, columns


def test_columns_come_back_as_they_were():
    given = {
        "mixed": [0, -1, 5, 300, -70_000, 2**24],
        "slow": list(range(-5, 900)),
        "none": [],
        "zeros": [0, 0, 0],
    }
    header, columns = unpacked(packing.pack({"n": 3}, {name: np.array(v, int) for name, v in given.items()}))
    assert header["n"] == 3
    assert columns == given


def test_values_beyond_their_limits_are_at_the_ends():
    values = np.array([-1.0, 0.0, 0.5, 2.0, np.nan])
    assert packing.in_steps(values, 0.0, 1.0).tolist() == [0, 0, 127, 254, 255]
    assert packing.in_steps(values[1:2], 0.0, 0.0).tolist() == [0]


def test_flat_normals_are_within_two_degrees():
    rng = np.random.default_rng(1)
    normals = rng.normal(size=(5000, 3))
    normals = np.vstack([normals / np.linalg.norm(normals, axis=1)[:, None], np.eye(3), -np.eye(3)])
    u, v = packing.flat_normals(normals).T / packing.OCTAHEDRON
    z = 1 - np.abs(u) - np.abs(v)
    back = np.stack([u, v, z], axis=1)
    below = z < 0
    back[below, 0], back[below, 1] = (
        (1 - np.abs(v[below])) * np.where(u[below] < 0, -1, 1),
        (1 - np.abs(u[below])) * np.where(v[below] < 0, -1, 1),
    )
    cosine = (back * normals).sum(axis=1) / np.linalg.norm(back, axis=1)
    assert np.degrees(np.arccos(np.clip(cosine, -1, 1))).max() < 2


def test_a_hundred_thousand_dots_fit(grid):
    """Dots of a sphere in the order that a surface has, with a cover of three pairs each and two more colours."""
    n, rng = 130_000, np.random.default_rng(2)
    k = np.arange(n) + 0.5
    z, turn = 1 - 2 * k / n, np.pi * (1 + 5**0.5) * k
    unit = np.stack(
        [np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z], axis=1
    )  # neighbours in the order lie far apart: packs worse than the dots of atoms do
    surface = Surface(50 * unit, unit, kind=np.zeros(n), atom=np.zeros(n))
    centre = np.arange(0, n, 300)
    start = np.append(np.arange(len(centre)) * 900, len(centre) * 900)
    dot = (np.repeat(centre, 900) + np.tile(np.arange(900), len(centre))) % n
    cover = published.Cover(centre, centre, rng.random(len(centre)), start, dot, np.ones(len(dot)), n)
    more = [viewer.Values("other", "o", " Å", np.cos(40 * z)) for _ in range(2)]
    order = {"farthest": rng.permutation(n)}
    text = viewer.page(
        "big", surface, z**2, cover, 4.0, order, grid[0], tables.best_combinations(*grid, 50), (), more
    )
    assert len(text.encode()) <= 1_500_000
    header, columns = unpacked(text.split('PACKED = "')[1].split('"')[0])
    assert header["total"] == n
    assert header["stored"] == 100_000
    assert viewer.MAX_BYTES <= 1_500_000  # the frame of a report shows 1.57 MB at most
    assert set(columns["index"]) == set(order["farthest"][: header["stored"]].tolist())
    shown = np.isin(dot, columns["index"])
    assert len(columns["pair"]) == shown.sum()
    assert np.array_equal(
        np.array(columns["index"])[columns["pair"][:600]][:3], np.sort(dot[:900][shown[:900]])[:3]
    )


def test_a_page_that_would_be_too_long_shows_fewer_dots(prepared, grid, monkeypatch):
    whole, order = write(prepared, grid)
    monkeypatch.setattr(viewer, "MAX_BYTES", len(whole) - 5000)
    fewer, _ = write(prepared, grid)
    assert len(fewer) <= len(whole) - 5000
    header, columns = unpacked(fewer.split('PACKED = "')[1].split('"')[0])
    assert 1000 < header["stored"] < header["total"] == 3000
    assert set(columns["index"]) == set(order[: header["stored"]].tolist())


def test_the_page_stands_alone(prepared, grid):
    text, _ = write(prepared, grid)
    assert "http://" not in text and "https://" not in text and "%" + "DATA" not in text
    assert "src=" not in text and "@import" not in text


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """A browser for the tests of this file."""
    if None in programs():
        pytest.skip("no chromium and chromedriver on the PATH (Debian: chromium, chromium-driver)")
    made = Browser(tmp_path_factory.mktemp("browser"))
    yield made
    made.close()


@pytest.fixture(scope="module")
def path(prepared, grid, tmp_path_factory):
    """The page as a file, with a colour of which some values are unknown."""
    depth = np.where(np.arange(len(prepared.points)) % 7 == 0, np.nan, prepared.points[:, 2])
    values = [viewer.Values("height above the middle", "z", " Å", depth, "low", "high")]
    path = tmp_path_factory.mktemp("page") / "view.html"
    path.write_text(write(prepared, grid, values)[0])
    return path


@pytest.fixture
def opened(browser, path):
    """The page, freshly loaded; whatever the console says is an error."""
    browser.open(path.as_uri())
    browser.wait_for("document.getElementById('shown').textContent.includes('dots (')")
    yield browser
    assert browser.complaints() == []


def set_control(browser, name, value):
    """Move a control as a user does: value, then its event."""
    browser.run(
        "const e = document.getElementById(arguments[0]); e.value = arguments[1];"
        "e.dispatchEvent(new Event('input', {bubbles: true}))",
        name,
        str(value),
    )


def text_of(browser, name):
    return browser.run("return document.getElementById(arguments[0]).textContent", name)


def exponentials(count, seed):
    """The page's numbers: -ln of xorshift's."""
    mask, out = 0xFFFFFFFF, []
    state = ((seed + 1) * 0x9E3779B1 & mask) | 1
    for _ in range(count):
        state ^= state << 13 & mask
        state ^= state >> 17
        state ^= state << 5 & mask
        out.append(-np.log((state + 0.5) / 2**32))
    return np.array(out)


class Given:
    """Hands the library numbers that are already there."""

    def __init__(self, numbers):
        self.numbers = numbers

    def standard_exponential(self, out):
        out[:], self.numbers = self.numbers[: len(out)], self.numbers[len(out) :]


def test_the_page_keeps_the_dots_that_the_library_keeps(opened, prepared):
    cover = prepared.cover
    owner = np.repeat(np.arange(len(cover.centre)), np.diff(cover.start))
    luck = np.empty(len(cover.dot))
    set_control(opened, "sampler", "paper")
    for seed in (1, 2):
        luck[np.lexsort((cover.dot, owner))] = exponentials(len(luck), seed)
        for combination in COMBINATIONS:
            for name, value in zip(PARAMETERS, combination, strict=True):
                set_control(opened, name, value)
            expected = published.sample(cover, combination, Given(luck))
            assert opened.run("return Array.from(view.shown)") == expected.tolist()
            assert f"{len(expected):,} of 3,000 dots" in text_of(opened, "shown")
        opened.run("document.getElementById('again').click()")


def test_one_sample_takes_milliseconds(opened):
    spent = opened.run(
        "let least = Infinity; for (let k = 0; k < 200; k++) { const t = performance.now();"
        "for (let m = 0; m < 10; m++) sample(cover, [1, 0, 6, 0], luck, keep);"
        "least = Math.min(least, performance.now() - t) } return least / 10 / luck.length"
    )
    assert spent * 61_636 < 5  # ms, for the pairs of the paper's A1


def test_nested_sampler_and_number(opened, prepared, grid):
    _, order = write(prepared, grid)
    assert opened.run("return Array.from(view.shown)") == MINIMAL  # what the page opens with
    set_control(opened, "sampler", "farthest")
    for percent in (10, 50):
        set_control(opened, "percent", percent)
        assert opened.run("return Array.from(view.shown)") == order[: 30 * percent].tolist()
    set_control(opened, "sampler", "uniform")
    shown = opened.run("return Array.from(view.shown)")
    assert len(set(shown)) == len(shown) == 1500
    assert max(shown) < 3000


def test_grid_rows_are_those_of_the_table(opened, grid):
    set_control(opened, "sampler", "paper")
    for asked, nearest in (((0.9, 0.2, 5, 1), [1, 0, 6, 0]), ((0.6, 0.8, 2, 8), [0.5, 1, 0, 6])):
        for name, value in zip(PARAMETERS, asked, strict=True):
            set_control(opened, name, value)
        row = grid[0][(grid[0][PARAMETERS] == nearest).all(axis=1)].iloc[0]
        expected = [["reading", "Z_tS", "Z_tR", "d"]]
        for reading, words in (("kept", "among the kept dots"), ("full", "on the full surface")):
            numbers = [f"{row[f'{name}_{reading}']:.2f}" for name in ("Z_tS", "Z_tR", "d")]
            expected.append([words, *(each.replace("-", "−") for each in numbers)])
        rows = "return [...document.querySelectorAll('#nearest tr')].map(r => [...r.cells].map(c => c.textContent))"
        assert opened.run(rows) == expected
        said = text_of(opened, "nearest")
        assert f"({', '.join(map(str, nearest))}), n_S {row['n_S_percent']:.1f} %" in said


def test_a_chosen_combination_moves_all_four_sliders(opened):
    set_control(opened, "sampler", "paper")
    set_control(opened, "beta", 0.7)
    set_control(opened, "presets", 0)  # the paper's best
    assert opened.run("return LAW.map((name) => element(name).value)") == ["1", "0", "6", "0"]
    beyond = "slide(element('gamma'), 12); slide(element('alpha'), 0.33); slide(element('beta'), 0.7);"
    assert opened.run(f"{beyond} return LAW.map((name) => element(name).value)") == ["0.33", "0.7", "12", "0"]
    set_control(opened, "presets", 0)
    assert "(1, 0, 6, 0)" in text_of(opened, "nearest")


def picture(browser):
    """The window, (rows, columns, 3)."""
    path = browser.folder / "window.png"
    path.write_bytes(browser.screenshot())
    return matplotlib.image.imread(path)[..., :3]


def coloured(image):
    """Number of pixels that are neither white nor grey."""
    return int((np.ptp(image, axis=2) > 0.15).sum())


def test_colours_fill_the_picture(opened):
    found = {}
    for colour in ("0", "1", "kind"):
        set_control(opened, "colour", colour)
        set_control(opened, "sampler", "all")
        opened.run("drawNow()")
        image = picture(opened)[100:, :600]
        assert coloured(image) > 20_000
        found[colour] = image
    assert np.abs(found["0"] - found["kind"]).max() > 0.3
    assert "contact" in text_of(opened, "legend")
    set_control(opened, "sampler", "farthest")
    set_control(opened, "percent", 5)
    opened.run("drawNow()")
    assert coloured(picture(opened)[100:, :600]) < coloured(found["kind"]) / 2


def test_every_dot_has_the_colour_of_its_value(opened, prepared):
    """Grey where it is unknown; viridis is brighter the higher the value, so that it reads without colour vision."""
    opened.run("const paintAll = scene.colour; scene.colour = (rgb) => paintAll((window.painted = rgb))")
    height = prepared.points[:, 2]
    colours = {
        "0": (prepared.roughness, "rough", "flat"),
        "1": (np.where(np.arange(len(height)) % 7 == 0, np.nan, height), "low", "high"),
    }
    for colour, (values, *ends) in colours.items():
        set_control(opened, "colour", colour)
        painted = np.reshape(opened.run("return Array.from(painted)"), (-1, 3))
        known, low, high = np.isfinite(values), np.nanmin(values), np.nanmax(values)
        expected = 255 * matplotlib.colormaps["viridis"]((values[known] - low) / (high - low))[:, :3]
        assert np.abs(painted[known] - expected).max() < 6  # 16 colours in between which it is interpolated
        assert (painted[~known] == 160).all()
        unit, unknown = (" Å", "unknown") if colour == "1" else ("", "")
        said = [f"{value:.2f}{unit} {end}" for value, end in zip((low, high), ends, strict=True)]
        assert text_of(opened, "legend").endswith(("".join(said) + unknown).replace("-", "−"))
        told = f"dark {low:.2f}{unit}, bright {high:.2f}{unit}" + (", grey unknown" if unknown else "")
        assert opened.run("return caption()").endswith(told.replace("-", "−"))
    set_control(opened, "colour", "kind")
    painted = np.reshape(opened.run("return Array.from(painted)"), (-1, 3))
    assert np.array_equal(painted, KIND_COLOURS[prepared.surface.kind])
    assert opened.run("return caption()").endswith("colour: " + ", ".join(viewer.KINDS[:3]))
    brightness = np.array(opened.run("return head.stops")) @ [0.2126, 0.7152, 0.0722]
    assert np.diff(brightness).min() > 3


def test_every_dot_faces_where_its_normal_points(opened, prepared):
    facing = opened.run("return Array.from(normals(dots.u, dots.v, head.octahedron))")
    assert (np.reshape(facing, (-1, 3)) * prepared.normals).sum(axis=1).min() > np.cos(np.radians(2))


def test_size_of_the_dots_and_the_faint_others(opened):
    set_control(opened, "sampler", "farthest")
    set_control(opened, "percent", 2)

    def inked():
        opened.run("drawNow()")
        image = picture(opened)[100:600, :600]
        return coloured(image), int((image.min(axis=2) < 0.97).sum())

    dots, all_ink = inked()
    set_control(opened, "size", 3)
    assert inked()[0] > 2 * dots
    opened.run("element('pale').click()")
    assert inked()[1] < all_ink / 2


def test_keys(opened):
    set_control(opened, "sampler", "uniform")
    opened.run("drawNow()")
    step, wanted = np.sin(0.12), {"\ue012": (2, -1), "\ue014": (2, 1), "\ue013": (5, 1), "\ue015": (5, -1)}
    for key, (place, sign) in wanted.items():  # what lies in front goes to the left, right, up, down
        opened.press("#canvas", "0" + key)
        assert np.isclose(opened.run("return view.turn")[place], sign * step)
    for key, factor in {"+": 1.15, "=": 1.15, "-": 1 / 1.15}.items():
        opened.press("#canvas", "0" + key)
        assert np.isclose(opened.run("return view.zoom"), factor)
    opened.press("#canvas", "0")
    assert opened.run("return [view.zoom, ...view.turn]") == [1, 1, 0, 0, 0, 1, 0, 0, 0, 1]
    before = opened.run("return Array.from(view.shown)")
    opened.press("#canvas", "n")
    after = opened.run("return Array.from(view.shown)")
    assert len(after) == len(before) and after != before


def test_two_fingers_the_wheel_and_shift(opened):
    opened.pinch("#canvas", 40, 80)
    assert np.isclose(opened.run("return view.zoom"), 2, rtol=0.05)
    assert np.allclose(opened.run("return view.turn"), np.eye(3).ravel())
    opened.press("#canvas", "0")
    opened.pinch("#canvas", 40, 40, aside=50)
    reached = opened.run("return [...view.shift, scene.perPixel(view) * canvas.width / canvas.clientWidth]")
    assert np.allclose(reached[:2], [50 * reached[2], 0], rtol=0.05, atol=1e-6)
    opened.press("#canvas", "0")
    set_control(opened, "sampler", "all")
    opened.run("drawNow()")
    opened.point("#canvas", (0, 0))
    middle = opened.run("return view.picked")
    opened.run("pick(-1)")
    opened.point("#canvas", (0, 0), (20, 50), held="\ue008")
    assert np.allclose(opened.run("return view.shift"), [20 * reached[2], -50 * reached[2]], rtol=0.05)
    assert np.allclose(opened.run("return view.turn"), np.eye(3).ravel())
    assert opened.run("return view.picked") == -1  # a press that moved picks nothing
    opened.point("#canvas", (20, 50))
    assert opened.run("return view.picked") == middle >= 0
    opened.press("#canvas", "0")
    opened.wheel("#canvas", -100)
    assert opened.run("return view.zoom") > 1.1


def test_pick_turn_zoom_by_mouse_finger_and_keys(opened, prepared):
    set_control(opened, "sampler", "all")
    opened.run("drawNow()")
    sharp, pixel, disc = opened.run(
        "return [canvas.width / canvas.clientWidth, scene.perPixel(view), radius()]"
    )  # pixels of the canvas in one of the screen, Å in one of the canvas
    points = prepared.points - (prepared.points.min(axis=0) + prepared.points.max(axis=0)) / 2
    gap = np.linalg.norm(points[:, :2] - np.array([5, -5]) * sharp * pixel, axis=1)
    hit = (gap < max(disc, 7 * pixel)) & (prepared.normals[:, 2] > 0.12)
    assert hit.sum() > 1
    for kind in ("mouse", "touch"):
        opened.run("pick(-1)")
        opened.point("#canvas", (5, 5), kind=kind)
        dot = opened.run("return view.picked")
        assert dot == np.argmax(np.where(hit, points[:, 2] - gap, -np.inf))  # the one in front
        said = text_of(opened, "picked")
        assert said.startswith(f"Dot {dot}, {RESIDUES[dot % 2]}, {viewer.KINDS[dot % 3]}, R_i = ")
        assert abs(float(said.split("R_i = ")[1][:4]) - prepared.roughness[dot]) < 0.008
    opened.point("#canvas", (0, 0), (60, 20))
    turned = opened.run("return view.turn")
    assert np.allclose(np.reshape(turned, (3, 3)) @ np.reshape(turned, (3, 3)).T, np.eye(3), atol=1e-9)
    assert turned[2] > 0.4  # what lay in front went to the right
    opened.press("#canvas", "0\ue014+")  # back, arrow to the right, nearer
    assert np.isclose(opened.run("return view.turn[2]"), np.sin(0.12))
    assert opened.run("return view.zoom") > 1


def test_saved_picture_is_not_empty(opened):
    set_control(opened, "sampler", "all")
    opened.run(
        "HTMLAnchorElement.prototype.click = function () { window.saved = [this.download, this.href] }"
    )
    for save in (lambda: opened.click("#save"), lambda: opened.press("#canvas", "s")):
        opened.run("window.saved = null")
        save()
        name, data = opened.run("return saved")
        assert name == "blob_c1.png" and data.startswith("data:image/png;base64,")
        path = opened.folder / "saved.png"
        path.write_bytes(base64.b64decode(data.split(",")[1]))
        image = matplotlib.image.imread(path)[..., :3]
        assert coloured(image) > 20_000
        assert (image[-40:] < 0.5).any()  # the line below it


def test_inside_the_frame_of_a_report(browser, path, tmp_path):
    inner = base64.b64encode(path.read_bytes()).decode()
    outer = tmp_path / "outer.html"
    outer.write_text(
        f'<iframe style="width:900px;height:600px" src="data:text/html;charset=utf8;base64,{inner}"></iframe>'
    )
    browser.open(outer.as_uri())
    browser.frame(0)
    browser.wait_for("document.getElementById('shown').textContent.includes('dots (')")
    set_control(browser, "sampler", "paper")
    count = browser.run("return view.shown.length")
    set_control(browser, "alpha", 0.2)
    assert browser.run("return view.shown.length") < count
    browser.run("drawNow()")
    browser.frame(None)
    assert coloured(picture(browser)) > 3000
    assert browser.complaints() == []


def test_a_small_screen_needs_no_sideways_scrolling(opened):
    opened.screen(400, 800)
    try:
        set_control(opened, "sampler", "paper")
        wide = opened.run("return [document.documentElement.scrollWidth, window.innerWidth]")
        assert wide[0] <= wide[1] == 400
        assert opened.run("return element('canvas').clientHeight") > 200
        assert opened.run("return element('canvas').clientWidth") > 0.9 * wide[1]  # the controls stand below
        ends = "return ['alpha', 'delta', 'sampler', 'save'].map((id) => element(id).getBoundingClientRect().right)"
        assert max(opened.run(ends)) <= 400
    finally:
        opened.screen(None, None)


def test_a_page_without_a_study_shows_the_surface_alone(browser, prepared, tmp_path):
    order = {
        "farthest": np.arange(1, len(prepared.points), 2)
    }  # a surface too large for a page: half of its dots
    near = viewer.Values("propensity", "propensity", "", prepared.points[:, 0], "likely", "unlikely")
    text = viewer.page(
        "partner",
        prepared.surface,
        prepared.roughness,
        prepared.cover,
        4.0,
        order,
        values=[near],
        opens=("all", 1),
    )
    (tmp_path / "view.html").write_text(text)
    browser.open((tmp_path / "view.html").as_uri())
    browser.wait_for("document.getElementById('shown').textContent.includes('dots (')")
    assert "likely" in text_of(browser, "legend")  # what it was asked to open with
    assert text_of(browser, "shown").endswith("The page holds the first 1,500 of 3,000 dots.")
    browser.point("#canvas", (5, 5))
    dot = 2 * browser.run("return view.picked") + 1
    x = prepared.points[:, 0]
    said = text_of(browser, "picked")
    assert said.startswith(f"Dot {dot}, ")
    assert abs(float(said.split("propensity = ")[1][:-1].replace("−", "-")) - x[dot]) < np.ptp(x) / 254
    set_control(browser, "sampler", "paper")
    assert "dots (" in text_of(browser, "shown") and text_of(browser, "nearest") == ""
    assert browser.complaints() == []


def test_a_surface_without_structure_and_grid_values(prepared, grid):
    bare = Surface(prepared.points, prepared.normals)
    order = {"farthest": np.arange(len(bare))}
    table = grid[0].assign(d_kept=np.nan)
    text = viewer.page(
        "bare",
        bare,
        prepared.roughness,
        prepared.cover,
        4.0,
        order,
        table,
        tables.best_combinations(*grid, 50),
    )
    header, columns = unpacked(text.split('PACKED = "')[1].split('"')[0])
    assert "kind" not in columns and "residue" not in columns
    assert header["grid"][0][7] is None
    assert pd.isna(table["d_kept"]).all()


def test_the_page_holds_the_numbers_of_the_tables(prepared, grid):
    height = viewer.Values("height", "z", " Å", prepared.points[:, 2], "low down", "high up")
    text, order = write(prepared, grid, [height])
    header, columns = unpacked(text.split('PACKED = "')[1].split('"')[0])
    table, points, cover = grid[0], prepared.points, prepared.cover
    assert (header["total"], header["stored"], header["radius"]) == (3000, 3000, prepared.r_patch)
    places = np.column_stack([columns[axis] for axis in "xyz"]) * header["step"]
    assert np.allclose(places, points, atol=1e-9)
    wanted = [f"{name}_{reading}" for reading in ("kept", "full") for name in ("Z_tS", "Z_tR", "d")]
    assert np.allclose(header["grid"], table[[*PARAMETERS, "n_S_percent", *wanted]], rtol=1e-4, atol=1e-12)
    assert len(header["readings"]) == 2 and header["readings"][0] != header["readings"][1]
    assert list(header["samplers"])[:2] == ["minimal", "farthest"] and list(header["samplers"])[-2:] == [
        "paper",
        "all",
    ]
    assert header["samplers"]["paper"] == "paper's sampling"
    best = tables.best_combinations(*grid, 50)
    presets = dict(map(tuple, ((name, tuple(values)) for name, values in header["presets"])))
    assert presets.pop("the paper's best") == (1, 0, 6, 0)
    for reading in ("kept", "full"):
        row = best[reading]["unrestricted"]
        (name,) = [
            each for each in presets if each.startswith("best, ") and each.endswith(reading_words(reading))
        ]
        assert presets[name] == tuple(row[p] for p in PARAMETERS)
    assert f"3,000 dots, mean roughness {prepared.roughness.mean():.2f}." in text
    rough, z = header["values"]
    assert (rough["symbol"], rough["low is"], rough["high is"]) == ("R_i", "rough", "flat")
    assert (z["low"], z["high"], z["low is"], z["high is"]) == (
        points[:, 2].min(),
        points[:, 2].max(),
        "low down",
        "high up",
    )
    steps = z["low"] + np.array(columns["value 1"]) / 254 * (z["high"] - z["low"])
    assert np.abs(steps - points[:, 2]).max() <= (z["high"] - z["low"]) / 254 / 2 + 1e-9
    assert header["stops"][0] == [68, 1, 84] and header["stops"][-1] == [253, 231, 36]  # viridis
    assert [name for name, _ in header["kinds"]] == ["contact", "saddle", "concave", "unknown kind"]
    assert header["kinds"][3][1] == ply.GREY.tolist()
    assert [rgb for _, rgb in header["kinds"][:3]] == ply.KIND_COLOURS[:3].tolist()
    assert columns["kind"] == (np.arange(3000) % 3).tolist()
    assert min(columns["residue"]) == 0  # every atom is known
    assert [header["residues"][k] for k in columns["residue"][:2]] == RESIDUES
    assert [order[rank] for rank in range(5)] == [columns["rank farthest"].index(rank) for rank in range(5)]
    assert np.flatnonzero(columns["minimal"]).tolist() == MINIMAL
    assert columns["centre"] == cover.centre.tolist() and columns["size"] == np.diff(cover.start).tolist()
    assert np.allclose(np.array(columns["centreR"]) / viewer.CENTRE_STEPS, cover.roughness, atol=1e-7)
    origin = np.column_stack([columns[axis] for axis in ("ox", "oy", "oz")]) * header["step"]
    assert np.allclose(origin, points[cover.origin], atol=1e-9)
    ends = np.cumsum(columns["size"])
    for k in range(len(cover.centre)):
        own = columns["pair"][ends[k] - columns["size"][k] : ends[k]]
        assert own == sorted(cover.dot[cover.start[k] : cover.start[k + 1]].tolist())


SETTINGS = {
    "patches": {"R_patch": 4.0, "R_zernike": 6.0, "D_link": 1.5},
    "sampling": {"distance_from_moved_centre": True, "chance_in_every_patch": True},
    "seed": 1,
}


def test_dots_are_coloured_by_their_distance_from_the_recovered_surface(prepared, tmp_path, monkeypatch):
    inputs = {
        name: str(tmp_path / name) for name in ("surface", "roughness", "minimal", "grid", "best", "fields")
    }
    points, normals = prepared.points[MINIMAL], prepared.normals[MINIMAL]
    minimal = pd.DataFrame(np.hstack([points, normals]), columns=["x", "y", "z", "nx", "ny", "nz"])
    for name, table in {
        "roughness": pd.DataFrame({"roughness": prepared.roughness}),
        "minimal": minimal.assign(dot=MINIMAL, weight=len(prepared.points) / len(MINIMAL)),
        "grid": minimal,
    }.items():
        table.to_csv(inputs[name], index=False)
    potential = np.linspace(-1, 1, len(prepared.points))
    write_npz(inputs["surface"], replace(prepared.surface, fields={"component": potential * 0}))
    with open(inputs["fields"], "wb") as stream:
        np.savez(stream, potential=potential)
    Path(inputs["best"]).write_text('{"combinations": 3}')
    required_dots = [
        ("turned", "recovered", 2),
        ("fresh dots", "full", 50),
        ("fresh dots", "recovered", 8.2),
    ]
    inputs["required_dots"] = str(tmp_path / "required_dots")
    pd.DataFrame(required_dots, columns=["floor", "reading", "n_S_percent"]).assign(
        n_S_percent_low=7.5, n_S_percent_high=9.3, bound=""
    ).to_csv(inputs["required_dots"], index=False)
    shown = []
    monkeypatch.setattr(draw_view, "residue_labels", lambda _: RESIDUES)
    monkeypatch.setattr(draw_view, "distance_to_recovered", lambda dots, kept, *_: len(dots) / len(kept))
    words = []
    monkeypatch.setattr(
        draw_view,
        "viewer_page",
        lambda *given, says, turn: shown.append(given) or words.extend([says, turn]) or "the page",
    )
    draw, drawn = draw_view.render.draw_surface, []
    monkeypatch.setattr(
        draw_view.render, "draw_surface", lambda *given: drawn.append(given[2]) or draw(*given)
    )
    outputs = {"page": tmp_path / "view.html", "picture": tmp_path / "view.png"}
    rules = {"distance_from_moved_centre": True, "chance_in_every_patch": True, "seed": SETTINGS["seed"]}
    draw_view.main(
        **inputs,
        structure=None,
        **outputs,
        patches=SETTINGS["patches"],
        minimal_settings={"floor": "fresh dots"},
        **rules,
        name="p/c1",
        title="p",
        threads=1,
    )
    assert words[0] == "8.2 % of the dots are enough (7.5 to 9.3 %)"
    np.testing.assert_array_equal(words[1], render.along_smallest_axis(prepared.points))
    image = np.asarray(Image.open(tmp_path / "view.png"))
    black = np.argwhere((image == 0).all(axis=2))
    camera = render.aim(
        prepared.points, render.along_smallest_axis(prepared.points), draw_view.PICTURE_PIXELS
    )
    assert np.ptp(black[:, 1]) + 1 == round(10 * camera.scale) and np.ptp(black[:, 0]) == 1  # 10 Å
    assert (tmp_path / "view.html").read_text() == "the page"
    assert shown[0][0] == "p"
    (values, field), dots = shown[0][-2:]
    assert (field.name, field.symbol, field.unit) == ("electrostatic potential", "potential", " kT/e")
    np.testing.assert_array_equal(field.values, potential)
    assert (values.values, values.unit, values.low_is, values.high_is) == (1000, " Å", "on it", "off")
    assert list(dots) == MINIMAL
    (orders,) = [given for given in shown[0] if isinstance(given, dict) and "farthest" in given]
    few = sparsurf.minimal(prepared.surface, n_dots=20, d_link=1.5, seed=SETTINGS["seed"])
    assert sorted(orders["farthest"][:20]) == sorted(few.dots)  # those of minimal.csv
    low, high = draw_view.render.ROUGHNESS_LIMITS
    wanted = matplotlib.colormaps["viridis"](((prepared.roughness - low) / (high - low)).clip(0, 1))[:, :3]
    np.testing.assert_allclose(drawn[0], wanted, atol=1 / 255)  # of whole numbers, cut off


def test_partners_lie_side_by_side_coloured_by_propensity_and_gap(prepared, tmp_path, monkeypatch):
    inputs = {name: str(tmp_path / name) for name in ("surface_1", "surface_2", "dots", "agreement")}
    for side in (1, 2):
        write_npz(inputs[f"surface_{side}"], prepared.surface)
    dots = pd.DataFrame({"partner": np.repeat([1, 2], 3000)})
    up, down = prepared.points[:, 2] > 5, prepared.points[:, 2] < -5
    dots["interface"] = np.concatenate([up, down]).astype(int)
    dots["propensity_smoothed"] = np.tile(np.linspace(9, 6, 3000), 2) * dots["partner"]
    dots.assign(gap=10 * dots["partner"]).to_csv(inputs["dots"])
    pd.DataFrame(columns=["partner", "score"]).to_csv(inputs["agreement"], index=False)
    shown = []
    monkeypatch.setattr(draw_pair, "coloured_page", lambda *given: shown.append(given) or "page")
    monkeypatch.setattr(draw_pair, "book_figure", lambda *_: layout.sheet(9, 9))  # see test_drawn_surfaces.py
    monkeypatch.setattr(draw_pair, "residue_labels", lambda structure: ["VAL 1 A", structure])
    rest = {"structure_1": "a", "structure_2": "b", "png": str(tmp_path / "book.png"), "seed": 1, "name": "x"}
    draw_pair.main(**inputs, **rest, view=str(tmp_path / "view.html"), patches=SETTINGS["patches"])
    [(_, _, both, _, _, values, labels)] = shown
    for side, touching in enumerate((up, down)):
        front = both.normals[side * 3000 :][:3000][touching].mean(axis=0)
        assert front[2] > 0.95 * np.linalg.norm(front)  # the interface faces the viewer
    assert both.points[3000:, 0].min() - both.points[:3000, 0].max() == pytest.approx(draw_pair.GAP)
    assert labels == ["VAL 1 A, partner 1", "a, partner 1", "VAL 1 A, partner 2", "b, partner 2"]
    atoms = Surface(prepared.points, prepared.normals, atom=np.zeros(3000, int))
    for n_atoms, expected in (([2, 1], [0, 2]), ([0, 1], [-1, 0]), ([2, 0], [0, -1])):  # 0: a ready surface
        joined = draw_pair.side_by_side([atoms, atoms], [np.eye(3)] * 2, n_atoms)
        assert joined.atom[[0, 3000]].tolist() == expected
    found = [(one.values[[0, 3000]].tolist(), one.low_is, one.high_is) for one in values]
    assert found == [([100, 100], "good match", "poor match"), ([10, 20], "touching", "far")]


def test_distances_count_from_the_origin_of_a_patch(prepared):
    n = len(prepared.points)
    cover = prepared.cover._replace(origin=(prepared.cover.centre + 1) % n)
    columns = viewer.cover_columns(prepared.surface, np.arange(n), cover)
    found = np.column_stack([columns[axis] for axis in ("ox", "oy", "oz")]) * viewer.COORDINATE_STEP
    assert np.allclose(found, prepared.points[cover.origin], atol=1e-9)


def reading_words(reading):
    return READINGS[reading].words


def test_the_share_of_a_subset_is_that_of_the_whole_surface(browser, tmp_path, prepared, monkeypatch):
    """On a page that holds some of the dots only, the subset is still the part of the surface that the tables tell."""
    monkeypatch.setattr(viewer, "MAX_DOTS", 400)
    order = farthest(prepared, len(prepared.points), prepared.stream("view"))
    values = [viewer.Values("height", "z", " Å", np.full(len(order), np.nan), "low", "high")]
    text = viewer.page(
        "few", prepared.surface, prepared.roughness, prepared.cover, 4.0, {"farthest": order[:400]},
        values=values, minimal=order[:90],
    )  # fmt: skip
    (tmp_path / "few.html").write_text(text)
    browser.open((tmp_path / "few.html").as_uri())
    browser.wait_for("document.getElementById('shown').textContent.includes('dots (')")
    set_control(browser, "sampler", "minimal")
    n = len(order)
    assert f"90 of {n:,} dots ({9000 / n:.1f} %)." in text_of(browser, "shown")
    set_control(browser, "sampler", "all")
    assert "400 of 400 dots (100.0 %)." in text_of(browser, "shown")
    set_control(browser, "colour", "1")
    assert text_of(browser, "legend") == "heightunknown"
    assert browser.run("return caption()").endswith("colour: height, grey unknown")
