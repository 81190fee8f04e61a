"""Pairs that are found in a folder or listed in a table."""

import pytest

from sparsurf.errors import InputError
from sparsurf.workflow import listing


def test_pairs_in_a_folder_are_named_by_what_they_share(tmp_path):
    names = [
        "1A2K_r.pdb",
        "1A2K_l.pdb",
        "x_1.cif.gz",
        "x_2.cif.gz",
        "a b_r.ent",
        "a b_l.ent",
        "_r.pdb",
        "_l.pdb",
    ]
    for name in [
        *names,
        "alone_r.pdb",
        "other_l.pdb",
        "y_1.pdb",
        "y_2.cif",
        "z_r.csv",
        "z_l.csv",
        "r_x_r.pdb",
    ]:
        (tmp_path / name).write_text("")
    found = listing.pairs_from_folder(str(tmp_path))
    assert found == {
        "1A2K": {"files": [str(tmp_path / "1A2K_r.pdb"), str(tmp_path / "1A2K_l.pdb")]},
        "a_b": {"files": [str(tmp_path / "a b_r.ent"), str(tmp_path / "a b_l.ent")]},
        "pair": {"files": [str(tmp_path / "_r.pdb"), str(tmp_path / "_l.pdb")]},
        "x": {"files": [str(tmp_path / "x_1.cif.gz"), str(tmp_path / "x_2.cif.gz")]},
    }


def test_pairs_of_a_folder_are_kept_apart_and_what_is_left_out_is_named(tmp_path, caplog):
    pairs = {"x_y": ("x y_r", "x y_l"), "x_y_": ("x+y_r", "x+y_l"), "B": ("B_1", "B_2"), "b_": ("b_r", "b_l")}
    for name in [*sum(pairs.values(), ()), "alone_r", "whole", "._b_r", "._b_l"]:
        (tmp_path / f"{name}.pdb").write_text("")
    (tmp_path / "notes_r.txt").write_text("")
    found = listing.pairs_from_folder(str(tmp_path))
    expected = {name: [str(tmp_path / f"{file}.pdb") for file in both] for name, both in pairs.items()}
    assert {name: pair["files"] for name, pair in found.items()} == expected
    assert [record.getMessage().split(" (")[0] for record in caplog.records] == [
        f"{tmp_path / name} is left out: its folder has no partner" for name in ("alone_r.pdb", "whole.pdb")
    ]


def test_a_table_of_pairs_parts_chains_by_blanks(tmp_path):
    path = tmp_path / "pairs.csv"
    path.write_text("name,complex,chains_1,chains_2,first,second\n a ,x.pdb, H L ,A,,\nb,,,,1.pdb,2.pdb\n")
    assert listing.pairs_from_table(str(path)) == {
        "a": {"complex": str(tmp_path / "x.pdb"), "chains": [["H", "L"], ["A"]]},
        "b": {"files": [str(tmp_path / "1.pdb"), str(tmp_path / "2.pdb")]},
    }
    path.write_text("name,complex,chains_1,chains_2,first,second\na,x.pdb,A,B,1.pdb,\n")
    with pytest.raises(InputError, match=r"line 2 of .*pairs.csv needs name and either"):
        listing.pairs_from_table(str(path))
