"""The page of a surface: what it stores, and what a real browser makes of it."""

import base64
import io
import json
from dataclasses import replace

import matplotlib.image
import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from parsed_pages import Page
from small_study import run_script, unpacked
from sparsurf.api.pages import page_of_dots, page_of_values
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.patches.readings import words_of
from sparsurf.recovery.reconstructing import distance_to_reconstructed
from sparsurf.sampling import published
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.sampling.samplers import farthest
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.formats.colours import KIND_COLOURS, ROUGHNESS_LIMITS
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.surface import Surface
from sparsurf.views.page import page
from sparsurf.views.viewer import dots as page_dots
from sparsurf.views.viewer import packing
from sparsurf.views.viewer.scene import DotValues
from sparsurf_study.analysis import grid as grids
from sparsurf_study.analysis import tables
from sparsurf_study.structures import residue_labels

COMBINATIONS = [(1, 0, 6, 0), (0.2, 0.4, 2, 1), (0.6, 1, 0, 0), (1, 0.5, 10, 10)]
MINIMAL = [5, 70, 2999]
KINDS = [0, 2, -1]  # of every three dots; -1 is unknown
RESIDUES = ["LEU 212 A", "HIS 256 A"]


@pytest.fixture(scope="module")
def prepared(blob):
    """A bumpy surface whose places have three decimals, as those of a DMS file."""
    points, normals = blob[0].round(3), blob[1]
    n = len(points)
    surface = Surface(points, normals, kind=np.array(KINDS)[np.arange(n) % 3], atom=np.arange(n) % 2)
    return PreparedSurface(surface, Settings(patches={"d_link": 1.5}), streams=Streams(0, "blob"))


@pytest.fixture(scope="module")
def grid(prepared):
    """The table of a small grid and its raw distances."""
    raw = grids.evaluate_grid(prepared, published.parameter_grid([0.5, 1], [0, 1], [0, 6], [0, 6]), 20, 2)
    return tables.grid_table(raw), raw


@pytest.fixture(scope="module")
def order(prepared):
    """Order of farthest-point sampling."""
    return farthest(prepared, len(prepared.points), prepared.stream("test"))


def page_of(prepared, order, grid=None, best=None, labels=(), values=(), minimal=(), opens="", colour=0):
    """Return the page of the surface."""
    shown = page_dots.ShownDots(
        prepared, order, minimal, opens=opens, samples=True, grid=grid, best=best or {}
    )
    return page_of_dots("blob/c1", shown, values, labels, colour=colour)


def test_columns_come_back_as_they_were():
    given = {
        "mixed": [0, -1, 5, 300, -70_000, 2**24],
        "slow": [*range(-5, 900)],
        "none": [],
        "zeros": [0, 0, 0],
    }
    packed = packing.pack({"n": 3}, {name: np.array(v, int) for name, v in given.items()})
    header, columns = unpacked(f'PACKED = "{packed}"')
    assert header["n"] == 3 and {name: values.tolist() for name, values in columns.items()} == given


def test_values_beyond_their_limits_are_at_the_ends():
    values = np.array([-1.0, 0.0, 0.5, 2.0, np.nan])
    assert packing.in_steps(values, 0.0, 1.0).tolist() == [0, 0, 127, 254, 255]
    assert packing.in_steps(values[1:2], 0.0, 0.0).tolist() == [0]


def test_dots_without_an_atom_have_no_residue(prepared, order):
    atom = np.where(np.arange(len(prepared)) % 3, prepared.surface.atom, -1)
    settings = Settings(patches={"d_link": 1.5})
    some = PreparedSurface(replace(prepared.surface, atom=atom), settings, streams=Streams(0, "blob"))
    header, columns = unpacked(page_of(some, order, None, None, RESIDUES))
    names = [None if k < 0 else header["residues"][k] for k in columns["residue"]]
    assert names == [None if k < 0 else RESIDUES[k] for k in atom]


