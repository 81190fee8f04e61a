"""A command writes the files that the functions and `write` do, in the same formats."""

from dataclasses import replace

import pytest

import sparsurf
from conftest import ROOT
from peptides import peptide
from sparsurf.cli.command import main
from sparsurf.errors import InputError

PEPTIDE = ROOT / "data" / "tdp43" / "topology.pdb"


def test_a_table_of_points_is_that_of_the_command(tmp_path):
    pytest.importorskip("pyarrow")
    sparsurf.write(sparsurf.points(PEPTIDE, 32), tmp_path / "python.parquet")
    assert main(["points", str(PEPTIDE), "-n", "32", "-o", str(tmp_path / "command.parquet")]) == 0
    assert (tmp_path / "python.parquet").read_bytes() == (tmp_path / "command.parquet").read_bytes()


RESULTS = {
    "surface p.pdb --fields hydropathy -o x.csv": lambda file: with_hydropathy(sparsurf.surface(file)),
    "surface p.pdb --mesh -o x.ply": sparsurf.mesh,
    "minimal p.pdb --percent 10 -o x.npz": lambda file: sparsurf.minimal(file, percent=10),
    "recover few.csv -o x.csv": lambda _: sparsurf.recover("few.csv"),
    "residues p.pdb -o x.csv": lambda file: sparsurf.residues(sparsurf.surface(file)),
    "areas p.pdb --of atoms -o x.csv": lambda file: sparsurf.areas(file).atoms,
    "regions p.pdb --field hydropathy --above 0 -o x.npz": lambda file: sparsurf.regions(
        file, "hydropathy", above=0
    ),
    "atoms p.pdb -o x.pqr": sparsurf.surface_atoms,
}


def with_hydropathy(dots):
    return replace(dots, fields=sparsurf.fields(dots, "hydropathy").to_dict("series"))


@pytest.mark.parametrize("call", RESULTS)
def test_a_file_of_a_command_has_the_columns_of_the_result(tmp_path, monkeypatch, call):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "p.pdb").write_text(peptide(["ALA", "SER", "LYS"]) + "END\n")
    sparsurf.write(sparsurf.minimal("p.pdb", percent=10), "few.csv")
    assert main([*call.split(), "-q"]) == 0
    name = call.split()[-1]
    sparsurf.write(RESULTS[call]("p.pdb"), f"own_{name}")
    assert (tmp_path / f"own_{name}").read_bytes() == (tmp_path / name).read_bytes()


def test_a_script_for_chimerax_is_that_of_the_function(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    sparsurf.write(sparsurf.surface(PEPTIDE), "a.cxc")
    expected = {end: (tmp_path / f"a{end}").read_bytes() for end in ("_dots.bild", "_molecule.pdb")}
    assert main(["surface", str(PEPTIDE), "-o", "b.cxc"]) == 0
    for end, content in expected.items():
        assert (tmp_path / f"b{end}").read_bytes() == content
    (tmp_path / "c_dots.bild").write_text("of the user")
    assert main(["surface", str(PEPTIDE), "-o", "c.cxc"]) == 1
    assert "c_dots.bild" in capsys.readouterr().err and not (tmp_path / "c.cxc").exists()
    with pytest.raises(InputError, match=r"leave out \.gz"):
        sparsurf.write(sparsurf.surface(PEPTIDE), "d.cxc.gz")


def test_a_recovered_surface_has_a_page_and_a_picture(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    sparsurf.write(sparsurf.minimal(PEPTIDE, density=0.4), "few.csv")
    for name in ("dots.png", "page.html"):
        assert main(["recover", "few.csv", "-o", name]) == 0
    page, n_dots = (tmp_path / "page.html").read_text(), len(sparsurf.recover("few.csv"))
    assert f"The {n_dots:,} dots" in page and "<h1>few</h1>" in page
    assert (tmp_path / "dots.png").read_bytes().startswith(b"\x89PNG")
