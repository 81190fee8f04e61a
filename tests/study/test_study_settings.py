"""The settings of a study: what the arguments of the library are called in its config."""

import pytest

from sparsurf_study.settings import name_in_config


@pytest.mark.parametrize(
    ("argument", "key"),
    [
        ("d_link", "patches.d_link"),
        ("probe_radius", "surface.probe_radius"),
        ("minimal.density", "minimal.density"),
        ("density", "density"),  # of two sections
        ("chains", "chains"),  # of a protein
    ],
)
def test_the_key_of_an_argument(argument, key):
    assert name_in_config(argument) == key
