"""Errors and shapes of surfaces that are reconstructed from few dots, on surfaces whose true ones are known."""

import numpy as np
import pandas as pd
import pytest

import sparsurf
from measures.spheres import SHAPES, compared, errors_both_ways, errors_of_atoms, means, shape_of
from sparsurf.evaluation.trials import TEST_DENSITY
from sparsurf.surfaces.molecular_surface import rolled_atoms

TURN = np.linspace(0, 2 * np.pi, 12, endpoint=False)
RING = np.column_stack([6 * np.cos(TURN), 6 * np.sin(TURN), 0 * TURN]).round(3)


@pytest.fixture(scope="module")
def ring():
    """A ring of atoms, through which the probe passes."""
    return sparsurf.surface((RING, np.full(12, 1.7)), density=30)


def test_all_atoms_deviate_by_nothing_and_a_moved_atom_by_its_move(ring):
    true = rolled_atoms(ring.origin)
    test = true.surface(TEST_DENSITY)
    row = errors_of_atoms(ring, test, true)
    assert row["density"] == pytest.approx(12 / ring.area.sum())
    assert max(row[error] for error in ("mean", "largest", "back_largest")) < 1e-6
    shifted = RING.copy()
    shifted[0, 0] += 0.3
    moved = sparsurf.surface((shifted, np.full(12, 1.7)), density=30)
    errors = errors_both_ways((test.points, test.normals), moved.points, moved.normals, true)
    assert errors["largest"] == pytest.approx(0.3, abs=0.01)
    assert errors["back_largest"] == pytest.approx(0.3, abs=0.01)


def test_a_ring_has_one_handle_and_a_pair_of_atoms_two_parts(ring):
    of_ring = shape_of(ring.points, ring.normals)
    assert (of_ring.parts, of_ring.handles) == (1, 1)
    assert of_ring.area == pytest.approx(ring.area.sum(), rel=0.01)
    two = sparsurf.surface(([[0.0, 0, 0], [9, 0, 0]], [1.7, 2.0]), density=30)
    of_two = shape_of(two.points, two.normals)
    assert (of_two.parts, of_two.handles) == (2, 0)
    assert of_two.volume == pytest.approx(4 / 3 * np.pi * (1.7**3 + 2.0**3), rel=0.01)
    row = compared(of_two, of_ring)
    assert [row[name] for name in SHAPES[2:]] == [2, 1, 0, 1]
    assert row["area_change"] == pytest.approx(100 * (of_two.area - of_ring.area) / of_ring.area)
    assert row["volume_change"] == pytest.approx(100 * (of_two.volume - of_ring.volume) / of_ring.volume)


def test_means_tell_the_size_of_the_structures_and_the_worst():
    row = {"group": "chains", "sampler": "cover", "model": "spheres", "requested": 0.24, "density": 0.24}
    errors = dict.fromkeys(("mean", "high_99", "back_99", "back_largest"), 0.1)
    table = pd.DataFrame(
        [row | errors | {"atoms": n, "largest": worst} for n, worst in ((480, 0.2), (900, 0.6), (1436, 0.4))]
    )
    found = means(table).iloc[0]
    assert found[["n", "fewest_atoms", "most_atoms"]].tolist() == [3, 480, 1436]
    assert found[["largest", "largest_highest"]].tolist() == pytest.approx([0.4, 0.6])
    assert found["largest_low"] < 0.4 < found["largest_high"]
    table["requested"], table["back_99"] = (
        "error 0.02",
        [0.09, 0.1, 0.104],
    )  # the limit is five times the error
    assert means(table)[["n_beyond", "beyond"]].to_numpy() == pytest.approx(np.array([[1, 4]]))
