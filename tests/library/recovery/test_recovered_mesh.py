"""The mesh of a surface that is recovered from few dots: a ball whose answers are known."""

import numpy as np
import pytest

from conftest import ball
from sparsurf.errors import InputError
from sparsurf.recovery.interpolated_surface import recovered_mesh
from sparsurf.surfaces.grid_mesh import _assign_sides

DOTS = ball(60, 3)


def test_vertices_lie_on_the_ball_closer_with_a_finer_step(caplog):
    fine, coarse = (recovered_mesh(*DOTS, step=step) for step in (0.4, 0.8))
    for mesh in (fine, coarse):
        assert np.abs(np.linalg.norm(mesh.vertices.points, axis=1) - 3).max() < 0.05
        cosine = (mesh.vertices.points * mesh.vertices.normals).sum(axis=1) / 3
        assert cosine.min() > 0.999
    assert len(fine.vertices) == pytest.approx(4 * len(coarse.vertices), rel=0.15)
    assert fine.volume == pytest.approx(4 / 3 * np.pi * 27, rel=0.01)
    assert fine.vertices.area.sum() == pytest.approx(4 * np.pi * 9, rel=0.01)
    assert len(recovered_mesh(*DOTS).vertices) == len(recovered_mesh(*DOTS, step=0.5).vertices)
    assert not caplog.records


def test_two_bodies_and_a_cavity_are_all_closed(caplog):
    """A ball of 7 Å with a hole of 2.5 Å in it, and one of 4 Å beside it."""
    big, hole, small = ball(340, 7), ball(50, 2.5), ball(110, 4)
    points = np.concatenate([small[0] + [14, 0, 0], big[0], hole[0]])
    mesh = recovered_mesh(points, np.concatenate([small[1], big[1], -hole[1]]), step=0.7)
    assert mesh.volume == pytest.approx(4 / 3 * np.pi * (343 - 15.625 + 64), rel=0.01)
    assert mesh.vertices.area.sum() == pytest.approx(4 * np.pi * (49 + 6.25 + 16), rel=0.01)
    assert not caplog.records


def test_normals_that_point_inward_and_holes_are_reported(caplog):
    recovered_mesh(DOTS[0], -DOTS[1])
    assert caplog.messages[0].startswith("the normals point")
    caplog.clear()
    below = DOTS[0][:, 2] < 0
    recovered_mesh(2 * DOTS[0][below], DOTS[1][below], step=0.3)
    assert caplog.messages == [
        "the dots leave holes wider than 4.8 Å, and the mesh has artificial walls there"
    ]


def test_a_step_that_is_wider_than_the_surface_is_refused():
    with pytest.raises(InputError, match="smaller step"):
        recovered_mesh(ball(60, 0.2)[0], DOTS[1], step=3.0)


def test_the_reach_the_steps_and_the_density_are_those_that_are_given():
    first = recovered_mesh(*DOTS)
    for given in ({"density": 1.0}, {"reach": 0.6}, {"steps": 1}):
        other = recovered_mesh(*DOTS, **given)
        assert not np.array_equal(other.vertices.points, first.vertices.points), given


def test_regions_take_the_side_that_most_of_their_faces_indicate():
    """A layer around a cube: inside it is positive; where the layer is open, the faces disagree."""
    values, near = np.zeros((9, 9, 9)), np.zeros((9, 9, 9), bool)
    near[1:8, 1:8, 1:8] = True
    near[3:6, 3:6, 3:6] = False
    depth = 4 - np.abs(np.mgrid[:9, :9, :9] - 4).max(axis=0)
    values[near] = depth[near] - 1.5
    filled, consistent = _assign_sides(values, near)
    assert consistent and np.array_equal(filled > 0, depth >= 2) and (filled[near] == values[near]).all()
    assert set(filled[~near]) == {-1.0, 1.0}
    for n, few in ((6, True), (8, False)):  # of 54 faces inside and 294 outside, up to 2 % may disagree
        wrong = values.copy()
        wrong[1, 4, 1 : n + 1] = 0.5
        wrong[1, 4, 1] = values[1, 4, 1]
        assert _assign_sides(wrong, near)[1] == few
    near[4, 4, 1:3] = False  # a hole
    filled, consistent = _assign_sides(values, near)
    assert not consistent and (filled[~near] == -1).all()  # as the corner of the grid
