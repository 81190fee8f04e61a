"""A reading is one entry: what it needs to take part."""

from types import SimpleNamespace

import numpy as np

from sparsurf.patches import readings
from sparsurf.patches.index import build_index
from sparsurf.recovery import readings as all_readings
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.study.prepared_surface import PreparedSurface


def test_readings_of_the_grid():
    assert list(all_readings.READINGS) == ["kept", "kept_scaled", "full", "recovered"]
    assert readings.GRID_READINGS == ("kept", "full")
    assert readings.READINGS["kept"].among_kept and not readings.READINGS["full"].among_kept


def test_a_reading_is_one_entry(blob, monkeypatch):
    # the toy reading links kept dots within 0.8 Å, as `kept` does on this surface: the same numbers
    toy = readings.Reading("toy", build_index=lambda points, normals, *_: build_index(points, normals, 0.8))
    monkeypatch.setitem(all_readings.READINGS, "toy", toy)
    prepared = PreparedSurface(
        SimpleNamespace(points=blob[0], normals=blob[1]),
        Settings(patches={"d_link": 0.8}),
        streams=Streams(1, "blob"),
    )
    tests = prepared.draw_tests(12)
    z_tot, _ = prepared.describe(tests)
    subsets = prepared.pair((0.8, 0.0, 2.0, 0.0), 0)
    z, sizes = prepared.distances(subsets, tests, z_tot, "toy")
    wanted, size = prepared.distances(subsets, tests, z_tot, "kept")
    assert np.allclose(z, wanted, atol=1e-9) and np.array_equal(sizes, size)


def test_scaled_links_within_the_spacing_of_the_kept_dots(blob):
    points, normals = blob
    index = readings.linked_by_spacing(points[::10], normals[::10], 0.5, 900.0)
    link = 1.6 * np.sqrt(900.0 / 300)
    gaps = np.linalg.norm(points[::10][:, None] - points[::10], axis=2)
    assert index.link_start[-1] >= ((gaps < link).sum() - 300)
    # a longer d_link links dots that this would not
    long = readings.linked_by_spacing(points[::10], normals[::10], 4.0, 900.0)
    assert np.array_equal(long.link_start, build_index(points[::10], normals[::10], 4.0).link_start)
    assert long.link_start[-1] > index.link_start[-1]
