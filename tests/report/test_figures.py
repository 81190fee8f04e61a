"""Figures draw from little data and from awkward data, their texts stay apart, files repeat byte by byte."""

import gzip
from itertools import product
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from matplotlib import rcParams
from matplotlib.image import imread

from drawn import check_texts
from sparsurf.recovery.readings import READINGS
from sparsurf.report.figures import (
    d_over_grid,
    layout,
    number_of_dots,
    required_dots,
    rough_and_flat,
    subsets,
)
from sparsurf.report.figures import frames as frames_figure
from sparsurf.report.figures import roughness as roughness_figure
from sparsurf.report.figures.required_dots import Tables as RequiredDotsTables
from sparsurf.surfaces.surface import Surface

LISTS = {"alpha": [0.2, 1], "beta": [0, 0.4, 1], "gamma": [0, 2, 10], "delta": [0, 4, 10]}


def sphere(n=400, radius=8.0):
    """Points and normals of an evenly covered sphere (golden spiral)."""
    k = np.arange(n) + 0.5
    z, turn = 1 - 2 * k / n, np.pi * (1 + 5**0.5) * k
    normals = np.column_stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z])
    return radius * normals * [1.4, 1.0, 0.8], normals


def grid(**lists):
    """A grid.csv of smooth invented numbers for 1000 dots."""
    lists = LISTS | lists
    table = pd.DataFrame(product(*lists.values()), columns=list(lists), dtype=float)
    fall = 1 + 0.1 * table.delta + 0.2 * table.gamma
    table["n_S_expected"] = 1000 * table.alpha / (1 + table.beta) / fall
    table["n_S"] = table.n_S_expected + 3.0
    table["n_S_percent"] = table.n_S / 10
    table["d_kept"] = np.sin(table.gamma + table.beta) + 0.3 * np.cos(table.delta)
    table["d_full"] = -0.2 - 0.01 * table.gamma - 0.01 * table.delta * table.beta
    ends = {
        f"d_{end}_{reading}": table[f"d_{reading}"] + sign * half
        for reading, half in (("kept", 0.2), ("full", 0.04))
        for end, sign in (("low", -1), ("high", 1))
    }
    return table.assign(**ends)


def frames(f=300, k=3, chosen=None):
    rng = np.random.default_rng(k)
    labels = np.arange(f) % k
    plane = 20 * rng.normal(size=(k, 2))[labels] + rng.normal(size=(f, 2))
    chosen = list(range(k)) if chosen is None else chosen
    names = [f"c{i + 1}" for i in range(len(chosen))]
    silhouettes = {n: 0.5 - 0.01 * n for n in range(2, 12)}
    return plane, labels, chosen, names, np.array([0.5, 0.2, 0.1]), silhouettes


def distances(n=500):
    rng = np.random.default_rng(1)
    return rng.uniform(0.1, 0.9, n), rng.uniform(0, 9, (4, n))


def patch(n=60):
    points, normals = sphere(n, 4.0)
    return "rough patch, $R_i$ = 0.21", points, normals, np.arange(0, n, 2), np.arange(0, n, 3)


def figure4(n=500, readings=("kept", "full"), roughness=None, patches=2, **kwargs):
    r, z = distances(n)
    r = r if roughness is None else roughness
    panels = [
        (f"patches around kept dots, {READINGS[name].words}", r, z[2 * (k % 2)], z[2 * (k % 2) + 1])
        for k, name in enumerate(readings)
    ]
    references = {"Z_empty": 8.6, "Z_mean_descriptor": 1.5}
    return rough_and_flat.figure(panels, [patch()] * patches, references, **kwargs)


def figure5(n=400, distance=0.02, subsets_shown=3):
    """A surface, subsets of it and itself as what is recovered, at one distance."""
    points, normals = sphere(n)
    whole = Surface(points, normals)
    kept = [slice(0, None, 2), slice(1, None, 2), slice(0, None, 9)][:subsets_shown]
    titles = ["the paper's best, (1, 0, 6, 0)", "uniform subset of the same size", "a title " * 8]
    cells = [
        (title, Surface(points[own], normals[own]), layout.PALETTE[k])
        for k, (title, own) in enumerate(zip(titles, kept, strict=False))
    ]
    return subsets.figure(whole, cells, ("recovered", whole, np.full(n, distance)), "p/c1")


def figure1(n=400):
    return roughness_figure.figure(*sphere(n), np.linspace(0.2, 0.9, n))


LACKING = grid().assign(d_kept=np.nan, d_se_full=np.nan)
HOLES = grid().assign(d_kept=lambda t: t.d_kept.where((t.gamma != 2) | (t.delta != 4)))
FINE = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10]