@pytest.mark.parametrize("place", ["moving/f0000", "ready/c1"])
def test_the_page_of_a_study_holds_the_numbers_of_its_tables(study, place):
    run, folder = study / "results/small", study / "results/small" / place
    text = (folder / "view.html").read_text(encoding="utf-8")
    header, columns = unpacked(text)
    surface, best = read_npz(folder / "surface.npz"), json.loads((folder / "best.json").read_text())
    names = ("grid", "roughness", "minimal")
    table, roughness, minimal = (pd.read_csv(folder / f"{name}.csv") for name in names)
    places = np.column_stack([columns[axis] for axis in "xyz"]) * header["dots"]["step"]
    assert np.allclose(places, surface.points, atol=0.001) and header["dots"]["total"] == len(surface)
    wanted = [f"{name}_{reading}" for reading in ("kept", "full") for name in ("Z_tS", "Z_tR", "d")]
    assert np.allclose(
        header["dots"]["grid"], table[[*PARAMETERS, "n_S_percent", *wanted]], rtol=1e-4, atol=1e-12
    )
    assert header["dots"]["readings"] == [words_of(reading) for reading in ("kept", "full")]
    presets = dict((name, values) for name, values in header["dots"]["presets"])
    assert presets["the paper's best"] == [1, 0, 6, 0]
    row = best["full"]["unrestricted"]
    assert presets[f"best, {words_of('full')}"] == [row[name] for name in PARAMETERS]
    assert [header["dots"][name] for name in ("radius", "minimal", "sampler")] == [
        4.0,
        len(minimal),
        "minimal",
    ]
    assert columns["minimal"].nonzero()[0].tolist() == sorted(minimal["dot"])
    values = {scale["symbol"]: (k, scale) for k, scale in enumerate(header["values"])}
    model = pd.read_csv(folder / "recovered.csv")["reconstruction"][0]
    kept = surface.take(minimal["dot"].to_numpy())
    kept = replace(kept, reconstruction=tables.surface_of_minimal(minimal).reconstruction)
    off = np.load(folder / "reconstructed.npz")["distance"]
    by_planes = distance_to_reconstructed(surface.points, kept, model)
    # exact where the atoms are known, from which planes deviate by little
    assert np.abs(off - by_planes).mean() < 0.005
    assert np.allclose(off, by_planes, atol=1e-4) == (place == "ready/c1")
    wanted = {"R_i": roughness["roughness"], "distance": off}
    for symbol, of_dots in (wanted | dict(np.load(folder / "fields.npz"))).items():
        k, scale = values[symbol]
        steps, known = (
            scale["low"] + columns[f"value {k}"] / 254 * (scale["high"] - scale["low"]),
            np.isfinite(of_dots),
        )
        assert np.abs(steps - of_dots)[known].max() <= (scale["high"] - scale["low"]) / 254 / 2 + 1e-6
        assert (columns[f"value {k}"][~known] == 255).all()
    assert [(scale["low is"], scale["high is"]) for _, scale in values.values()][:2] == [
        ("rough", "flat"),
        ("on it", "off"),
    ]
    if "moving" in place:
        shown = [header["residues"][k] for k in columns["residue"]]
        assert shown == [residue_labels(folder / "structure.pdb")[atom] for atom in surface.atom]
        assert columns["kind"].tolist() == surface.kind.tolist()
    assert f"{len(surface):,} dots, mean roughness {roughness['roughness'].mean():.2f}." in text
    assert (run / place / "view.png").is_file()


