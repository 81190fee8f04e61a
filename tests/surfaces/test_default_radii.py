"""One default for each radius, wherever a user or a function gives none."""

import inspect
import pkgutil
from importlib import import_module

import pytest

import sparsurf
from sparsurf.api.inputs import PLACEMENT_DEFAULTS
from sparsurf.cli.command import main
from sparsurf.patches.index import D_LINK, R_PATCH, R_ZERNIKE
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.workflow.models import Patches, Surface

NAMES = ("probe", "probe_radius")


def default_radii():
    """Defaults of all functions of the library that take a radius of the probe, by function."""
    radii = {}
    for module in pkgutil.walk_packages(sparsurf.__path__, "sparsurf."):
        if module.name != "sparsurf.__main__":
            for name, function in inspect.getmembers(import_module(module.name), inspect.isfunction):
                parameters = inspect.signature(function).parameters
                defaults = [parameters[key].default for key in NAMES if key in parameters]
                radii |= {
                    f"{function.__module__}.{name}": value
                    for value in defaults
                    if value is not inspect.Parameter.empty
                }
    return radii


def test_every_default_radius_of_the_probe_is_that_of_water(capsys):
    radii = default_radii()
    assert {"sparsurf.api.surfaces.surface", "sparsurf.surfaces.mesh.molecular_mesh"} <= radii.keys()
    assert PROBE_RADIUS == 1.4 and set(radii.values()) == {PROBE_RADIUS}
    assert Surface().probe_radius == PLACEMENT_DEFAULTS["probe_radius"] == PROBE_RADIUS
    with pytest.raises(SystemExit):
        main(["surface", "--help"])
    assert f"radius of the probe in Å (default {PROBE_RADIUS:g})" in capsys.readouterr().out


def test_the_patches_of_a_study_have_the_radii_of_the_functions():
    patches = Patches()
    assert (patches.r_patch, patches.r_zernike, patches.d_link) == (R_PATCH, R_ZERNIKE, D_LINK)
