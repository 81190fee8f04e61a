"""Partners from the files of a study, and their centres by the config."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from conftest import make_blob
from peptides import peptide, write
from sparsurf.errors import InputError
from sparsurf.settings import Settings
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.surface import Surface
from sparsurf_study.pairs import partners
from sparsurf_study.pairs.partners import partner_of

SETTINGS = Settings(patches={"r_patch": 3.0, "r_zernike": 6.0, "d_link": 1.6})


def test_both_partners_come_from_their_own_files(tmp_path):
    surfaces = [tmp_path / "1.npz", tmp_path / "2.npz"]
    for seed, (path, n) in enumerate(zip(surfaces, (700, 600), strict=True), 1):
        points, normals = make_blob(n, seed)
        write_npz(path, Surface(points, normals, atom=np.zeros(n, int)))
    structure = write(tmp_path / "2.pdb", peptide(("GLY", "ALA"), "C") + "END\n")
    first, second = partners.read_partners(*surfaces, None, structure, 1.6, "pair")
    assert (first.name, second.name) == ("pair 1", "pair 2")
    assert (len(first.surface), len(second.surface)) == (700, 600)
    assert first.residues is None and second.residues["residue_name"].tolist() == ["GLY", "ALA"]
    with pytest.raises(InputError, match=r"pair, partner 1: d_link = 0.3 Å"):
        partners.read_partners(*surfaces, None, structure, 0.3, "pair")


def test_centres_follow_the_config():
    partner = partner_of(Surface(*make_blob(900)), name="one", d_link=1.6)

    def selected(**centres):
        return partners.select_centres(partner, centres, SETTINGS, 5)

    assert partners.select_centres(partner, "all", SETTINGS, 5).tolist() == list(range(900))
    assert len(selected(percent=20, sampler="uniform")) == 180
    assert len(selected(n_dots=5000, sampler="farthest")) == 900
    assert len(selected(percent=0.01, sampler="farthest")) == 1
    drawn = [
        partners.select_centres(replace(partner, name=name), {"n_dots": 50, "sampler": "uniform"}, SETTINGS, seed).tolist()
        for name, seed in (("one", 5), ("one", 6), ("two", 5), ("one", 5))
    ]  # fmt: skip
    assert (
        drawn[0] == drawn[3] and len({*map(tuple, drawn)}) == 3
    )  # each partner and seed has dots of its own
    points = partner.surface.points
    spacing = [
        pdist(points[selected(n_dots=50, sampler=sampler)]).min() for sampler in ("farthest", "uniform")
    ]
    assert spacing[0] > 2 * spacing[1]
    with pytest.raises(InputError, match="sampler 'fathest'") as told:
        selected(n_dots=50, sampler="fathest")
    assert told.value.arguments == ("complementarity.centres.sampler",)
