"""Readings: the link that follows from the spacing of the kept dots, and the order of all readings."""

import numpy as np

from sparsurf.patches import readings
from sparsurf.patches.index import build_index
from sparsurf.recovery.readings import readings_of_columns


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


def test_readings_come_in_one_order_whatever_that_of_the_columns():
    assert readings_of_columns(["d_recovered", "full", "d_full", "d_kept", "x_kept_scaled"], "d_") == [
        "kept", "full", "recovered"
    ]  # fmt: skip
    assert readings_of_columns({"full", "d_kept"}) == ["full"]
