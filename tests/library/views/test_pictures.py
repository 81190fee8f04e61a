"""Pictures of one surface: what is drawn, where and in which colour, and which picture a result gets."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_hex

import sparsurf
from conftest import ball
from peptides import peptide
from sparsurf import Surface
from sparsurf.cli import command
from sparsurf.surfaces.formats.colours import KIND_COLOURS, ROUGHNESS_LIMITS, scale_of
from sparsurf.views import layout, pictures, render


@pytest.fixture
def saved(monkeypatch):
    """Figures that are saved, the last one last."""
    figures, save = [], layout.save
    monkeypatch.setattr(layout, "save", lambda figure, path: figures.append(figure) or save(figure, path))
    return figures


def pixels_of(figure):
    """The picture of a figure, (rows, columns, 3) in 0..1."""
    pixels = np.asarray(next(ax for ax in figure.axes if ax.images).images[0].get_array(), float)[..., :3]
    return pixels / 255 if pixels.max() > 1 else pixels


def hue(colour):
    return np.asarray(colour, float) / np.max(colour)


def without_dots(surface):
    """The picture of a surface in pale grey."""
    return pixels_of(pictures._of_surface(surface, np.tile(render.PALE_RGB, (len(surface), 1)), ""))


def ellipsoid(n=2000):
    """Dots that are seen along z, with x to the right or to the left."""
    points, normals = ball(n, 8.0)
    return points * [1.5, 1.0, 0.5], normals


def test_a_surface_has_the_colours_of_its_roughness_on_the_scale_of_the_reports():
    points, normals = ellipsoid()
    low, high = ROUGHNESS_LIMITS
    figure = pictures.values_picture(
        Surface(points, normals), scale_of("roughness", np.where(points[:, 0] < 0, low, high)), "p"
    )
    bar = next(ax for ax in figure.axes if not ax.images)
    assert bar.get_ylim() == pytest.approx((low, high)) and "low: rough" in bar.get_ylabel()
    pixels = pixels_of(figure)
    across = np.linspace(0.3, 0.7, 2) * pixels.shape[1]
    found = {tuple(hue(pixels[pixels.shape[0] // 2, int(x)]).round(1)) for x in across}
    ends = [hue(layout.colours(layout.scale(low, high), np.array([end]))[0][:3]) for end in (low, high)]
    for end in ends:
        assert min(np.abs(np.subtract(end, one)).max() for one in found) < 0.25
    assert len(found) == 2


@pytest.mark.parametrize(("width", "length"), [(60, 10), (20, 5), (6, 2)])
def test_a_scale_bar_is_as_long_as_it_says(width, length):
    """At most 0.4 of a picture of 60, 20 or 6 Å, and at most 10 Å."""
    ax = layout.constrained(50, 50).add_subplot()
    camera = render.Camera(np.eye(3), np.zeros(3), 10.0, (40, 10 * width))
    layout.draw_picture(ax, np.zeros((40, 10 * width, 3), np.uint8), camera)
    (bar,), (words,) = ax.lines, ax.texts
    assert np.ptp(bar.get_xdata()) == pytest.approx(length) and words.get_text() == f"{length} Å"
    assert np.ptp(ax.images[0].get_extent()[:2]) == pytest.approx(width)


def test_kinds_have_their_colours_and_their_names():
    points, normals = ellipsoid()
    kind = np.where(points[:, 0] < 0, 0, 2)
    figure = pictures.kinds_picture(Surface(points, normals, kind=kind), "p")
    (legend,) = figure.legends
    named = [(text.get_text(), to_hex(patch.get_facecolor()))
             for text, patch in zip(legend.get_texts(), legend.get_patches(), strict=True)]  # fmt: skip
    assert named == [(name, to_hex(KIND_COLOURS[k] / 255)) for k, name in ((0, "contact"), (2, "concave"))]
    assert not pictures.kinds_picture(Surface(points, normals), "p").legends  # of dots of unknown kind


def test_kept_dots_are_dark_and_where_they_are():
    points, normals = ellipsoid()
    whole = Surface(points, normals)
    kept = whole.take(np.flatnonzero((points[:, 0] > 4) & (normals[:, 2] > 0.5))[:9])
    bare = without_dots(whole).min(axis=2)
    dotted = pixels_of(pictures.kept_picture(whole, kept, "p")).min(axis=2)
    dark = dotted < bare - 0.2
    columns = np.flatnonzero(dark.any(axis=0)) / dark.shape[1]
    assert dark.sum() > 50 and (columns.min() > 0.5 or columns.max() < 0.5)  # on one side


def test_the_profile_has_the_roughness_of_each_residue_by_chain():
    rough = [0.35, 0.5, np.nan, 0.62, 0.7, 0.4]
    table = pd.DataFrame(
        {"chain": "A", "residue": ["7", "8", "9", "10", "20", "21"], "residue_name": "ALA", "area": 30}
    )
    table = pd.concat([table.assign(mean_roughness=rough), table.assign(chain="B", mean_roughness=0.9)])
    figure = pictures.profile_picture(table.reset_index(drop=True), "p")
    first, second = figure.axes
    assert (first.get_title("left"), second.get_title("left")) == ("chain A", "chain B")
    lines = [line.get_xydata().tolist() for line in first.lines]
    assert lines[:3] == [[[0, 0.35], [1, 0.5]], [[3, 0.62]], [[4, 0.7], [5, 0.4]]]  # 9 is buried
    assert [place for place, value in lines[3]] == [*range(6)] and np.allclose(
        [value for _, value in lines[3]], rough, equal_nan=True
    )
    assert lines[4] == [[place, rough[place]] for place in (0, 1, 3, 4, 5)]  # of the ten of both chains
    assert {text.get_text() for text in first.texts} <= {f"ALA {n} A" for n in (7, 8, 10, 20, 21)}
    names = dict(zip(table["residue"], range(6), strict=False))
    shown = zip(first.get_xticks(), first.get_xticklabels(), strict=True)
    assert all(names[label.get_text()] == place for place, label in shown)
    assert first.get_ylim() == second.get_ylim() and first.get_ylim()[1] == pytest.approx(1.0)
    assert "the 10 roughest" in second.get_xlabel()
    many = pd.concat([table[:6].assign(chain=f"c{k}") for k in range(13)], ignore_index=True)
    assert len(pictures.profile_picture(many, "p").axes) == 12


def test_each_result_has_its_own_picture(saved, tmp_path):
    """Kinds of a surface, the weights of a subset as dark dots on the whole, and a profile of residues."""
    (tmp_path / "ala.pdb").write_text(peptide() + "END\n")
    dots = sparsurf.surface(tmp_path / "ala.pdb")
    for result in (dots, sparsurf.minimal(dots, n_dots=30), sparsurf.residues(dots)):
        sparsurf.write(result, tmp_path / "x.png")
    kinds, kept, profile = saved
    assert [text.get_text() for text in kinds.legends[0].get_texts()] == ["contact", "saddle", "concave"]
    pale = without_dots(dots)
    picture = pixels_of(kept)
    assert picture.shape == pale.shape and not kept.legends
    changed = np.abs(picture - pale).max(axis=2) > 0.2
    assert 0.001 < changed.mean() < 0.2  # the dots, and nothing else
    assert len(profile.axes) == 1 and not profile.axes[0].images
    assert (
        command.main(
            ["roughness", str(tmp_path / "ala.pdb"), "--residues", "2", "-o", str(tmp_path / "r.png")]
        )
        == 0
    )
    part = dots[dots.to_frame()["residue"].to_numpy() == "2"]
    of_part = sparsurf.roughness(dots)[dots.to_frame()["residue"] == "2"]
    wanted = pictures.values_picture(part, scale_of("roughness", of_part), "ala")
    assert np.array_equal(pixels_of(saved[-1]), pixels_of(wanted)) and len(saved[-1].axes) == 2
