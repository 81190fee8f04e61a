"""Descriptors of points against sums over their neighbours, meshes that are closed or not, and programs that call MSMS."""

import numpy as np
import pandas as pd

from measures import clients, interfaces
from measures.points import euler, is_closed


def test_descriptors_are_means_over_the_points_around():
    rng = np.random.default_rng(0)
    points, normals = rng.normal(50, 8, size=(300, 3)), rng.normal(size=(300, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    kinds, centres, expected = np.eye(20)[rng.integers(0, 20, 300)], np.array([3, 7]), []
    for c in centres:
        expected.append([])
        for radius in interfaces.AROUND:
            offset = points - points[c]
            near = np.linalg.norm(offset, axis=1) <= radius
            offset, normal = offset[near], normals[near]
            height, cosine = offset @ normals[c], normal @ normals[c]
            along = (offset * normal).sum(axis=1)
            means = [x.mean() for x in (height, height**2, along, cosine, cosine**2, (offset**2).sum(axis=1))]
            expected[-1] += [near.sum() / 2, *means, *kinds[near].mean(axis=0)]
    assert np.allclose(interfaces.describe(points, normals, kinds, centres, 2.0), expected)


def test_a_mesh_is_closed_if_each_edge_has_two_triangles_and_each_vertex_one_fan():
    tetrahedron = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    assert is_closed(tetrahedron) and euler(tetrahedron) == 2
    assert not is_closed(tetrahedron[:3])
    assert not is_closed(np.vstack([tetrahedron[:3], [[0, 2, 3]]]))  # one is turned over
    touching = np.where(tetrahedron == 0, 0, tetrahedron + 3)
    assert not is_closed(np.vstack([tetrahedron, touching]))  # two fans at vertex 0


def test_a_client_is_counted_and_compared_where_it_finished():
    areas = {
        "a": (100.0, 102.0),
        "b": (100.0, np.nan),
        "c": (100.0, 97.0),
    }  # with MSMS, and with sparsurf-msms
    rows = [
        ("A", structure, program, int(np.isnan(area)), area)
        for structure, pair in areas.items()
        for program, area in zip(("MSMS", "sparsurf-msms"), pair, strict=True)
    ]
    table = pd.DataFrame(rows, columns=["client", "structure", "program", "failed", "area"])
    table = table.assign(version="1", seconds=1.0, vertices=10.0, depth=np.nan)
    (row,) = clients.means(table).to_dict("records")
    assert (row["n"], row["n_msms"], row["n_sparsurf"]) == (3, 3, 2)
    assert np.isclose(row["area_percent"], -0.5) and np.isclose(row["largest_area_percent"], 3)