@pytest.mark.parametrize("change", ["another order", "turned"])
def test_a_page_shows_each_dot_at_its_place_however_they_are_sorted_and_turned(prepared, order, change):
    surface, rows = prepared.surface, np.arange(len(prepared))
    if change == "turned":
        turn = Rotation.from_euler("xyz", [30, 110, 200], degrees=True)
        points, normals = turn.apply(surface.points) + np.array([30, -20, 10]), turn.apply(surface.normals)
        surface = replace(surface, points=points, normals=normals)
    else:
        rows = np.random.default_rng(1).permutation(rows)
        surface = surface[rows]
    again = PreparedSurface(surface, Settings(patches={"d_link": 1.5}), streams=Streams(0, "blob"))
    named = (None, None, RESIDUES)
    pages = page_of(prepared, order, *named), page_of(again, np.argsort(rows)[order], *named)
    (header, of_first), (of_header, of_second) = map(unpacked, pages)
    places = np.column_stack([of_second[axis] for axis in "xyz"]) * of_header["dots"]["step"]
    distance, dot = cKDTree(surface.points).query(places)
    assert distance.max() <= of_header["dots"]["step"] and len(np.unique(dot)) == len(surface)
    dot = rows[dot]  # its number on the first page
    assert header["values"][0]["symbol"] == "R_i" and np.ptp(of_first["value 0"]) > 100
    assert np.abs(of_second["value 0"] - of_first["value 0"][dot]).max() <= 1
    for name in ("kind", "residue"):
        assert np.array_equal(of_second[name], of_first[name][dot]), name


def test_the_page_of_a_pair_ranks_each_partner_and_turns_its_interface_to_the_viewer(study):
    folder = study / "results/small/pairs/files"
    header, columns = unpacked((folder / "view.html").read_text(encoding="utf-8"))
    dots = pd.read_csv(folder / "propensity.csv").iloc[columns["index"]]
    _, rank, gap = header["values"]
    assert (rank["low is"], rank["high is"], gap["low is"], gap["high is"]) == (
        "good match",
        "poor match",
        "touching",
        "far",
    )
    wanted = 100 * dots.groupby("partner")["propensity_smoothed"].rank(pct=True)
    for k, values in ((1, wanted), (2, dots["gap"])):
        scale = header["values"][k]
        steps = scale["low"] + columns[f"value {k}"] / 254 * (scale["high"] - scale["low"])
        assert np.abs(steps - values).max() <= (scale["high"] - scale["low"]) / 254
    z = pd.Series(columns["z"] * header["dots"]["step"])
    touching, partner = dots["interface"].to_numpy() == 1, dots["partner"].to_numpy()
    assert all(z[touching & (partner == side)].mean() > z[partner == side].mean() for side in (1, 2))
    assert columns["x"][partner == 2].min() > columns["x"][partner == 1].max()  # side by side
    labels = np.array(header["residues"])[columns["residue"]]
    parts = zip(*(dots[name] for name in ("residue_name", "residue", "chain", "partner")), strict=True)
    assert labels.tolist() == ["{} {} {}, partner {}".format(*each) for each in parts]


def test_the_page_of_a_form_is_grey_below_its_floor(study, tmp_path):
    run, ends = study / "results/small", (("surface", "npz"), ("structure", "pdb"))
    table = pd.read_csv(run / "changes/bend/changes.csv")
    table["total"] *= np.where(table.index % 2, 0.3, 1)
    table.to_csv(tmp_path / "changes.csv")
    places = enumerate(("moving/f0700", "moving/f0000"), 1)
    inputs = {f"{kind}_{side}": run / place / f"{kind}.{end}" for side, place in places for kind, end in ends}
    outputs = {name: tmp_path / f"{name}.png" for name in ("view_1", "view_2", "png")}
    params = Settings().model_dump(include={"surface", "patches", "sampling"})
    params |= {"forms": ["moving/f700", "moving/f0"], "seed": 1}
    inputs["changes"] = tmp_path / "changes.csv"
    run_script("draw_changes", tmp_path, inputs, outputs, params, comparison="bend")
    header, columns = unpacked(outputs["view_1"].read_text(encoding="utf-8"))
    over = table["total"] / table[["total_floor", "total_moved"]].max(axis=1)
    by_residue = dict(zip(table["residue"].astype(str), over.where(over >= 1), strict=True))
    wanted = np.array([by_residue[header["residues"][k].split()[1]] for k in columns["residue"]])
    scale, known = header["values"][1], np.isfinite(wanted)
    steps = scale["low"] + columns["value 1"] / 254 * (scale["high"] - scale["low"])
    assert np.abs(steps - wanted)[known].max() <= (scale["high"] - scale["low"]) / 254
    assert not known.all() and (columns["value 1"][~known] == 255).all() and scale["unknown is"]


