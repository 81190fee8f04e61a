"""A result as a picture, and what a notebook displays of it."""

import base64
import json
import re
import sys
import webbrowser
import zlib
from dataclasses import replace
from html import unescape
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import sparsurf
from peptides import peptide, write
from sparsurf import Surface
from sparsurf.api import show
from sparsurf.errors import InputError
from sparsurf.recovery.errors import distance_to_recovered
from sparsurf.surfaces.formats.colours import KIND_COLOURS, ROUGHNESS_LIMITS


def colours_of(ax):
    """Hues of the pixels that are drawn, as shares of the brightest channel, (n, 3)."""
    pixels = np.asarray(ax.images[0].get_array())[..., :3].reshape(-1, 3).astype(float)
    drawn = pixels[pixels.min(axis=1) < 250]
    return drawn / drawn.max(axis=1, keepdims=True)


def test_a_picture_is_lit_framed_and_coloured_by_values(blob):
    points, normals = blob
    dots = Surface(points, normals)
    ax = dots.plot(points[:, 0])
    assert len(ax.figure.axes) == 2 and ax.figure.axes[1].get_ylim() == pytest.approx(
        (points[:, 0].min(), points[:, 0].max())
    )
    left, right, bottom, top = ax.images[0].get_extent()
    spans = sorted(
        np.ptp(points @ np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2].T, axis=0)
    )
    assert right - left >= spans[2] and top - bottom >= spans[1]  # the whole molecule, along its widest axes
    assert ax.get_aspect() == 1  # an Å is as long up as across
    known = Surface(points, normals, kind=np.ones(len(points), int))
    assert known.plot(ax=ax) is ax and len(ax.figure.axes) == 2  # one scale, that of the values
    one_colour = known.plot()
    hue = KIND_COLOURS[1] / KIND_COLOURS[1].max()
    assert np.abs(np.median(colours_of(one_colour), axis=0) - hue).max() < 0.15  # haze whitens a little


def test_roughness_has_the_scale_of_all_pages_and_other_values_their_own(blob):
    dots = Surface(*blob)
    rough = np.linspace(0.5, 0.6, len(dots))
    hues, scales = zip(
        *(
            (colours_of(ax), ax.figure.axes[1])
            for ax in (dots.plot(rough, name="roughness"), dots.plot(rough))
        ),
        strict=True,
    )
    assert scales[0].get_ylim() == pytest.approx(ROUGHNESS_LIMITS) and scales[0].get_ylabel() == "roughness"
    assert scales[1].get_ylim() == pytest.approx((0.5, 0.6)) and scales[1].get_ylabel() == ""
    assert hues[0].std(axis=0).mean() < 0.5 * hues[1].std(axis=0).mean()  # a small part of the colours
    potential = dots.plot(rough, name="potential").figure.axes[1]
    assert potential.get_ylabel() == "electrostatic potential (kT/e)"


def test_a_picture_says_what_it_needs(blob, monkeypatch):
    dots = Surface(*blob)
    with pytest.raises(InputError, match=r"values has the shape \(2,\); the dots are 3000"):
        dots.plot([1, 2])
    import matplotlib.pyplot as plt

    with pytest.raises(InputError, match="axes without"):
        dots.plot(ax=plt.figure().add_subplot(projection="3d"))
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    with pytest.raises(InputError, match="pip install matplotlib"):
        dots.plot()


def test_a_notebook_shows_the_page_of_a_surface_and_a_picture_of_a_large_one(blob, monkeypatch):
    dots = Surface(*blob)
    text = dots._repr_html_()
    page = unescape(
        re.fullmatch(r'<iframe srcdoc="(.*)" height="480" style="[^"]*"></iframe>', text, re.DOTALL)[1]
    )
    assert page.startswith("<!doctype html>") and "3,000 dots" in page
    assert "index.html" not in page  # no link that leads nowhere
    monkeypatch.setattr(show, "MAX_DOTS_IN_NOTEBOOK", 2999)
    picture = re.fullmatch(
        r'<p>Surface of 3,000 dots</p><img alt="[^"]*" src="data:image/png;base64,(.*)">', dots._repr_html_()
    )
    assert base64.b64decode(picture[1]).startswith(b"\x89PNG")


