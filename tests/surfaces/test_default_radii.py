"""One default for each radius, wherever a user or a function gives none."""

import inspect
import pkgutil
from importlib import import_module

import sparsurf
from sparsurf.api.inputs import PLACEMENT_DEFAULTS
from sparsurf.patches.index import D_LINK, R_PATCH, R_ZERNIKE
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.workflow.models import Patches, Surface


def test_every_default_radius_of_the_probe_is_that_of_water():
    modules = {each.name for each in pkgutil.walk_packages(sparsurf.__path__, "sparsurf.")} - {
        "sparsurf.__main__"
    }
    functions = [
        each for name in modules for _, each in inspect.getmembers(import_module(name), inspect.isfunction)
    ]
    taken = [
        inspect.signature(each).parameters.get(key) for each in functions for key in ("probe", "probe_radius")
    ]
    defaults = {each.default for each in taken if each is not None and each.default is not each.empty}
    assert defaults == {PROBE_RADIUS} == {1.4} == {Surface().probe_radius, PLACEMENT_DEFAULTS["probe_radius"]}


def test_the_patches_of_a_study_have_the_radii_of_the_functions():
    patches = Patches()
    assert (patches.r_patch, patches.r_zernike, patches.d_link) == (R_PATCH, R_ZERNIKE, D_LINK)
