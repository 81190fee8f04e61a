"""Partners matched: a lock and its key, tables that add up, partners that do not touch."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.distance import cdist

from conftest import ball, make_blob
from peptides import peptide, write
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.patches.descriptors import describe_patches
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.surface import Surface
from sparsurf_study.pairs import matching
from sparsurf_study.pairs.partners import partner_of
from sparsurf_study.pairs.ranking import auc

D_LINK = 0.9  # Å, for the few dots of the blobs


def blob_partner(name, n=1200, seed=5, shift=(0, 0, 0), inward=False):
    points, normals = make_blob(n, seed)
    return partner_of(Surface(points + shift, -normals if inward else normals), name=name, d_link=D_LINK)


@pytest.fixture(scope="module")
def blobs():
    return blob_partner("one"), blob_partner("two", 1100, 6, (19.0, 0, 0))


@pytest.fixture(scope="module")
def peptides(tmp_path_factory):
    """Two short peptides side by side, with their residues."""
    folder = tmp_path_factory.mktemp("peptides")
    partners = []
    for chain, y in (("A", 0.0), ("B", 9.0)):
        path = write(folder / f"{chain}.pdb", peptide(("ALA", "LEU", "LYS", "GLY"), chain, origin=(0, y, 0)))
        molecule = read_molecule(path)
        surface = molecular_surface(molecule.xyz[0], radii(molecule, "dms"), density=6.0)
        partners.append(partner_of(surface, molecule, chain))
    return partners


def test_a_surface_matches_its_cast():
    # The cast has the same dots with normals turned round: its 'down' is the surface's 'up' turned about z, which the
    # invariants do not see but for the scan of the gap filling (0.2 here; two different patches differ by 0.9).
    lock, key = blob_partner("lock"), blob_partner("key", inward=True)
    found = matching.match(lock, key)
    assert len(found.centres[0]) > 1000
    assert np.median(found.complementary[0].distance[:, 0]) < 0.25
    place = lock.surface.points[found.centres[1][found.complementary[0].partner[:, 0]]]
    assert (np.linalg.norm(place - lock.surface.points[found.centres[0]], axis=1) < 1.5).mean() > 0.35
    assert (matching.contacts(lock, key)["auc"] > 0.97).all()


def test_maps_equal_all_distances(blobs):
    centres = (np.arange(0, 1200, 3), np.arange(1, 1100, 2))
    found = matching.match(*blobs, centres, k=2)
    up, _ = describe_patches(blobs[0].index, blobs[0].surface.points[found.centres[0]])
    down, _ = describe_patches(blobs[1].index, blobs[1].surface.points[found.centres[1]], up=False)
    distance = cdist(up, down)
    alike = cdist(up, describe_patches(blobs[1].index, blobs[1].surface.points[found.centres[1]])[0])
    for side, plain in enumerate((distance, distance.T)):
        table = matching.maps(found, side)
        at = table.iloc[found.centres[side]]
        assert np.allclose(at["propensity"], plain.min(axis=1), atol=1e-12)
        assert np.allclose(at["propensity_k"], np.sort(plain, axis=1)[:, :2].mean(axis=1), atol=1e-12)
        assert np.allclose(at["similarity"], alike.min(axis=1 - side), atol=1e-12)
        # several patches of the small satellite are the same one, so that the match itself is not unique
        place = np.searchsorted(found.centres[1 - side], at["match"])
        assert np.allclose(plain[np.arange(len(at)), place], plain.min(axis=1), atol=1e-12)
        assert table["propensity"].isna().sum() == len(table) - len(at)
        assert not table["propensity_smoothed"].isna().any()
        place = blobs[side].surface.points
        near = np.linalg.norm(place[found.centres[side]] - place[7], axis=1) <= 6.0
        assert table["propensity_smoothed"][7] == pytest.approx(plain.min(axis=1)[near].mean(), abs=1e-12)


def test_patches_of_one_dot_are_left_out():
    alone = Surface(np.array([[0.0, 0, 0], [50, 0, 0]]), np.tile([0.0, 0, 1], (2, 1)))
    points, normals = make_blob(600)
    two = np.array([[0.0, 0, 200], [1, 0, 200]])  # each in the patch of the other
    places = np.vstack([points, alone.points + 100, two])
    both = Surface(places, np.vstack([normals, alone.normals, alone.normals]))
    found = matching.match(partner_of(both, name="a", d_link=1.2), blob_partner("b"))
    assert np.isin([600, 601, 602, 603], found.centres[0]).tolist() == [False, False, True, True]
    assert len(found.centres[0]) >= 540


def test_tables_tell_residues_gaps_and_interface(peptides):
    found = matching.match(*peptides, k=3)
    table = matching.maps(found, 0)
    dots = matching.by_dot(found, 0, table)
    gap = cdist(peptides[0].surface.points, peptides[1].surface.points).min(axis=1)
    assert np.allclose(dots["gap"], gap)
    assert np.array_equal(dots["interface"] == 1, gap < 3.0)
    assert 0 < dots["interface"].mean() < 1
    residues = matching.by_residue(dots.assign(partner=1))
    assert residues["residue_name"].tolist() == ["ALA", "LEU", "LYS", "GLY"]
    assert residues["dots"].sum() == len(dots)
    leucine = dots[dots["residue_name"] == "LEU"]
    row = residues.iloc[1]
    assert row["propensity_smoothed"] == pytest.approx(leucine["propensity_smoothed"].mean())
    assert row["interface"] == pytest.approx(leucine["interface"].mean())


def test_best_pairs_are_ranked_and_apart(peptides):
    found = matching.match(
        *peptides, (np.arange(0, len(peptides[0].surface), 2), None)
    )  # dots are no centres
    table = matching.best_pairs(found, n=20)
    assert table["distance"].is_monotonic_increasing
    best = min(near.distance.min() for near in found.complementary)
    assert table["distance"][0] == best
    place = [peptides[side].surface.points[table[f"dot_{side + 1}"]] for side in (0, 1)]
    assert np.allclose(table["gap"], np.linalg.norm(place[0] - place[1], axis=1))
    near = (cdist(place[0], place[0]) < 6.0) & (cdist(place[1], place[1]) < 6.0)
    assert near.sum() == len(table)  # each with itself only
    # the first of both sides' best matches in a row by distance; what is missing lies near a better one on both sides
    pairs = []
    for side, near in enumerate(found.complementary):
        for i, j in enumerate(near.partner[:, 0]):
            dots = (found.centres[side][i], found.centres[1 - side][j])
            pairs.append((near.distance[i, 0], *map(int, dots[:: 1 - 2 * side])))
    chosen = []
    for distance, a, b in sorted(pairs):
        at = [peptides[0].surface.points[a], peptides[1].surface.points[b]]
        if not any(np.linalg.norm(at[0] - p) < 6 and np.linalg.norm(at[1] - q) < 6 for _, p, q, *_ in chosen):
            chosen.append((distance, *at, a, b))
    assert table[["dot_1", "dot_2"]].to_numpy().tolist() == [[a, b] for *_, a, b in chosen[:20]]
    names = ["ALA1", "LEU2", "LYS3", "GLY4"]
    for side, chain in ((0, "A"), (1, "B")):
        of_dots = [f"{chain}:{names[peptides[side].residue[dot]]}" for dot in table[f"dot_{side + 1}"]]
        assert table[f"residue_{side + 1}"].tolist() == of_dots and len({*of_dots}) > 1
    assert matching.best_pairs(found, n=3).equals(table[:3])


@pytest.mark.parametrize("within", [3.0, 3.6])
def test_agreement_is_the_area_of_each_score(peptides, within):
    """On both sides, whose centres differ; and contacts are the dots of the first side that touch."""
    found = matching.match(*peptides, (np.arange(0, len(peptides[0].surface), 2), None))
    dots, areas = matching.tables_of_partners(found, 2.0, within, 0)
    for side, partner in enumerate(peptides):
        of_side = areas[areas["partner"] == side + 1].set_index("score")
        centres, points = found.centres[side], partner.surface.points
        gap = cdist(points, peptides[1 - side].surface.points).min(axis=1)
        truth = gap[centres] < within
        at = dots[dots["partner"] == side + 1].iloc[centres]
        assert np.array_equal(at["interface"] == 1, truth)
        for name in ("propensity", "propensity_smoothed", "similarity"):
            assert of_side.loc[name, "auc"] == auc(-at[name].to_numpy(), truth)
        near = cdist(points[centres], points[centres]) <= 2.0
        assert np.allclose(at["propensity_smoothed"], near @ at["propensity"] / near.sum(axis=1))
        near = cdist(points[centres], partner.heavy_atoms) <= 10
        assert of_side.loc["protrusion", "auc"] == auc(-near.sum(axis=1), truth)
        assert (of_side["low"] <= of_side["auc"]).all() and (of_side["auc"] <= of_side["high"]).all()
        assert {*of_side["interface"]} == {truth.sum()} and {*of_side["dots"]} == {len(centres)}
        blocks = matching.blocks_of(partner, centres)
        assert of_side.loc["propensity", "blocks"] == len(np.unique(blocks)) > 1
    resampled, bootstrap = [], matching.bootstrap_auc
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(matching, "bootstrap_auc", lambda *given: resampled.append(given) or bootstrap(*given))
        contact = matching.contacts(*peptides, within)
    for _, native, block, _ in resampled:  # a native pair and the pair beside it are drawn together
        assert np.array_equal(block[native], block[~native]) and len(np.unique(block)) >= (within > 3) + 1
    assert contact["against"].tolist() == ["any pair", "exchanged"]
    assert ((contact["auc"] > 0) & (contact["auc"] < 1)).all()
    assert {*contact["pairs"]} == {min(500, (dots.query("partner == 1")["gap"] < within).sum())}


def test_contacts_are_compared_with_any_dot_and_with_those_of_other_contacts():
    """A ball in a shell, whose patches are alike everywhere, and a body beside the shell, whose patches are others."""
    (inner, out), (outer, _), (points, normals) = ball(1500, 10.0), ball(1700, 12.0), make_blob(1700)
    beside = points + np.array([40.0, 0, 0])
    shell = Surface(np.vstack([beside, outer]), np.vstack([normals, -outer / 12]))
    partners = [
        partner_of(dots, name=name, d_link=1.6)
        for name, dots in (("ball", Surface(inner, out)), ("shell", shell))
    ]
    table = matching.contacts(*partners).set_index("against")
    assert (table["pairs"] == 500).all()  # of 1500
    assert table["auc"]["exchanged"] == pytest.approx(0.5, abs=0.05)
    assert table["auc"]["any pair"] == pytest.approx(0.75, abs=0.06)  # half of the dots are those of the body
    assert (table["low"] <= table["auc"]).all() and (table["auc"] <= table["high"]).all()


def test_partners_without_chains_or_contact():
    names = ("propensity_smoothed", "propensity_k_smoothed", "similarity_smoothed")
    dots = pd.DataFrame({"chain": [np.nan] * 2, "residue": "1", "residue_name": "ALA", "interface": [0, 1]})
    table = matching.by_residue(dots.assign(partner=1, **{name: [1.0, 3.0] for name in names}))
    assert table[["dots", "propensity_smoothed", "interface"]].to_numpy().tolist() == [[2, 2, 0.5]]
    far = blob_partner("one"), blob_partner("two", 1100, 6, (100.0, 0, 0))
    found = matching.match(*far)
    assert matching.agreement(found, 0, matching.maps(found, 0)) is None
    assert matching.contacts(*far).empty


def test_residues_belong_to_their_dots_and_atoms():
    # five atoms of three residues 20 Å apart, one of them a hydrogen; two dots above each residue
    dots = np.array([[x + dx, 0.0, 2.0] for x in (0.0, 20.0, 40.0) for dx in (0.0, 1.0)])
    surface = Surface(dots, np.tile([0.0, 0, 1], (6, 1)), atom=np.array([0, 1, 2, 2, 4, 4]))
    molecule = Molecule(
        time_ps=np.zeros(1), frame_number=np.zeros(1, int), name=np.array(["N", "CA", "CB", "HB", "CA"]),
        kind=np.full(5, "protein"), b_factor=np.full(5, np.nan),
        xyz=np.array([[[0.0, 0, 0], [1, 0, 0], [20, 0, 0], [21, 0, 0], [40, 0, 0]]]),
        element=np.array(["N", "C", "C", "H", "C"]), residue_index=np.array([0, 0, 1, 1, 2]),
        chain=np.array(list("AAAAB")), residue=np.array(["1", "1", "2", "2", "1"]),
        residue_name=np.array(["ILE", "ILE", "ARG", "ARG", "GLY"]),
    )  # fmt: skip
    partner = partner_of(surface, molecule, "three", d_link=1.5)
    assert partner.residue.tolist() == [0, 0, 1, 1, 2, 2]
    assert partner.heavy_atoms[:, 0].tolist() == [0, 1, 20, 40]
    residues = pd.DataFrame({"chain": ["A", "B"], "residue": ["2", "1"], "value": [7.0, 9.0]})
    shown = matching.on_atoms(molecule, residues, "value", -1.0)
    assert shown.tolist() == [-1, -1, 7, 7, 9]  # the first residue has no row
