"""A command writes the files that the functions and `write` do, in the same formats."""

import pytest

import sparsurf
from conftest import ROOT
from sparsurf.cli.command import main
from sparsurf.errors import InputError

PEPTIDE = ROOT / "data" / "tdp43" / "topology.pdb"


def test_a_table_of_points_is_that_of_the_command(tmp_path):
    pytest.importorskip("pyarrow")
    sparsurf.write(sparsurf.points(PEPTIDE, 32), tmp_path / "python.parquet")
    assert main(["points", str(PEPTIDE), "-n", "32", "-o", str(tmp_path / "command.parquet")]) == 0
    assert (tmp_path / "python.parquet").read_bytes() == (tmp_path / "command.parquet").read_bytes()


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