def test_the_presets_are_the_best_combinations_that_there_are():
    first, few = (
        {"d": 1.0} | dict(zip(PARAMETERS, row, strict=True)) for row in ((1, 0.2, 4, 6), (0.1, 0, 8, 2))
    )
    none = {"answer": "No combination keeps so few."}
    best = {"max_n_S_percent": 20, "kept": {"unrestricted": first, "under_max_n_S": few}}
    best["full"] = {"unrestricted": few, "under_max_n_S": none}
    assert page_dots.presets(best) == [
        ("the paper's best", [1, 0, 6, 0]),
        ("best, among the kept dots", [1, 0.2, 4, 6]),
        ("best of at most 20 %, among the kept dots", [0.1, 0, 8, 2]),
        ("best, on the full surface", [0.1, 0, 8, 2]),
    ]


def test_a_large_surface_shows_as_many_dots_as_fit(order, prepared, monkeypatch):
    kept, whole = order[[2, 70, 700]], page_of(prepared, order)
    monkeypatch.setattr(page, "MAX_BYTES_IN_REPORT", len(whole.encode()) - 25_000)
    text = page_of(prepared, order, minimal=kept)
    header, columns = unpacked(text)
    of_dots, all_dots = header["dots"], unpacked(whole)[0]["dots"]
    assert len(text.encode()) <= len(whole.encode()) - 25_000 and of_dots["total"] == 3000
    assert columns["index"][columns["minimal"] == 1].tolist() == sorted(kept)
    assert 700 < of_dots["stored"] < 3000 and {*columns["index"]} == {*order[: of_dots["stored"]]}
    apart = of_dots["spacing"] / all_dots["spacing"]  # so that fewer dots are larger
    assert apart == pytest.approx(np.sqrt(3000 / of_dots["stored"]), rel=0.2) and apart > 1.03


def test_distances_count_from_the_origin_of_a_patch(prepared):
    n = len(prepared.points)
    cover = prepared.cover._replace(origin=(prepared.cover.centre + 1) % n)
    columns = page_dots.cover_columns(prepared.surface, np.arange(n), cover)
    found = np.column_stack([columns[axis] for axis in ("ox", "oy", "oz")]) * page_dots.COORDINATE_STEP
    assert np.allclose(found, prepared.points[cover.origin], atol=1e-9)


def test_a_page_of_some_dots_has_the_patches_of_these_dots(prepared, order):
    """By a list for each patch: its dots that are shown, by their place on the page, and -1 for a centre that is not."""
    dots, cover = np.sort(order[:700]), prepared.cover
    columns = page_dots.cover_columns(prepared.surface, dots, cover)
    place = {dot: k for k, dot in enumerate(dots.tolist())}
    assert columns["centre"].tolist() == [place.get(dot, -1) for dot in cover.centre.tolist()]
    patches = [cover.dot[a:b].tolist() for a, b in zip(cover.start[:-1], cover.start[1:], strict=True)]
    wanted = [sorted(place[dot] for dot in patch if dot in place) for patch in patches]
    assert columns["size"].tolist() == [*map(len, wanted)] and np.array_equal(
        columns["pair"], np.concatenate(wanted)
    )
    assert np.allclose(columns["centreR"] / page_dots.CENTRE_STEPS, cover.roughness, atol=1e-6)
    few = order[:50]
    _, shown = unpacked(page_of(prepared, order, minimal=few))
    ranks = shown["rank farthest"]
    assert [int(np.flatnonzero(ranks == k)[0]) for k in range(50)] == few.tolist()


