"""Files with radii, or with elements of small molecules, as input, and depths below their surface."""

import re

import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree

import formats
import sparsurf
from conftest import ROOT
from sparsurf.cli.command import main
from sparsurf.errors import InputError
from sparsurf.surfaces.radii import RADII, radii
from sparsurf.surfaces.spheres import read_spheres

PROTEIN = ROOT / "data/tdp43/topology.pdb"
XYZ = np.array([[0.0, 0.0, 0.1], [1.4, 0.0, -20.5], [-105.25, 0.9, 0.0]])
BONDI = np.array([RADII["bondi"][element] for element in ("C", "O", "CL")])
V2000 = "name\n  program\n\n  3  2  0  0  0  0  0  0  0  0999 V2000\n" + "".join(
    f"{x:10.4f}{y:10.4f}{z:10.4f} {element:<3} 0  0\n" for (x, y, z), element in zip(XYZ, ("C", "O", "Cl"), strict=True)
) + "  1  2  1\n  1  3  1\nM  END\n$$$$\n"  # fmt: skip
V3000 = "name\n\n\n  0  0  0     0  0            999 V3000\nM  V30 BEGIN CTAB\nM  V30 BEGIN ATOM\n" + "".join(
    f"M  V30 {k} {element} {x} {y} {z} 0\n" for k, ((x, y, z), element) in enumerate(zip(XYZ, ("C", "O", "Cl"), strict=True))
) + "M  V30 END ATOM\nM  V30 END CTAB\nM  END\n"  # fmt: skip
MOL2 = "@<TRIPOS>MOLECULE\nx\n@<TRIPOS>ATOM\n" + "".join(
    f"{k} {element}{k} {x} {y} {z} {element}.2 1 LIG 0.5\n"
    for k, ((x, y, z), element) in enumerate(zip(XYZ, ("C", "O", "Cl"), strict=True))
) + "@<TRIPOS>BOND\n1 1 2 1\n"  # fmt: skip
PQR = "REMARK\n" + "".join(
    f"ATOM {k} C LIG A 1 {x} {y} {z} -0.3 {radius}\n" for k, ((x, y, z), radius) in enumerate(zip(XYZ, BONDI, strict=True))
) + "ATOM 9 H LIG A 1 7 7 7 0.3 0.0\nEND\n"  # fmt: skip
XYZR = "# spheres\n" + "".join(
    f"{x} {y}\t{z} {radius}\n" for (x, y, z), radius in zip(XYZ, BONDI, strict=True)
)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.sdf", V2000),
        ("a.mol", V3000),
        ("a.mol2", MOL2),
        ("a.pqr", PQR),
        ("a.xyzr", XYZR),
        ("a.XYZRN", XYZR),
    ],
)
def test_a_file_with_radii_or_elements_is_a_molecule(tmp_path, name, text):
    path = tmp_path / name
    path.write_text(text)
    expected = sparsurf.surface((XYZ, BONDI))
    for dots in (sparsurf.surface(path), sparsurf.points(path, 30).surface, sparsurf.mesh(path).vertices):
        assert np.array_equal(dots.origin.radii, BONDI) and np.array_equal(dots.origin.xyz, XYZ)
    assert np.array_equal(sparsurf.surface(str(path)).points, expected.points)
    assert main(["surface", str(path), "-o", str(tmp_path / "dots.csv")]) == 0
    table = pd.read_csv(tmp_path / "dots.csv")
    assert len(table) == len(expected) and table["area"].sum() == pytest.approx(
        expected.area.sum(), rel=0.001
    )
    calls = ("surface --mesh", "roughness", "minimal --percent 20", "points -n 20")
    for command in map(str.split, calls):
        assert main([command[0], str(path), *command[1:], "-o", str(tmp_path / "out.npz")]) == 0


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.sdf", V2000 + V2000, "holds several molecules"),
        ("a.sdf", V2000.replace("  3  2", "  x  2"), "line 4 does"),
        ("a.sdf", V2000.replace("  3  2", "300  2"), "line 4 does"),
        ("a.sdf", "x\n", "SDF file"),
        ("a.mol", V2000.replace(" C ", " 7 "), "element '7'"),
        ("a.sdf", V2000[:40], "is no SDF file|number of atoms"),
        ("a.mol2", MOL2 + MOL2, "holds several molecules"),
        ("a.mol2", MOL2.replace(" LIG 0.5", "").replace(" C.2 1", ""), "line 4"),
        ("a.mol2", "", "holds no atoms"),
        ("a.pqr", "ATOM 1 C 0 0 0 1.5\n", "line 1 does"),
        ("a.xyzr", "0 0 0 -1\n", "radii above 0"),
        ("a.xyzr", "0 0 inf 1\n", "coordinates must be finite"),
        ("a.xyzr", "0 0 0\n", "line 1 does"),
        # cut by the end of the file, or with a wrong count
        ("a.xyzr", 10 * "0.10 0.20 0.30 1.50\n" + "0.40 0.50 0.60 1", "line 11"),
        ("a.xyzrn", 10 * "0.1 0.2 0.3 1.5 1 C\n" + "0.4 0.5 0.6 1.7", "line 11"),
        (
            "a.pqr",
            10 * "ATOM 1 HG12VAL 7 0.1 0.2 0.3 -0.30 1.50\n" + "ATOM 1 HG12VAL 7 0.1 0.2 0.3 -0.30 1.",
            "line 11",
        ),
        ("a.pqr", "ATOM 1 HG12 VAL 7 10.1 0.2 0.3 -0.30\n", "line 1 does"),
        ("a.sdf", V2000.replace("  3  2", "  2  2"), "line 7 is an atom beyond the 2 that line 4 announces"),
        ("a.mol2", MOL2.replace("x\n", "x\n4 2 1\n"), "has 3 atoms and announces 4"),
        (
            "a.mol",
            V3000.replace("BEGIN ATOM", "COUNTS 4 0 0 0 0\nM  V30 BEGIN ATOM"),
            "has 3 atoms and announces 4",
        ),
        ("a.mol", V3000.replace("M  V30 END ATOM", ""), "no lines BEGIN ATOM and END ATOM"),
        ("a.mol", V3000.replace(" C 0.0 0.0 0.1 0", " C 0.0"), "line 7"),
        # elements that are none
        *(
            (
                "a.sdf",
                V2000.replace(" C ", f" {word:<2s}"),
                re.escape(f"has the element '{word}', which does not"),
            )
            for word in ("A", "Q", "*", "L", "R#", "X", "Cx")
        ),
        (
            "a.mol2",
            MOL2.replace("C.2", "Any"),
            "the atom 'C0' of the type 'Any', which is not a type of SYBYL",
        ),
        ("a.mol2", MOL2.replace("C.2", "Het"), "type 'Het'"),
        ("a.mol2", MOL2.replace("C.2", "ca").replace("C0", "X0"), "the atom 'X0' of the type 'ca'"),
        ("a.mol2", MOL2.replace("C.2", "cl"), "the atom 'C0' of the type 'cl'"),
        ("a.mol2", MOL2.replace("C.2", "NA"), "the atom 'C0' of the type 'NA'"),
        # numbers in other columns or units
        ("a.pqr", PQR.replace("-0.3", "1.7").replace(" 1.7\n", " 0.3\n"), "exchange charge"),
        ("a.pqr", "ATOM 1 N VAL A 7 10.1 0.2 0.3 1.55\n", "line 1 does"),
        ("a.pqr", "ATOM 1 N VAL 1 7 10.1 0.2 0.3 1.55\n", "line 1 does"),
        ("a.pqr", "ATOM 1 N VAL A 7 1.1 0.2-10.3 0.1 1.55\n", "columns touch; separate"),
        ("a.pqr", "ATOM 1 N VAL A 7 1.1 0.2 0.3 0.1 170\n", "such a position"),
        ("a.pqr", "ATOM 1 N VAL A 7 1.1 0.2 0.3 0.1 -1.7\n", "such a position"),
        (
            "a.pqr",
            "ATOM 1 N VAL A 7 1.1 0.2 0.3 0.1 0.17\n",
            "its largest radius is 0.17 Å; give lengths in Å",
        ),
        (
            "a.pqr",
            "".join(f"ATOM {k} N VAL A 7 {k / 10} 0.2 0.3 0.1 1.7\n" for k in range(9)),
            "0.10 Å apart.* lengths in Å",
        ),
        ("a.xyzr", "".join(f"{k / 10} 0.2 0.3 1.7\n" for k in range(10)), "0.10 Å apart"),
    ],
)
def test_a_file_that_holds_no_such_spheres_is_refused(tmp_path, name, text, words):
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=words):
        sparsurf.surface(tmp_path / name)


