"""The surface that is reconstructed from the minimal subset, between the job that measures it and those that draw it."""

import numpy as np
import pytest

from sparsurf.errors import InputError
from sparsurf.surfaces.surface import Surface
from sparsurf_study.analysis.reconstructed import read_reconstructed, write_reconstructed

POINTS = np.arange(12.0).reshape(4, 3) / 7
NORMALS = np.eye(3)[[1, 2, 0, 1]]
DISTANCE = np.array([0.25, 0.0, 0.125, 3.0, 1 / 3])  # of five dots of the whole surface


@pytest.fixture
def path(tmp_path):
    write_reconstructed(tmp_path / "reconstructed.npz", Surface(POINTS, NORMALS), DISTANCE)
    return tmp_path / "reconstructed.npz"


def test_points_normals_and_distances_are_read_as_they_were_written(path):
    surface, distance = read_reconstructed(path, 5)
    for read, written in ((surface.points, POINTS), (surface.normals, NORMALS), (distance, DISTANCE)):
        assert read.tolist() == written.tolist()


@pytest.mark.parametrize("damage", ["cut", "of another surface", "without distances"])
def test_a_damaged_file_is_refused(path, damage):
    if damage == "cut":
        path.write_bytes(path.read_bytes()[:-100])
    if damage == "without distances":
        np.savez(path, points=POINTS, normals=NORMALS)
    with pytest.raises(InputError, match="damaged: delete"):
        read_reconstructed(path, 4 if damage == "of another surface" else 5)