@pytest.fixture(scope="module")
def path(prepared, order, grid, tmp_path_factory):
    """The page as a file, with a colour of which some values are unknown."""
    depth = np.where(np.arange(len(prepared.points)) % 7 == 0, np.nan, prepared.points[:, 2])
    values = [DotValues("height above the middle", "z", " Å", depth, "low", "high")]
    path = tmp_path_factory.mktemp("page") / "view.html"
    best = tables.best_combinations(*grid, 50)
    path.write_text(text := page_of(prepared, order, grid[0], best, RESIDUES, values, MINIMAL))
    assert not Page(text).sources and "@import" not in text
    return path


@pytest.fixture
def opened(browser, path):
    """The page, freshly loaded, in a smaller window; it loads nothing else."""
    browser.screen(1000, 700, telephone=False)
    browser.view(path)
    yield browser
    assert browser.run("return performance.getEntriesByType('resource').map(({ name }) => name)") == []


def choose(browser, **controls):
    """Move controls as a user does: value, then its event; return the dots that are shown then."""
    for name, value in controls.items():
        browser.run(
            "const e = document.getElementById(arguments[0]); e.value = arguments[1];"
            "e.dispatchEvent(new Event('input', {bubbles: true}))", name, str(value),
        )  # fmt: skip
    return browser.run("return Array.from(view.shown)")


def text_of(browser, name):
    return browser.run("return document.getElementById(arguments[0]).textContent", name)


def picture(browser):
    """The drawn part of the window, (rows, columns, 3)."""
    browser.run("viewer.render()")
    return matplotlib.image.imread(io.BytesIO(browser.screenshot()))[100:, :600, :3]


def coloured(image):
    """Number of pixels that are neither white nor grey."""
    return int((np.ptp(image, axis=2) > 0.15).sum())


class Given:
    """Hands the library the numbers of the page: -ln of xorshift's."""

    def __init__(self, count, seed, order):
        mask, numbers, self.at = 0xFFFFFFFF, [], 0
        state = ((seed + 1) * 0x9E3779B1 & mask) | 1
        for _ in range(count):
            state ^= state << 13 & mask
            state ^= state >> 17
            state ^= state << 5 & mask
            numbers.append(-np.log((state + 0.5) / 2**32))
        self.numbers = np.empty(count)
        self.numbers[order] = numbers

    def standard_exponential(self, out):
        out[:], self.at = self.numbers[self.at : self.at + len(out)], self.at + len(out)


def test_the_page_keeps_the_dots_that_the_library_keeps(opened, prepared):
    cover = prepared.cover
    owner = np.repeat(np.arange(len(cover.centre)), np.diff(cover.start))
    by_patch = np.lexsort((cover.dot, owner))
    for seed in (1, 2):
        for combination in COMBINATIONS:
            shown = choose(opened, sampler="paper", **dict(zip(PARAMETERS, combination, strict=True)))
            wanted = published.sample_cover(cover, combination, Given(len(cover.dot), seed, by_patch))
            assert shown == wanted.tolist() and f"{len(wanted):,} of 3,000 dots" in text_of(opened, "shown")
        opened.run("document.getElementById('again').click()")


def test_other_samplers_show_the_number_that_is_asked_for(opened, order):
    assert choose(opened) == MINIMAL  # what the page opens with
    for percent in (10, 50):
        assert choose(opened, sampler="farthest", percent=percent) == order[: 30 * percent].tolist()
    first = choose(opened, sampler="uniform")
    assert len({*first}) == len(first) == 1500 and max(first) < 3000
    opened.press("#stage", "n")
    again = choose(opened)
    assert len(again) == 1500 and again != first


