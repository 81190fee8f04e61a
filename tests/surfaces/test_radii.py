"""Atomic radii, as published."""

from types import SimpleNamespace

import pytest

from sparsurf.surfaces.radii import radii


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        (
            "dms",
            {"H": 1.2, "C": 1.9, "N": 1.5, "O": 1.4, "S": 1.85, "P": 1.9, "FE": 0.64, "ZN": 1.38, "XX": 1.9},
        ),
        (
            "bondi",
            {"H": 1.2, "C": 1.7, "N": 1.55, "O": 1.52, "S": 1.8, "P": 1.8, "F": 1.47, "ZN": 1.39, "XX": 2.0},
        ),
    ],
)
def test_radii_are_those_of_the_tables(table, expected):
    assert radii(SimpleNamespace(element=list(expected)), table).tolist() == list(expected.values())
