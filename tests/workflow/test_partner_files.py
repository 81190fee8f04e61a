"""Partners from the files of a run, their centres by the config, and pairs found in a folder."""

from types import SimpleNamespace

import numpy as np
import pytest

from conftest import make_blob
from peptides import peptide, write
from sparsurf import InputError
from sparsurf.patches.index import build_index
from sparsurf.patches.roughness import roughness
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.surface import Surface
from sparsurf.workflow import listing, partner_files

PATCHES = {
    "R_patch": 3.0,
    "D_link": 1.6,
    "R_zernike": 7.0,
    "roughness": "published",
    "descriptor": "published",
}


def test_both_partners_come_from_their_own_files(tmp_path):
    inputs = {}
    for side, n in (("1", 700), ("2", 600)):
        points, normals = make_blob(n, int(side))
        surface = Surface(points, normals, atom=np.zeros(n, int))
        inputs[f"surface_{side}"] = tmp_path / f"{side}.npz"
        write_npz(inputs[f"surface_{side}"], surface)
    inputs["structure_2"] = write(tmp_path / "2.pdb", peptide(("GLY", "ALA"), "C") + "END\n")
    first, second = partner_files.partners(inputs, {"patches": PATCHES}, "pair")
    assert (first.name, second.name) == ("pair 1", "pair 2")
    assert (len(first.surface), len(second.surface)) == (700, 600)
    assert first.residues is None and second.residues["residue_name"].tolist() == ["GLY", "ALA"]
    index = build_index(first.surface.points, first.surface.normals, 1.6)
    assert np.array_equal(first.roughness, roughness(index, 3.0, 1, "published"))
    sparse = {"patches": PATCHES | {"D_link": 0.3}}
    with pytest.raises(InputError, match=r"pair, partner 1: D_link = 0.3 Å"):
        partner_files.partners(inputs, sparse, "pair")
    assert partner_files.recipe_of({"patches": PATCHES}) == ("published", 7.0)


def test_centres_are_as_many_as_wished(monkeypatch):
    asked = []
    monkeypatch.setattr(
        partner_files, "centres_of", lambda *args: asked.append(args[1:]) or np.arange(args[1])
    )
    partner = SimpleNamespace(surface=np.zeros(900))

    def requested(asked):
        return len(
            partner_files.requested_centres(partner, {"complementarity": {"centres": asked}, "seed": 5})
        )

    assert requested("all") == 900 and asked == []
    assert requested({"n_S_percent": 20, "sampler": "voxel"}) == 180 and asked == [(180, "voxel", 5)]
    assert requested({"n_S": 50, "sampler": "farthest"}) == 50
    assert requested({"n_S": 5000, "sampler": "farthest"}) == 900
    assert requested({"n_S_percent": 0.01, "sampler": "farthest"}) == 1


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