def test_the_nearest_combination_of_the_grid_is_shown_with_its_numbers(opened, grid, prepared):
    rows = (
        "return [...document.querySelectorAll('#nearest tr')].map(r => [...r.cells].map(c => c.textContent))"
    )
    for asked, nearest in (((0.9, 0.2, 5, 1), [1, 0, 6, 0]), ((0.6, 0.8, 2, 8), [0.5, 1, 0, 6])):
        choose(opened, sampler="paper", **dict(zip(PARAMETERS, asked, strict=True)))
        row = grid[0][(grid[0][PARAMETERS] == nearest).all(axis=1)].iloc[0]
        wanted = [["reading", "ZtS", "ZtR", "d"]]
        for reading in ("kept", "full"):
            numbers = [f"{row[f'{name}_{reading}']:.2f}".replace("-", "−") for name in ("Z_tS", "Z_tR", "d")]
            wanted.append([words_of(reading), *numbers])
        assert opened.run(rows) == wanted
        assert f"({', '.join(map(str, nearest))}), nS {row['n_S_percent']:.1f} %" in text_of(
            opened, "nearest"
        )
    best = tables.best_combinations(*grid, 50)
    height = prepared.points[np.arange(3000) % 7 > 0, 2]
    choose(opened, colour="value 1")
    for place, key in ((2, "under_max_n_S"), (1, "unrestricted")):  # of the kept dots
        choose(opened, presets=place)
        wanted = [best["kept"][key][name] for name in PARAMETERS]
        assert opened.run("return LAW.map((name) => +element(name).value)") == wanted
        law = ", ".join(f"{value:g}" for value in wanted)
        said = opened.run("return caption().join(' ')").replace("−", "-")  # below the saved picture
        assert (
            f"({law}); colour: height above the middle, from {height.min():.2f} Å low to {height.max():.2f} Å high, grey unknown"
            in said
        )
    opened.run(
        "slide(element('alpha'), 0.0123); slide(element('gamma'), 12)"
    )  # beyond ends and between steps
    assert opened.run("return [+element('alpha').value, +element('gamma').value]") == [0.0123, 12]
    choose(opened, presets=0)  # the paper's best moves all sliders
    assert opened.run("return LAW.map((name) => element(name).value)") == ["1", "0", "6", "0"]
    assert "(1, 0, 6, 0)" in text_of(opened, "nearest")


def test_every_dot_has_the_colour_of_its_value(opened, prepared):
    """Grey where it is unknown; viridis is brighter the higher the value, so that it reads without colour vision."""
    painted = "const colour = coloursOfDots(); return [...Array(3000).keys()].map((i) => colour(i))"
    height = np.where(np.arange(3000) % 7 == 0, np.nan, prepared.points[:, 2])
    for colour, values, limits, unit, ends in (
        (0, prepared.roughness, ROUGHNESS_LIMITS, "", ("rough", "flat")),
        (1, height, (np.nanmin(height), np.nanmax(height)), " Å", ("low", "high")),
    ):
        choose(opened, colour=f"value {colour}")
        shown = np.array(opened.run(painted))
        known, (low, high) = np.isfinite(values), limits
        wanted = 255 * matplotlib.colormaps["viridis"]((values[known] - low) / (high - low))[:, :3]
        assert np.abs(shown[known] - wanted).max() < 7  # 16 colours in between which it is interpolated
        assert (shown[~known] == 165).all()
        said = "".join(f"{value:.2f}{unit} {end}" for value, end in zip((low, high), ends, strict=True))
        legend = text_of(opened, "legend")
        assert legend.endswith((said + "unknown" * bool((~known).any())).replace("-", "−"))
    choose(opened, colour="kind")
    wanted = np.where(prepared.surface.kind[:, None] < 0, 160, KIND_COLOURS[prepared.surface.kind])
    assert np.abs(np.array(opened.run(painted)) - wanted).max() <= 1
    assert text_of(opened, "legend") == "kind of dotcontactconcaveunknown kind"  # no dot is saddle-shaped