@pytest.mark.parametrize(
    ("names", "kinds", "elements"),
    [("C1 CA NA CL4", "C.ar Ca Na Cl", "C CA NA CL"), ("C1 M1 MG BR", "C.2 Zn Mg Br", "C ZN MG BR"),
     ("C1 CA NA CL", "C.3 CA NA CL", "C CA NA CL"), ("C1 C2 N3 CL4", "c3 ca na cl", "C C N CL"),
     ("C1 CA NA CL", "CT CA NA CL", "C C N CL"), ("C1 C2 N3 CL4", "C.3 Ca Na Cl", "C C N CL")],
)  # fmt: skip
def test_two_letters_are_an_element_where_the_types_are_those_of_sybyl(
    tmp_path, caplog, names, kinds, elements
):
    """CA is calcium or an aromatic carbon: a type that is none of SYBYL, or contradicts its name, shows what all are."""
    rows = zip(names.split(), kinds.split(), strict=True)
    lines = (f"{k} {name} {9.0 * k} 0 0 {kind} 1 LIG 0.5\n" for k, (name, kind) in enumerate(rows))
    (tmp_path / "a.mol2").write_text("@<TRIPOS>MOLECULE\nx\n4 0\n@<TRIPOS>ATOM\n" + "".join(lines))
    found = read_spheres(tmp_path / "a.mol2").radii
    assert found.tolist() == [RADII["bondi"].get(element, 2.0) for element in elements.split()]
    assert ("no bondi radius for CA: 2.00" in caplog.text) == ("CA" in elements.split())


