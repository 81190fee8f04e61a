"""Turns and axes that the points determine, and those that they leave open."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from peptides import STEP, peptide, write
from sparsurf.errors import InputError
from sparsurf.molecules.conformations import choose_frames, determines_rotation, superpose
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.orientation import (
    MIN_DISTANCE_FROM_LINE,
    best_rotations,
    canonical_axes,
    principal_axes,
    rigid_fit,
)
from sparsurf_study.pairs.changes import superpose_forms

SEQUENCE = ("ALA", "LEU", "LYS", "GLY", "SER", "VAL")
TURN = Rotation.from_rotvec([0.3, -1.1, 2.0]).as_matrix()
SHIFT = np.array([3.0, -2.0, 7.0])
SQUARE = np.array([[2.0, 1, 0], [-2, 1, 0], [-2, -1, 0], [2, -1, 0]])
TETRAHEDRON = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])


@pytest.fixture
def extended(tmp_path):
    """A peptide whose C-alphas lie on a line."""
    return read_molecule(write(tmp_path / "one.pdb", peptide(SEQUENCE) + "END\n"))


def with_frames(molecule, *frames):
    """A molecule in several frames, 1 ps apart."""
    number = np.arange(len(frames))
    return replace(molecule, xyz=np.array(frames), time_ps=number.astype(float), frame_number=number)


# --- turns ---------------------------------------------------------------------------------------------


def test_the_distance_from_the_line_by_hand():
    """The corners of a rectangle of 4 Å by 2 Å lie 1 Å from its long axis."""
    turn, distance = best_rotations(SQUARE.T @ SQUARE, 4)
    assert np.allclose(turn, np.eye(3)) and distance == pytest.approx(1.0)
    line = SQUARE * [1, 0, 0]
    assert best_rotations(line.T @ line, 4)[1] == 0


@pytest.mark.parametrize(("off_line", "determined"), [(0.0, False), (0.099, False), (0.101, True)])
def test_points_near_a_line_are_refused(off_line, determined):
    points = SQUARE * [1, off_line, 0]
    assert MIN_DISTANCE_FROM_LINE == 0.1
    assert determines_rotation(np.array([points, points @ TURN]), slice(None)) == determined
    if determined:
        turn, shift = rigid_fit(points, points @ TURN + SHIFT)
        assert np.allclose(turn, TURN) and np.allclose(shift, SHIFT)
        away = np.array([4.0, 5, 6])
        turn, shift = rigid_fit(points + away, points @ TURN + SHIFT)  # not about the origin
        assert np.allclose(turn, TURN) and np.allclose(shift, SHIFT - away @ TURN)
        assert np.allclose(superpose(np.array([points, points @ TURN]), slice(None)), points)
    else:
        with pytest.raises(InputError, match="fit lie"):
            rigid_fit(points, points @ TURN + SHIFT)
        with pytest.raises(InputError, match=r"^the atoms to superpose lie on a line.* in frame 0"):
            superpose(np.array([points, points @ TURN]), slice(None))


def test_a_plane_and_its_mirror_image_are_superposed():
    """A reflection of a planar set is a turn about an axis of its plane: by half a turn about x, y changes its sign."""
    points = SQUARE + np.outer([1, 0, 0, 0], [1, 0, 0])
    turn, _ = rigid_fit(points, points * [1, -1, 1])
    assert np.allclose(turn, np.diag([1.0, -1, -1]))


def test_a_mirror_image_is_refused_only_if_several_turns_fit_it():
    """Each of three turns by half fits the mirror image of a tetrahedron equally well; a stretched one has one best turn."""
    with pytest.raises(InputError, match="mirror image"):
        rigid_fit(TETRAHEDRON, -TETRAHEDRON)
    stretched = TETRAHEDRON * [3, 2, 1]
    turn, _ = rigid_fit(stretched, stretched * [1, 1, -1])
    assert np.allclose(turn, np.eye(3))  # the shortest axis stays reversed


# --- what takes more atoms, and what is refused ----------------------------------------------------------


def test_forms_whose_alpha_carbons_lie_on_a_line_are_superposed_by_their_backbones(extended):
    assert not determines_rotation(extended.xyz, extended.name == "CA")
    turned = with_frames(extended, extended.xyz[0][:, [1, 2, 0]] + SHIFT)
    assert np.allclose(superpose_forms(turned, extended).xyz, extended.xyz, atol=1e-9)


def test_forms_on_a_line_are_refused(extended):
    form = with_frames(extended, np.outer(np.arange(extended.n_atoms), STEP))
    with pytest.raises(InputError, match="forms share lie"):
        superpose_forms(form, form)


def test_frames_whose_alpha_carbons_lie_on_a_line_are_superposed_by_the_backbone(extended):
    xyz = extended.xyz[0]
    bent = xyz.copy()
    bent[:5] += [0, 0, 2.0]
    moving = with_frames(extended, xyz, xyz @ TURN + SHIFT, bent, bent @ TURN)
    choice = choose_frames(moving, frames="all", rng=np.random.default_rng(0))
    assert np.allclose(choice.projection[0], choice.projection[1], atol=1e-5)
    assert np.allclose(choice.projection[2], choice.projection[3], atol=1e-5)
    assert np.ptp(choice.projection[:, 0]) > 1
    one = with_frames(extended, xyz)
    assert len(choose_frames(one, rng=np.random.default_rng(0)).table) == 1


# --- axes ----------------------------------------------------------------------------------------------


def test_axes_of_a_box_by_hand():
    """The longest side comes first, and the point that is added lengthens its tail."""
    box = np.array([[x, y, z] for x in (-1, 1) for y in (-3, 3) for z in (-2, 2)], float)
    points = np.vstack([box, [0, -9, 0]])
    axes = principal_axes(points)
    assert np.allclose(np.abs(axes), [[0, 1, 0], [0, 0, 1], [1, 0, 0]]) and axes[0, 1] == pytest.approx(-1)
    assert np.allclose(axes[1:], [[0, 0, 1], [1, 0, 0]])  # without a tail the largest component is positive
    assert np.allclose(principal_axes(points @ TURN)[0], axes[0] @ TURN)
    across = principal_axes(box @ TURN, np.array([0.0, 1, 0]) @ TURN)  # as seen along the longest side
    assert np.allclose(np.abs(across @ TURN.T), [[0, 0, 1], [1, 0, 0]])


@pytest.mark.parametrize("points", [TETRAHEDRON, np.vstack([np.eye(3), -np.eye(3)]), np.zeros((4, 3))])
def test_without_axes_of_their_own_points_take_those_of_the_coordinates(points):
    noise = np.random.default_rng(1).normal(size=points.shape) * 1e-13
    for each in (points, points + noise, points[::-1] - 100):
        assert np.allclose(np.abs(principal_axes(each)), np.eye(3), atol=1e-6)
        assert np.allclose(principal_axes(each, np.array([0.0, 0, 1])), np.eye(3)[:2], atol=1e-6)


def test_small_things_have_axes_and_those_smaller_than_any_rounding_have_none():
    points = np.vstack([TETRAHEDRON * [1, 3, 2], [0, -9, 0]]) @ TURN
    assert np.allclose(principal_axes(1e-4 * points), principal_axes(points), atol=1e-6)
    assert np.allclose(principal_axes(1e-8 * points), np.eye(3), atol=1e-6)


def test_two_equal_axes_are_settled_in_their_plane():
    """A square across z: its first axis is the one nearest to x, whatever the corners."""
    corners = np.array([[np.cos(t), np.sin(t), 0] for t in 0.4 + np.pi / 2 * np.arange(4)])
    points = np.vstack([corners, [[0, 0, 5], [0, 0, -5]]])
    assert np.allclose(principal_axes(points), [[0, 0, 1], [1, 0, 0], [0, 1, 0]], atol=1e-6)


def test_equal_eigenvectors_do_not_depend_on_their_basis():
    rng = np.random.default_rng(2)
    basis, _ = np.linalg.qr(rng.normal(size=(7, 4)))
    values = np.array([5.0, 3, 3, 1])
    turned = basis.copy()
    turned[:, 1:3] = basis[:, 1:3] @ [[0.6, -0.8], [0.8, 0.6]]
    rounded = np.array([5.0, 1e-13, -4e-14, -2e-13])  # three are 0 but for rounding
    assert np.allclose(canonical_axes(rounded, basis), canonical_axes(rounded, turned))
    settled = canonical_axes(values, basis)
    assert np.allclose(settled, canonical_axes(values, turned)) and np.allclose(
        settled.T @ settled, np.eye(4)
    )
    assert np.array_equal(settled[:, [0, 3]], basis[:, [0, 3]])
