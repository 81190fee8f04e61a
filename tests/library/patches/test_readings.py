"""A reading is one entry: what it needs to take part."""

import numpy as np

from sparsurf.patches import readings
from sparsurf.patches.index import build_index


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
