"""The potential of APBS beside ours."""

import numpy as np
import pytest

import sparsurf
from conftest import ROOT
from measures import potential


def test_a_grid_of_apbs_is_read_in_its_order():
    numbers = "\n".join(" ".join(f"{k / 2:.6e}" for k in range(i, i + 3)) for i in range(0, 24, 3))
    text = (
        "# Data from APBS\nobject 1 class gridpositions counts 2 3 4\norigin -1.0 2.0 3.5\ndelta 0.5 0 0\ndelta 0 0.25 0\n"
        "delta 0 0 0.125\nobject 2 class gridconnections counts 2 3 4\n"
        f'object 3 class array type double rank 0 items 24 data follows\n{numbers}\nattribute "dep" string "positions"\n'
    )
    origin, step, values = potential.read_grid(text)
    assert origin.tolist() == [-1, 2, 3.5] and step.tolist() == [0.5, 0.25, 0.125]
    assert np.array_equal(values, np.arange(24).reshape(2, 3, 4) / 2)  # the last coordinate runs fastest


@pytest.mark.skipif(potential.programs() is None, reason="pdb2pqr and apbs are not installed")
def test_our_potential_follows_that_of_apbs():
    molecule = sparsurf.read_molecule(ROOT / "evidence" / "quick" / "piece_2.pdb")
    vertices = sparsurf.mesh(molecule, n_vertices=200, fields="potential").vertices
    theirs = potential.potential_of_apbs(molecule, vertices.points)
    ours = vertices.fields["potential"]
    assert np.corrcoef(np.clip(ours, -30, 30), np.clip(theirs, -30, 30))[0, 1] > 0.75
    assert 0.3 < np.std(ours) / np.std(np.clip(theirs, -30, 30)) < 3  # the same unit, kT/e
