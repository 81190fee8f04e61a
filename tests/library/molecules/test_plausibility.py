"""What the checks of coordinates measure: usual lengths against real structures, the widest gap, frames in parts."""

import numpy as np

from sparsurf.molecules.plausibility import USUAL_LENGTHS, parts_of, widest_gap
from sparsurf.molecules.read_molecule import read_molecule


def median_distances(molecule, pairs):
    """Median distance, Å, between atoms of one residue."""
    place = {
        (int(index), name): xyz
        for index, name, xyz in zip(molecule.residue_index, molecule.name, molecule.xyz[0], strict=True)
    }
    for a, b in pairs:
        distances = [
            np.linalg.norm(xyz - place[k, b])
            for (k, name), xyz in place.items()
            if name == a and (k, b) in place
        ]
        yield np.median(distances) if distances else np.nan


def test_usual_lengths_are_those_of_real_structures(shared):
    """Half of them of a protein and of DNA: within 1 %."""
    molecules = [
        read_molecule(shared / "data" / "structures" / name, **keys)
        for name, keys in (("1ubi.pdb", {}), ("3mht_dna.pdb", {"selection": "all"}))
    ]
    found = [[*median_distances(each, USUAL_LENGTHS)] for each in molecules]
    np.testing.assert_allclose(np.nanmedian(found, axis=0), [*USUAL_LENGTHS.values()], rtol=0.01)


def test_the_widest_gap_and_the_point_beside_it():
    points = np.array([[0, 0, 0], [0, 3, 0], [1, 9, 0], [2, 10, 0.5], [0.5, 10.5, 0]])
    assert widest_gap(points) == (6.0, 1)  # two of five lie below it
    assert widest_gap(points * [1, -1, 1]) == (6.0, 1)
    assert widest_gap(points[:4]) == (6.0, 2)  # as many on both sides: the one above
    assert widest_gap(points[:1]) == (0.0, 0)


def test_frames_pass_in_parts_with_the_number_before_each():
    xyz = np.arange(7.0)[:, None, None] * np.ones((7, 2, 3))
    parts = [(begin, part[:, 0, 0].tolist()) for begin, part in parts_of(xyz, 3)]
    assert parts == [(0, [0, 1, 2]), (3, [3, 4, 5]), (6, [6])]
