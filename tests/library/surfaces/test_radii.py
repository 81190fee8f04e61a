"""Atomic radii as published, and one default for each radius wherever a user or a function gives none."""

import inspect
import pkgutil
from dataclasses import asdict
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest

import sparsurf
from peptides import peptide
from sparsurf.errors import InputError
from sparsurf.patches.index import D_LINK, R_PATCH, R_ZERNIKE
from sparsurf.surfaces.radii import PROBE_RADIUS, check_radii, radii
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


# ---- radii of the user


def with_radii(folder, text):
    (folder / "radii.csv").write_text(text)
    return folder / "radii.csv"


def test_a_table_of_the_user_is_looked_up_by_its_closest_row(tmp_path, caplog):
    rows = [
        "residue_name, atom, element, radius, atom_name",
        ",,C,1.7",
        ",,n,1.55",
        ",,O,1.5",
        "Phe,,C,2.1,CG",
        ",CA,,1.9",
        "PHE,CA,,2.2",
        ",,S,1.8",
    ]
    molecule = SimpleNamespace(
        name=np.array(["CA", "CB", "N", "CA", "CB", "O"]),
        residue_name=np.array(["PHE"] * 3 + ["ALA"] * 3),
        element=np.array(["C", "C", "N", "C", "C", "O"]),
    )
    assert radii(molecule, with_radii(tmp_path, "\n".join(rows))).tolist() == [2.2, 2.1, 1.55, 1.9, 1.7, 1.5]
    assert "atom_name are not read" in caplog.text


def test_bondi_as_a_table_or_mapping_is_bondi(tmp_path):
    words = TABLES["bondi"].split()[:-2]
    bondi = dict(zip(words[::2], map(float, words[1::2]), strict=True))
    rows = "".join(f"{element},{radius}\n" for element, radius in bondi.items())
    path = with_radii(tmp_path, f"element,radius\n{rows}")
    text = peptide(["MET", "ALA"])
    (tmp_path / "m.pdb").write_text(text + "END\n")
    wanted = sparsurf.areas(tmp_path / "m.pdb", radii="bondi")
    for given in (path, str(path), bondi):
        found = sparsurf.areas(tmp_path / "m.pdb", radii=given)
        assert np.array_equal(found.accessible, wanted.accessible)
        assert found.residues["residue_name"].tolist() == ["MET", "ALA"]  # as in the file
    dots = sparsurf.surface(tmp_path / "m.pdb", radii=bondi)
    assert np.array_equal(dots.points, sparsurf.surface(tmp_path / "m.pdb", radii="bondi").points)
    assert dots.origin.reconstruction("auto").radii is None  # no table that a file could name


def test_one_atom_has_the_area_of_its_sphere(tmp_path):
    line = "HETATM    1  C   UNK A   1       0.000   0.000   0.000  1.00  0.00           C  \nEND\n"
    (tmp_path / "one.pdb").write_text(line)
    molecule = sparsurf.read_molecule(tmp_path / "one.pdb", selection="all")
    areas = sparsurf.areas(molecule, radii={"C": 2.0})
    assert areas.accessible.sum() == pytest.approx(4 * np.pi * 3.4**2) == pytest.approx(145.27, abs=0.005)


def test_larger_radii_of_a_structure(shared):
    path = shared / "data" / "bad" / "eighth" / "plain.pdb"
    words = TABLES["bondi"].split()[:-2]
    larger = {element: 1.05 * float(radius) for element, radius in zip(words[::2], words[1::2], strict=True)}
    assert sparsurf.areas(path, radii=larger).accessible.sum() == pytest.approx(5807.8, abs=0.05)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("element,radius\nC,1.7\n", r"radii\.csv .* ALA 1"),
        (
            "element,radius\nC,0\n",
            "it needs atom or residue_name or element, once, and radius, a number, more than 0",
        ),
        ("element,radius\nC,1.7\nC,1.8\n", "'C', 'radius': '1.8'.*"),
        ("element,radius,radius\nC,1.7,1.8\n", r"radii\.csv has the column 'radius' twice"),
        ("element,radius\nC,1,7\nN,1,55\n", "None: .*'7'"),  # a decimal comma
        ("radius\n1.7\n", "residue_name or element"),
        ("element,r\nC,1.7\n", "radius, a number"),
        ({"C": 0}, "row .*'radius': 0"),
        ("bond", "radii is 'bond'; it must be dms, bondi, or the path of a CSV with the column radius"),
        (3, "radii is 3;"),
    ],
)
def test_radii_that_do_not_fit_are_a_sentence(tmp_path, given, words):
    (tmp_path / "a.pdb").write_text(peptide() + "END\n")
    given = with_radii(tmp_path, given) if isinstance(given, str) and "\n" in given else given
    for function in (sparsurf.areas, sparsurf.surface, sparsurf.points, sparsurf.depth):
        with pytest.raises(InputError, match=words):
            function(tmp_path / "a.pdb", radii=given)


def test_radii_that_must_be_in_nm_are_told(caplog):
    check_radii({"C": 0.17, "N": 0.155})
    assert "multiply them by 10" in caplog.text
    caplog.clear()
    check_radii({"C": 1.7, "H": 0.12})
    assert not caplog.text
