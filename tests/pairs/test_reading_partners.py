"""Partners from the files of a study, and their centres by the config."""

from types import SimpleNamespace

import numpy as np
import pytest

from conftest import make_blob
from peptides import peptide, write
from sparsurf import InputError
from sparsurf.pairs import partner_files
from sparsurf.patches.index import build_index
from sparsurf.patches.roughness import roughness
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.surface import Surface
from sparsurf.workflow.conformations import require_conformation

PATCHES = {"R_patch": 3.0, "D_link": 1.6, "roughness": "published"}


def test_both_partners_come_from_their_own_files(tmp_path):
    surfaces = [tmp_path / "1.npz", tmp_path / "2.npz"]
    for seed, (path, n) in enumerate(zip(surfaces, (700, 600), strict=True), 1):
        points, normals = make_blob(n, seed)
        write_npz(path, Surface(points, normals, atom=np.zeros(n, int)))
    structure = write(tmp_path / "2.pdb", peptide(("GLY", "ALA"), "C") + "END\n")
    first, second = partner_files.read_partners(*surfaces, None, structure, PATCHES, "pair")
    assert (first.name, second.name) == ("pair 1", "pair 2")
    assert (len(first.surface), len(second.surface)) == (700, 600)
    assert first.residues is None and second.residues["residue_name"].tolist() == ["GLY", "ALA"]
    index = build_index(first.surface.points, first.surface.normals, 1.6)
    assert np.array_equal(first.roughness, roughness(index, 3.0, 1, "published"))
    with pytest.raises(InputError, match=r"pair, partner 1: D_link = 0.3 Å"):
        partner_files.read_partners(*surfaces, None, structure, PATCHES | {"D_link": 0.3}, "pair")


def test_number_of_centres_follows_the_config(monkeypatch):
    calls = []
    monkeypatch.setattr(
        partner_files, "centres_of", lambda *args: calls.append(args[1:]) or np.arange(args[1])
    )
    partner = SimpleNamespace(surface=np.zeros(900))

    def n_selected(centres):
        return len(partner_files.select_centres(partner, centres, 5))

    assert n_selected("all") == 900 and calls == []
    assert n_selected({"n_S_percent": 20, "sampler": "poisson"}) == 180 and calls == [(180, "poisson", 5)]
    assert n_selected({"n_S": 50, "sampler": "farthest"}) == 50
    assert n_selected({"n_S": 5000, "sampler": "farthest"}) == 900
    assert n_selected({"n_S_percent": 0.01, "sampler": "farthest"}) == 1


@pytest.mark.parametrize(
    ("pair", "labels"),
    [
        ({"complex": "a/x.pdb", "chains": [["H", "L"], ["A"]]}, ("chains H L of x.pdb", "chain A of x.pdb")),
        ({"files": ["a/r.pdb", "b/l.pdb"]}, ("r.pdb", "l.pdb")),
        ({"proteins": ["p", "q"]}, ("p", "q")),
    ],
)
def test_partners_are_called_what_they_are(pair, labels):
    assert partner_files.partner_labels(pair) == labels


@pytest.mark.parametrize("path", [None, ""])
def test_a_comparison_of_an_absent_conformation_is_refused_by_its_name(path):
    with pytest.raises(
        InputError, match=r"^changes\.open names a conformation .* frames\.csv of its protein"
    ):
        require_conformation(path, "open")
    assert require_conformation("surface.npz", "open") == "surface.npz"