@pytest.mark.parametrize(("factor", "told"), [(1.0, False), (1.3, False), (1.89, True), (100.0, True)])
@pytest.mark.parametrize("name", ["a.pqr", "a.sdf", "a.mol2"])
def test_lengths_that_are_longer_than_bonds_are_told(tmp_path, caplog, name, factor, told):
    """Lengths in Å, and in Bohr and pm; a chain of carbon."""
    zigzag = factor * 1.4 * np.array([[0.8 * k, 0.6 * (k % 2), 0.1] for k in range(12)])
    if name == "a.pqr":
        formats.pqr(tmp_path / name, zigzag, np.full(12, min(1.7 * factor, 9.0)), ["C"] * 12, columns=False)
    elif name == "a.sdf":
        formats.sdf(tmp_path / name, zigzag, ["C"] * 12)
    else:
        formats.mol2(tmp_path / name, zigzag, ["C"] * 12, ["C"] * 12, ["C.3"] * 12)
    read_spheres(tmp_path / name)
    assert ("are lengths in Å?" in caplog.text) == told


def test_a_drawing_is_refused(tmp_path):
    atoms = "".join(f"{k:10.4f}{0:10.4f}{0:10.4f} C   0\n" for k in range(6))
    (tmp_path / "flat.sdf").write_text(f"\n\n\n  6  0  0     0  0            999 V2000\n{atoms}M  END\n")
    with pytest.raises(InputError, match="is a drawing"):
        sparsurf.surface(tmp_path / "flat.sdf")
    (tmp_path / "flat.sdf").write_text(
        f"\n{'program':20s}3D\n\n  6  0  0     0  0            999 V2000\n{atoms}M  END\n"
    )
    assert len(read_spheres(tmp_path / "flat.sdf").radii) == 6  # a planar molecule


def test_spheres_of_a_protein_are_written_and_read(tmp_path):
    molecule = sparsurf.read_molecule(PROTEIN)
    sparsurf.write(molecule, tmp_path / "p.xyzrn")
    dots, back = sparsurf.surface(molecule), sparsurf.surface(tmp_path / "p.xyzrn")
    assert np.array_equal(back.points, dots.points)
    assert len((tmp_path / "p.xyzrn").read_text().splitlines()[0].split()) == 6


def test_depth_is_the_distance_from_the_surface():
    molecule = sparsurf.read_molecule(PROTEIN)
    table = sparsurf.depth(molecule)
    dense = sparsurf.surface(molecule, density=60.0, cavities="remove")
    exact = cKDTree(dense.points).query(molecule.xyz[0])[0]
    assert np.abs(table["depth"] - exact).max() < 0.2 and (table["depth"] - exact).mean() < 0.02
    assert (table["depth"] > radii(molecule, "dms") - 1e-3).all()
    of_residues = table.groupby(["chain", "residue"], sort=False)["depth"].mean().to_numpy()
    dots = sparsurf.surface(molecule)
    assert sparsurf.residues(dots)["depth"].to_numpy() == pytest.approx(of_residues, abs=1e-9)
    few = sparsurf.points(molecule, 50, fields="depth")
    assert few.fields["depth"] == pytest.approx(of_residues[molecule.residue_index[few.atom]], abs=1e-5)
    walls = sparsurf.depth(molecule, cavities="keep")["depth"]
    assert (walls <= table["depth"] + 1e-9).all() and (walls < table["depth"] - 0.5).any()
    ball = sparsurf.depth(([[0.0, 0, 0], [0.5, 0, 0]], [3.0, 2.0]), probe_radius=1.0)["depth"]
    assert ball.to_numpy() == pytest.approx([3.0, 2.5], abs=0.03)