def surface_tables(name="p/c1", factor=1.0, rows=200, floors=("fresh dots", "turned", "atoms moved 0.1 Å")):
    """Tables of one surface whose Z falls as n_S grows; recovered, it is enough at 8 %."""
    rng, percent = np.random.default_rng(0), np.array([1.0, 2, 4, 8, 20, 50, 90])
    n = rng.uniform(4, 98, rows)
    grid = pd.DataFrame(
        {"n_S_percent": n, "Z_tS_full": factor * (2.4 - np.log10(n) + 0.1 * rng.random(rows))}
    )
    curves = [
        pd.DataFrame({"sampler": sampler, "reading": reading, "n_S_percent": percent})
        .assign(Z=lambda t, start=start: factor * np.maximum(start - np.log10(t["n_S_percent"]), 0.5))
        for sampler, reading, start in (
            ("farthest", "full", 2.0), ("farthest", "recovered", 1.4), ("uniform", "full", 2.3),
        )
    ]  # fmt: skip
    levels = pd.DataFrame({"floor": floors, "Z": factor * np.linspace(0.5, 0.9, len(floors))})
    required_dots = levels.rename(columns={"Z": "Z_floor"}).assign(
        reading="recovered", n_S_percent=8.0, Z=0.5 * factor
    )
    required_dots["bound"] = np.nan
    return RequiredDotsTables(name, pd.concat(curves), levels, required_dots, grid if rows else None)