def test_show_opens_the_browser_outside_of_a_notebook(blob, tmp_path, monkeypatch, caplog):
    opened = []
    monkeypatch.setattr(webbrowser, "open", lambda link: opened.append(link) or len(opened) == 1)
    dots = Surface(*blob)
    view = dots.show(dots.points[:, 2])
    view.save(tmp_path / "view.html")
    path = Path(opened[0].removeprefix("file://"))
    assert path.read_text() == view.html == (tmp_path / "view.html").read_text()
    assert re.fullmatch(r"View of 0\.\d MB; save\(\) writes it as a page", repr(view))
    assert "there is no browser" not in caplog.text
    dots.show()
    assert "browser; open /" in caplog.text
    jupyter = SimpleNamespace(get_ipython=lambda: SimpleNamespace(kernel=None))
    monkeypatch.setitem(sys.modules, "IPython", jupyter)
    assert dots.show(dots.points[:, 2])._repr_html_().startswith("<iframe") and len(opened) == 2


def header_of(html):
    """The header of the packed dots of a page."""
    content = zlib.decompress(base64.b64decode(re.search(r'PACKED = "([^"]*)"', html)[1]))
    return json.loads(content[4 : 4 + int.from_bytes(content[:4], "little")])


def test_a_view_opens_with_its_values_and_is_that_of_show(tmp_path, monkeypatch):
    """Of dots with a molecule, of dots alone, and of the kept dots of a subset, where the other dots have no value."""
    monkeypatch.setattr(webbrowser, "open", lambda link: True)
    (tmp_path / "ala.pdb").write_text(peptide() + "END\n")
    dots = sparsurf.surface(tmp_path / "ala.pdb")
    dots = replace(dots, fields={"score": np.arange(len(dots)) / 8})
    alone = Surface(dots.points, dots.normals, fields=dots.fields)
    few = sparsurf.minimal(dots, n_dots=100)
    for result in (dots, alone, few):
        assert result.show(tmp_path / "x.html").html == sparsurf.show(result, open_browser=False).html
    assert "4 roughest residues" in dots.show(tmp_path / "x.html").html
    for result, opens in (dots, None), (alone, "none"), (few, "minimal"):
        values = few.points[:, 0] if result is few else dots.points[:, 0]
        header = header_of(result.show(values, path=tmp_path / "x.html").html)
        assert header["colour"] == "value 1" and header.get("dots", {}).get("sampler") == opens
        scales = {scale["symbol"]: scale for scale in header["values"]}
        assert [*scales][:2] == ["R_i", "value"] and "value" not in {
            scale["symbol"] for scale in header_of(result.show(tmp_path / "x.html").html)["values"]
        }
        assert (scales["value"]["low"], scales["value"]["high"]) == pytest.approx(
            (values.min(), values.max())
        )
        if result is not few:
            assert (scales["score"]["low"], scales["score"]["high"]) == (0, (len(dots) - 1) / 8)


def test_all_results_share_one_interface(tmp_path, monkeypatch):
    """A page, a picture, a file, a table and the display of a notebook; a path given first is the path of the page."""
    monkeypatch.setattr(webbrowser, "open", lambda link: True)
    molecule = sparsurf.read_molecule(write(tmp_path / "p.pdb", peptide()))
    dots = sparsurf.surface(molecule)
    few, points = sparsurf.minimal(dots, n_dots=60), sparsurf.points(molecule, 80)
    mesh = sparsurf.mesh(molecule, n_vertices=120)
    for result, n in ((molecule, None), (dots, len(dots)), (few, 60), (points, 80), (mesh, 120)):
        assert result.show(tmp_path / "x.html").html == (tmp_path / "x.html").read_text()
        assert result.show(path=tmp_path / "y.html").html == (tmp_path / "y.html").read_text()
        path = tmp_path / ("z.ply" if result is mesh else "z.pdb")
        result.write(path)
        lines = path.read_text().splitlines()
        n_atoms = molecule.n_atoms if n is None else n
        assert (
            f"element vertex {n}" in lines
            if result is mesh
            else sum(line.startswith(("ATOM", "HETATM")) for line in lines) == n_atoms
        )
        assert "<i" in result._repr_html_() and result.plot().get_images()
        if n is not None:
            assert "values" in result.show(np.arange(n)).html and len(result.to_frame()) == n
    assert molecule.to_frame()[["x", "y", "z"]].to_numpy() == pytest.approx(molecule.xyz[0])
    assert few.density == pytest.approx(60 / dots.area.sum()) and points.n_dots == 80 and len(points) == 2
    assert mesh.area == mesh.vertices.area.sum()
    distances = distance_to_recovered(dots.points, few.points, few.normals, 1)
    assert 0.5 < few.error / distances[np.setdiff1d(np.arange(len(dots)), few.dots)].mean() < 2