def test_a_dot_is_picked_by_mouse_and_finger_and_told(opened, prepared):
    choose(opened, sampler="farthest", percent=20)
    places = "return viewer.modelToScreen(view.shown.map((i) => dots.places[i])).map(({ x, y }) => [x - scrollX, y - scrollY])"
    opened.run("element('stage').scrollIntoView()")
    box = "const box = element('stage').getBoundingClientRect(); return [box.left + box.width / 2, box.top + box.height / 2]"
    flat, shown = np.array(opened.run(places)) - opened.run(box), np.array(choose(opened))
    facing = prepared.normals[shown] @ np.reshape(opened.run("return head.turn"), (3, 3))[2]
    depth = prepared.points[shown] @ np.reshape(opened.run("return head.turn"), (3, 3))[2]
    tried = np.flatnonzero((facing > 0.8) & (depth > np.quantile(depth, 0.8)))[:6]
    for kind in ("mouse", "touch"):
        for k in tried:
            opened.run("pickDot(-1)")
            opened.point("#stage", np.rint(flat[k]).astype(int).tolist(), kind=kind)
            dot = opened.run("return view.picked")
            near = shown[np.linalg.norm(flat - flat[k], axis=1) < 4]
            assert dot in near, (kind, k)
            said = text_of(opened, "picked")
            assert said.startswith(f"Dot {dot}, {RESIDUES[dot % 2]}, ")
            assert abs(float(said.split("Ri = ")[1][:4]) - prepared.roughness[dot]) < 0.008
    z = prepared.points[:, 2]
    for other in (1, 2, 7):  # with one of each residue, an unknown kind and an unknown value
        said = opened.run("pickDot(arguments[0]); return element('picked').textContent", other)
        kind = {0: "contact, ", 2: "concave, ", -1: "unknown kind, "}[KINDS[other % 3]]
        assert said.startswith(
            f"Dot {other}, {RESIDUES[other % 2]}, {kind.replace('unknown kind, ', '')}Ri = "
        )
        value = said.split("z = ")[1].replace("−", "-")
        assert (
            value == "unknown."
            if other == 7
            else abs(float(value.split(" Å.")[0]) - z[other]) < np.ptp(z) / 254
        )
    choose(opened, sampler="minimal")
    assert opened.run("return view.picked") in (-1, *MINIMAL)  # it is shown no longer


def test_the_wheel_and_the_mouse_turn_the_picture(opened):
    state = "return viewer.getView()"
    home = opened.run(state)
    for act in (lambda: opened.wheel("#stage", -100), lambda: opened.point("#stage", (0, 0), (60, 20))):
        act()
        assert not np.allclose(opened.run(state), home, atol=1e-3)
        opened.press("#stage", "0")
        assert np.allclose(opened.run(state), home, atol=1e-3)


def test_the_picture_shows_what_is_chosen_and_can_be_saved(opened):
    choose(opened, sampler="all", colour="kind")
    whole = coloured(picture(opened))
    choose(opened, sampler="farthest", percent=5)
    few = picture(opened)
    assert coloured(few) < whole / 2 > 10_000
    choose(opened, size=3)
    assert coloured(picture(opened)) > 1.5 * coloured(few)
    choose(opened, opacity=20)
    assert (picture(opened).min(axis=2) < 0.8).sum() < (few.min(axis=2) < 0.8).sum()
    opened.run(
        "HTMLAnchorElement.prototype.click = function () { window.saved = [this.download, this.href] }"
    )
    opened.click("#save")
    opened.wait_for("window.saved")
    name, data = opened.run("return saved")
    image = matplotlib.image.imread(io.BytesIO(base64.b64decode(data.split(",")[1])))[..., :3]
    assert name == "blob_c1.png" and coloured(image) > 1000 and (image[-40:] < 0.5).any()  # the line below it


def test_the_picture_has_the_colour_of_the_page_and_is_saved_on_white(opened):
    choose(opened, sampler="farthest", percent=5)
    for scheme, paper in (("dark", (13, 17, 23)), ("light", (255, 255, 255))):
        opened.media(scheme)
        assert (np.abs(255 * picture(opened)[5, 5] - paper) < 2).all()
        corner = "return picture().then((out) => [...out.getContext('2d').getImageData(2, 2, 1, 1).data])"
        assert opened.run(corner) == [255] * 4


