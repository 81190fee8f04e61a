"""Atomic radii as published, and one default for each radius wherever a user or a function gives none."""

import inspect
import pkgutil
from dataclasses import asdict
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest

import sparsurf
from sparsurf.patches.index import D_LINK, R_PATCH, R_ZERNIKE
from sparsurf.surfaces.radii import PROBE_RADIUS, radii
from sparsurf.surfaces.surface import Placement
from sparsurf_study.config.models import PatchesSettings, SurfaceSettings

TABLES = {  # XX is no element
    "dms": "H 1.2 D 1.2 C 1.9 N 1.5 O 1.4 S 1.85 SE 1.85 P 1.9 F 1.35 CL 1.8 BR 1.95 I 2.15 FE 0.64 CU 1.28 "
    "ZN 1.38 XX 1.9",
    "bondi": "H 1.2 D 1.2 C 1.7 N 1.55 O 1.52 S 1.8 SE 1.9 P 1.8 F 1.47 CL 1.75 BR 1.85 I 1.98 SI 2.1 AS 1.85 "
    "TE 2.06 LI 1.82 NA 2.27 MG 1.73 K 2.75 NI 1.63 CU 1.4 ZN 1.39 PD 1.63 AG 1.72 CD 1.58 IN 1.93 SN 2.17 "
    "PT 1.75 AU 1.66 HG 1.55 TL 1.96 PB 2.02 GA 1.87 XX 2.0",
}


@pytest.mark.parametrize("table", TABLES)
def test_radii_are_those_of_the_tables(table, caplog):
    words = TABLES[table].split()
    expected = [float(word) for word in words[1::2]]
    assert radii(SimpleNamespace(element=np.array(words[::2])), table).tolist() == expected
    assert caplog.messages == [f"no {table} radius for XX: {expected[-1]:.2f} Å is used"]
    caplog.clear()
    radii(SimpleNamespace(element=np.array(words[:-2:2])), table)
    assert not caplog.text
    others = SimpleNamespace(element=np.array(["ZZ", "C", "XX", "ZZ"]))
    assert radii(others, table).tolist()[::2] == [expected[-1]] * 2
    assert caplog.messages == [f"no {table} radius for XX, ZZ: {expected[-1]:.2f} Å is used"]


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
    defaults = {each.default for each in taken if each is not None and each.default not in (each.empty, None)}
    assert defaults == {PROBE_RADIUS} == {1.4} == {SurfaceSettings().probe_radius}


def test_the_patches_of_a_study_have_the_radii_of_the_functions():
    patches = PatchesSettings()
    assert (patches.r_patch, patches.r_zernike, patches.d_link) == (R_PATCH, R_ZERNIKE, D_LINK)


def test_functions_place_dots_as_a_study_does():
    assert asdict(Placement()) == SurfaceSettings().model_dump()