CASES = {
    "frames": lambda: frames_figure.frames_projection(*frames()),
    "frames, 11 clusters": lambda: frames_figure.frames_projection(*frames(k=11)),
    "frames, 2 clusters side by side": lambda: frames_figure.frames_projection(
        *frames(k=2, chosen=[0, 2, 4])
    ),
    "frames, 1 cluster": lambda: frames_figure.frames_projection(*frames(k=1)),
    "frames, every frame": lambda: frames_figure.frames_projection(*frames(f=40, chosen=list(range(40)))),
    "frames, 1 frame, 1 component": lambda: frames_figure.frames_projection(
        [[0.0]], [0], [0], ["c1"], [1.0], {}
    ),
    "frames, nothing known": lambda: frames_figure.frames_projection(np.eye(3), [0, 0, 1], [], [], [], {}),
    "1": figure1,
    "1, 30 dots": lambda: figure1(30),
    "1, constant": lambda: roughness_figure.figure(*sphere(50), np.full(50, 0.5)),
    "2": lambda: number_of_dots.figure(grid()),
    "2, fine": lambda: number_of_dots.figure(grid(gamma=FINE, delta=FINE)),
    "2, long labels": lambda: number_of_dots.figure(
        grid(beta=[0, 1, 2, 3, 4, 5], delta=[0.25, 1.25, 2.25, 3.25])
    ),
    "2, one combination": lambda: number_of_dots.figure(grid(alpha=[1], beta=[0], gamma=[6], delta=[0])),
    "3": lambda: d_over_grid.figure(grid()),
    "3, largest alpha 0.4": lambda: d_over_grid.figure(grid(alpha=[0.2, 0.4])),
    "3, fine": lambda: d_over_grid.figure(grid(beta=[0, 1, 2, 3, 4, 5, 6, 7], gamma=FINE, delta=FINE)),
    "3, long labels": lambda: d_over_grid.figure(
        grid(beta=[0, 1, 2, 3, 4, 5], delta=[0.25, 1.25, 2.25, 3.25])
    ),
    **{
        f"3, recovered, {alpha}": lambda alpha=alpha: d_over_grid.figure(
            grid(alpha=[alpha], beta=[0.4], gamma=[10], delta=[10]).assign(
                d_recovered=-0.25, d_se_recovered=0.1
            )
        )
        for alpha in (1.0, 0.4)
    },
    "3, one gamma": lambda: d_over_grid.figure(grid(gamma=[6])),
    "3, one combination": lambda: d_over_grid.figure(grid(alpha=[1], beta=[0], gamma=[6], delta=[0])),
    "3, one reading": lambda: d_over_grid.figure(
        grid().drop(columns=["d_kept", "d_low_kept", "d_high_kept"])
    ),
    "3, no values": lambda: d_over_grid.figure(LACKING),
    "3, holes": lambda: d_over_grid.figure(HOLES),
    "4": figure4,
    "4, one reading": lambda: figure4(readings=["full"]),
    "4, three readings": lambda: figure4(readings=["kept", "full", "recovered"]),
    "4, few tests": lambda: figure4(n=7),
    "4, one test": lambda: figure4(n=1),
    "4, one roughness": lambda: figure4(n=20, roughness=np.full(20, 0.6)),
    "4, empty bins": lambda: figure4(n=20, roughness=np.r_[0.1, np.full(19, 0.9)]),
    "4, one patch": lambda: figure4(patches=1),
    "5": figure5,
    "5, 30 dots": lambda: figure5(30),
    "5, one subset": lambda: figure5(subsets_shown=1),
    "required_dots": lambda: required_dots.figure([surface_tables()]),
    "required_dots, little known": lambda: required_dots.figure(
        [surface_tables(rows=1, floors=("fresh dots",))]
    ),
    "required_dots, no grid": lambda: required_dots.figure([surface_tables(rows=0)]),
    "required_dots, 2 surfaces without grids": lambda: required_dots.figure(
        [surface_tables("p/c1", rows=0)] * 2
    ),
    "required_dots, 7 surfaces without grids": lambda: required_dots.figure(
        [surface_tables(f"p/c{k}", 1 + k / 20, rows=0) for k in range(7)]
    ),
    "required_dots, 2 surfaces": lambda: required_dots.figure(
        [surface_tables("p/c1"), surface_tables("p/c2", 1.3)]
    ),
    "required_dots, 5 surfaces": lambda: required_dots.figure([surface_tables(f"p/c{k}") for k in range(5)]),
    "required_dots, 7 surfaces": lambda: required_dots.figure(
        [surface_tables(f"p/c{k}", 1 + k / 20) for k in range(7)]
    ),
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.filterwarnings("error")
def test_draws_with_texts_apart_and_inside(name, monkeypatch):
    check_texts(CASES[name](), monkeypatch)


def test_recovered_surfaces_are_coloured_by_their_distance():
    near, far = (
        [ax for ax in figure5(distance=d).axes if ax.images][-1].images[0].get_array().reshape(-1, 3)
        for d in (0.02, 0.4)
    )
    near, far = (picture[np.ptp(picture, axis=1) > 60].mean(axis=0) for picture in (near, far))
    assert near[2] > near[0] and far[0] > 1.5 * far[2]  # blue and yellow


@pytest.mark.parametrize("name", ["frames", "1", "2", "3", "4", "5", "required_dots"])
def test_files_repeat_byte_by_byte(name, tmp_path):
    figure = CASES[name]()
    for folder, drawing in (("a", figure), ("b", figure), ("c", CASES[name]())):
        (tmp_path / folder).mkdir()
        for suffix in ("svg", "png"):
            layout.save(drawing, tmp_path / folder / f"v1.2_figure.{suffix}")
    assert "<text" in (tmp_path / "a" / "v1.2_figure.svg").read_text()
    for suffix in ("svg", "png"):
        first, *others = [(tmp_path / f / f"v1.2_figure.{suffix}").read_bytes() for f in "abc"]
        assert all(other == first for other in others)
        assert b"dc:date" not in first and b"tIME" not in first
    assert ElementTree.fromstring((tmp_path / "a" / "v1.2_figure.svg").read_text()).tag.endswith("svg")
    picture = imread(tmp_path / "a" / "v1.2_figure.png")
    assert abs(picture.shape[1] - figure.get_figwidth() * layout.DPI) < 1


def test_style_leaves_no_trace(tmp_path):
    before = dict(rcParams)
    layout.save(d_over_grid.figure(grid()), tmp_path / "x.svg")
    assert dict(rcParams) == before


def test_interpolation_goes_through_the_values_and_adds_no_maximum():
    x, y = np.array([0.0, 2, 4, 6, 8, 10]), np.array([0.0, 5, 10])
    table = np.random.default_rng(3).normal(size=(3, 6))
    fine_x, fine_y, fine = d_over_grid._interpolated(x, y, table)
    at = fine[np.searchsorted(fine_y, y)[:, None], np.searchsorted(fine_x, x)]
    np.testing.assert_allclose(at, table, atol=1e-12)
    # monotone between neighbours along each axis, so never beyond the values that it joins
    assert fine.max() <= table.max() + 1e-12 and fine.min() >= table.min() - 1e-12


@pytest.mark.parametrize("n", [1, 9, 300])
def test_each_test_dot_is_in_its_bin_of_roughness(n):
    roughness = np.random.default_rng(n).beta(5, 2, n)
    edges, chosen = rough_and_flat._binned(roughness, 10)
    assert np.sort(np.concatenate(list(chosen.values()))).tolist() == list(range(n))
    for k, dots in chosen.items():
        assert (roughness[dots] >= edges[k] - 1e-12).all() and (roughness[dots] <= edges[k + 1] + 1e-12).all()


def test_a1_figures_stay_small(shared, tmp_path):
    dots = []
    with gzip.open(shared / "data" / "tdp43" / "A1.dms.gz", "rt") as lines:
        for line in lines:
            columns = line.split()
            if columns[-1] != "A":
                dots.append([float(x) for x in columns[3:6] + columns[-3:]])
    points, normals = np.hsplit(np.array(dots), 2)
    roughness = np.loadtxt(shared / "oracle" / "a1_roughness_R4.csv", skiprows=1, delimiter=",", ndmin=2)[
        :, -1
    ]
    half = np.arange(0, len(points), 2)
    whole, thin = Surface(points, normals), Surface(points[half], normals[half])
    back = ("back", whole, np.zeros(len(points)))
    layout.save(roughness_figure.figure(points, normals, roughness), tmp_path / "1.svg")
    layout.save(subsets.figure(whole, [("half", thin, "red")] * 3, back), tmp_path / "5.svg")
    assert all((tmp_path / f"{k}.svg").stat().st_size < 2e6 for k in "15")