def test_the_surface_below_the_dots_is_closed_and_lies_on_them(prepared, order):
    header, columns = unpacked(page_of(prepared, order))
    corners = np.column_stack([columns[f"{axis}0"] for axis in "xyz"]) * header["step"]
    codes = columns["triangles0"]
    triangles = (np.cumsum(codes == 0) - (codes == 0) - codes).reshape(-1, 3)
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    assert len(triangles) > 500
    a, b, c = corners[triangles].transpose(1, 0, 2)
    shares = np.array([(i, j, 8 - i - j) for i in range(9) for j in range(9 - i)]) / 8
    inside = (shares[:, None, :1] * a + shares[:, None, 1:2] * b + shares[:, None, 2:] * c).reshape(-1, 3)
    gap = cKDTree(inside).query(prepared.points)[0]
    assert np.quantile(gap, 0.99) < 0.3 and np.mean(gap) < 0.07  # Å


def test_a_small_screen_needs_no_sideways_scrolling(opened):
    opened.screen(400, 800)
    choose(opened, sampler="paper")
    assert opened.run("return [document.documentElement.scrollWidth, window.innerWidth]") == [400, 400]
    assert opened.run("return element('stage').clientHeight") > 200
    assert opened.run("return element('stage').clientWidth") > 360  # the controls stand below
    ends = (
        "return ['alpha', 'delta', 'sampler', 'save'].map((id) => element(id).getBoundingClientRect().right)"
    )
    assert max(opened.run(ends)) <= 400


def test_a_page_of_some_dots_and_no_study(browser, prepared, order):
    """Numbers are those of the whole surface: of a dot, and of the share of the subset."""
    x = 20 * prepared.points[:, 0]
    values = [DotValues("propensity", "propensity", "", x, "likely", "unlikely")]
    values += [DotValues("height", "z", " Å", np.full(3000, np.nan), "low", "high")]
    text = page_of(prepared, order[:1500], values=values, minimal=order[:90], opens="all", colour=1)
    browser.view(text)
    ends = f"propensity{x.min():.0f} likely{x.max():.0f} unlikely".replace(
        "-", "−"
    )  # without needless decimals
    assert text_of(browser, "legend") == ends  # what it was asked to open with; the ends of all 3,000 dots
    assert text_of(browser, "shown").endswith("of 3,000 dots.")
    browser.run("pickDot(700)")
    dot = sorted(order[:1500])[700]
    said = text_of(browser, "picked")
    assert said.startswith(f"Dot {dot}, ") and said.endswith("z = unknown.")
    found = float(said.split("propensity = ")[1].split(",")[0].replace("−", "-"))
    assert abs(found - x[dot]) < np.ptp(x) / 254
    choose(browser, sampler="minimal", colour="value 2")
    assert (
        "90 of 3,000 dots (3.0 %)." in text_of(browser, "shown")
        and text_of(browser, "legend") == "heightunknown"
    )
    choose(browser, sampler="farthest", percent=10)
    assert text_of(browser, "shown").startswith("150 of 1,500")
    text = page_of(prepared, order[:1500], minimal=order[1440:1560])
    browser.view(text)
    choose(browser, sampler="minimal")  # only some of its dots are on the page
    assert text_of(browser, "shown").startswith("60 of 1,500")
    choose(browser, sampler="paper")
    assert "dots (" in text_of(browser, "shown") and text_of(browser, "nearest") == ""


def test_dots_far_from_the_origin_fill_the_picture(prepared, browser):
    """No atoms lie there to look at; the picture shows as much of them as where they lie around the origin."""
    filled, surface = [], prepared.surface
    for name, shift in (("near", 0), ("x", [300, 0, 0]), ("y", [0, 300, 0]), ("z", [0, 0, 300])):
        moved = replace(surface, points=surface.points + shift)
        values = [DotValues("height", "height", " Å", surface.points[:, 2])]
        browser.view(page_of_values(name, moved, Settings(), Streams(1, name), values))
        url = browser.run("return picture().then((out) => out.toDataURL())")
        pixels = matplotlib.image.imread(io.BytesIO(base64.b64decode(url.split(",")[1])))
        filled.append((np.abs(pixels[..., :3] - pixels[0, 0, :3]).sum(axis=2) > 0.1).mean())
    assert filled[0] > 0.1 and filled[1:] == pytest.approx(3 * filled[:1], rel=0.05)
