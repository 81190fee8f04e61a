"""Areas against formulas, against positions on spheres that are tried one by one, and against dense dots."""

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

import sparsurf
from conftest import ROOT, sphere
from peptides import atom_line, peptide, write
from sparsurf.cli import command
from sparsurf.errors import InputError
from sparsurf.surfaces.radii import radii as dms_radii

PEPTIDE = ROOT / "data" / "tdp43" / "topology.pdb"  # with hydrogens and four cavities
TRAJECTORY = ROOT / "data" / "tdp43" / "trajectory.xtc"
FORMULA = 1e-6  # Å^2; positions are shifted by 1e-8 Å before the probe is rolled


def heap(n=120, seed=3):
    """A heap of spheres of four radii, with some hidden in others."""
    rng = np.random.default_rng(seed)
    return (rng.normal(size=(n, 3)) * 4).round(3), rng.choice([1.2, 1.5, 1.7, 1.9], n)


def free_shares(xyz, reach, n=20000):
    """Share of n positions on each sphere that lie in no other sphere."""
    unit = sphere(n)[0]
    shares = []
    for i in range(len(xyz)):
        free = np.ones(n, bool)
        for k in np.flatnonzero(np.linalg.norm(xyz - xyz[i], axis=1) < reach + reach[i]):
            if k != i:
                free &= ((xyz[i] + reach[i] * unit - xyz[k]) ** 2).sum(axis=1) >= reach[k] ** 2
        shares.append(free.mean())
    return np.array(shares)


@pytest.mark.parametrize("radius", [0.5, 1.7])
def test_one_sphere(radius):
    areas = sparsurf.areas(([[1.0, 2.0, 3.0]], [radius]), probe_radius=1.2)
    assert areas.accessible == pytest.approx([4 * np.pi * (radius + 1.2) ** 2])
    assert areas.excluded == pytest.approx([4 * np.pi * radius**2])


@pytest.mark.parametrize("distance", [0.2, 1.0, 3.0, 4.5, 5.4, 5.5, 6.0])
def test_two_spheres(distance):
    """Caps cut from two spheres, and the saddle between them by quadrature; from 4.2 Å on it meets the axis, at .2 one hides."""
    radii, probe = np.array([1.4, 1.3]), 1.4
    reach = radii + probe
    areas = sparsurf.areas(([[0, 0, 0], [0, 0, distance]], radii), probe_radius=probe)
    heights = (distance**2 + reach**2 - reach[::-1] ** 2) / (2 * distance)
    if distance <= reach[0] - reach[1]:
        share, saddles = np.array([1.0, 0.0]), [0.0, 0.0]
    elif distance >= reach.sum():
        share, saddles = np.ones(2), [0.0, 0.0]
    else:
        share = (1 + heights / reach) / 2
        wide = np.sqrt(reach[0] ** 2 - heights[0] ** 2)
        ends = -np.arctan2(heights[0], wide), np.arctan2(heights[1], wide)
        halfway = sum(ends) / 2
        saddles = [
            quad(lambda t: 2 * np.pi * probe * max(0.0, wide - probe * np.cos(t)), *ends, limit=400)[0]
            for ends in ((ends[0], halfway), (halfway, ends[1]))
        ]
    assert areas.accessible == pytest.approx(4 * np.pi * reach**2 * share, abs=FORMULA)
    assert areas.excluded == pytest.approx(4 * np.pi * radii**2 * share + saddles, abs=1e-5)


@pytest.mark.parametrize("probe", [0.8, 1.4, 3.0])
def test_accessible_areas_are_those_of_positions_tried_one_by_one(probe):
    xyz, radii = heap()
    areas = sparsurf.areas((xyz, radii), probe_radius=probe)
    shares = free_shares(xyz, radii + probe)
    assert (shares == 0).sum() > 5  # some are hidden
    assert areas.accessible / (4 * np.pi * (radii + probe) ** 2) == pytest.approx(shares, abs=7e-4)


@pytest.mark.parametrize(("probe", "total"), [(0.8, 2e-4), (1.4, 5e-4), (3.0, 1e-3)])
@pytest.mark.parametrize("source", ["heap", "peptide"])
def test_excluded_areas_are_those_of_dense_dots(source, probe, total):
    molecule = heap() if source == "heap" else PEPTIDE
    excluded = sparsurf.areas(molecule, probe_radius=probe).excluded
    dots = sparsurf.surface(molecule, probe_radius=probe, density=90.0)
    of_dots = np.bincount(dots.atom, dots.area, len(excluded))
    assert excluded.sum() == pytest.approx(of_dots.sum(), rel=total)
    assert excluded == pytest.approx(of_dots, abs=0.8)
    assert np.abs(excluded - of_dots).mean() < 0.15


def test_three_spheres_whose_probes_on_both_sides_overlap():
    """The two probes that touch three spheres cut each other where these lie in a ring: the patch of each ends at its plane."""
    side, radius, probe = 3.4, 1.5, 1.4
    xyz = side / np.sqrt(3) * np.array([[np.cos(a), np.sin(a), 0] for a in 2 * np.pi * np.arange(3) / 3])
    height = np.sqrt((radius + probe) ** 2 - side**2 / 3)
    assert height > probe  # whole triangles: the area by their corners
    far = sparsurf.areas((xyz, [radius] * 3), probe_radius=probe)
    dots = sparsurf.surface((xyz, [radius] * 3), probe_radius=probe, density=100.0)
    assert far.excluded == pytest.approx(
        np.full(3, far.excluded[0]), abs=0.005
    )  # positions are rounded to 0.001 Å
    assert far.excluded.sum() == pytest.approx(dots.area.sum(), rel=2e-4)


def test_areas_do_not_depend_on_place_and_order():
    xyz, radii = heap()
    areas, order = sparsurf.areas((xyz, radii)), np.random.default_rng(1).permutation(len(xyz))
    turned = Rotation.from_rotvec([0.3, -1.1, 0.7]).apply(xyz) + np.array([100, -50, 7])
    moved = sparsurf.areas((turned[order], radii[order]))
    assert moved.accessible == pytest.approx(areas.accessible[order], abs=0.03)
    assert moved.excluded == pytest.approx(areas.excluded[order], abs=0.03)


def test_spheres_that_hardly_touch_and_spheres_at_one_place(caplog):
    whole = 4 * np.pi * 3.1**2
    apart = sparsurf.areas(([[0, 0, 0], [6.1995, 0, 0]], [1.7, 1.7])).accessible
    assert apart == pytest.approx([whole, whole], abs=0.01) and (apart < whole).all()
    for small in (1.2, 1.3):  # a molecule is told about though another one was
        caplog.clear()
        twice = sparsurf.areas(([[0, 0, 0], [0, 0, 0]], [small, 1.7]))
        assert twice.accessible == pytest.approx([0, whole]) and "left out" in caplog.text


def test_sums_by_residue_and_chain_and_relative_areas(tmp_path):
    """A peptide of two chains: a residue of force fields has the maximum of the residue it stands for, a ligand none."""
    names = [("ALA", "HIE", "ALA"), ("GLY", "ALA")]
    lines = peptide(names[0]) + peptide(names[1], chain="B", origin=(0, 0, 6))
    lines += atom_line("C1", "UNL", "B", "9", (20.0, 20.0, 20.0), record="HETATM")
    molecule = sparsurf.read_molecule(write(tmp_path / "two.pdb", lines + "END\n"), selection="all")
    areas = sparsurf.areas(molecule, radii="bondi")
    atoms, residues, chains = areas.atoms, areas.residues, areas.chains
    assert atoms["chain"].tolist() == molecule.chain.tolist()
    assert chains["chain"].tolist() == ["A", "B", "UNL 9 B"]
    atoms["chain"] = np.where(atoms["residue_name"] == "UNL", "UNL 9 B", atoms["chain"])
    for table, keys in ((residues, ["chain", "residue"]), (chains, ["chain"])):
        sums = atoms.groupby(keys, sort=False)[["accessible", "excluded", "buried"]].sum()
        assert np.allclose(table[sums.columns], sums)
    largest = pd.Series({"ALA": 129.0, "HIE": 224.0, "GLY": 104.0})
    expected = residues["accessible"] / residues["residue_name"].map(largest)
    assert np.allclose(residues["relative"], expected, equal_nan=True)
    assert residues["relative"].isna().tolist() == [False] * 5 + [True]


@pytest.fixture(scope="module")
def three_chains(tmp_path_factory):
    """Three peptides side by side, of which the outer ones do not touch."""
    path = tmp_path_factory.mktemp("areas") / "three.pdb"
    chains = [peptide(("ALA", "SER", "LYS"), chain=c, origin=(0, 0, 6 * k)) for k, c in enumerate("ABC")]
    return sparsurf.read_molecule(write(path, "".join(chains) + "END\n"))


def test_buried_areas_are_those_of_the_parts_without_those_of_the_complex(three_chains):
    areas = sparsurf.areas(three_chains)
    alone = {name: sparsurf.areas(three_chains.select(chains=name)).accessible for name in "ABC"}
    together = {name: areas.accessible[three_chains.chain == name] for name in "ABC"}
    for name in "ABC":
        own = areas.buried[three_chains.chain == name]
        assert own == pytest.approx(alone[name] - together[name], abs=1e-5)
        assert (own >= 0).all() and (own == 0).any() and own.sum() > 10
    pairs = areas.pairs
    assert list(zip(pairs["chain"], pairs["other"], strict=True)) == [
        ("A", "B"),
        ("B", "A"),
        ("B", "C"),
        ("C", "B"),
    ]
    of_two = sparsurf.areas(three_chains.select(chains="A,B")).chains["buried"]
    assert pairs["buried"][:2].tolist() == pytest.approx(of_two.tolist())


def test_a_frame_has_the_areas_of_its_positions():
    molecule = sparsurf.read_molecule(PEPTIDE, TRAJECTORY, stride=1000)
    areas = [sparsurf.areas(molecule, frame=f) for f in range(2)]
    assert np.array_equal(areas[1].accessible, sparsurf.areas(molecule.frame(1)).accessible)
    assert abs(areas[0].accessible.sum() - areas[1].accessible.sum()) > 10


def test_dots_of_the_accessible_surface_touch_their_sphere_alone_and_have_its_area():
    molecule = sparsurf.read_molecule(PEPTIDE, TRAJECTORY, stride=1000)
    dots = sparsurf.surface(molecule, frame=1, boundary="accessible", density=2.0, probe_radius=1.2)
    reach = dms_radii(molecule) + 1.2
    distance = np.linalg.norm(dots.points[:, None] - molecule.xyz[1].round(3), axis=2)
    assert distance[np.arange(len(dots)), dots.atom] == pytest.approx(reach[dots.atom], abs=1e-6)
    assert (distance - reach).min() > -1e-6
    assert dots.points - reach[dots.atom, None] * dots.normals == pytest.approx(
        molecule.xyz[1].round(3)[dots.atom], abs=1e-6
    )
    accessible = sparsurf.areas(molecule, frame=1, probe_radius=1.2).accessible
    assert dots.area.sum() == pytest.approx(accessible.sum())
    assert np.bincount(dots.atom, dots.area) == pytest.approx(accessible, abs=1.0)


def test_the_accessible_surface_without_cavities_lacks_their_area_alone():
    whole, outside = (
        sparsurf.surface(PEPTIDE, boundary="accessible", cavities=c) for c in ("keep", "remove")
    )
    assert 0 < len(whole) - len(outside) < 100 and 0 < whole.area.sum() - outside.area.sum() < 5
    with pytest.raises(InputError, match="give the molecule"):
        sparsurf.surface(sparsurf.surface_atoms(PEPTIDE), boundary="accessible")
    with pytest.raises(InputError, match="reentrant applies"):
        sparsurf.surface(PEPTIDE, boundary="accessible", reentrant="dms")


def test_the_command_writes_the_tables(three_chains, tmp_path, capsys):
    three_chains.write_pdb(tmp_path / "three.pdb")
    areas = sparsurf.areas(three_chains)
    for rows in ("atoms", "residues", "chains", "pairs"):
        assert (
            command.main(["areas", str(tmp_path / "three.pdb"), "--of", rows, "-o", str(tmp_path / "a.csv")])
            == 0
        )
        written, table = pd.read_csv(tmp_path / "a.csv"), getattr(areas, rows)
        assert list(written) == list(table) and np.allclose(written["buried"], table["buried"])
    assert f"{areas.accessible.sum():,.1f} Å^2 accessible" in capsys.readouterr().err
    (tmp_path / "s.xyzr").write_text("0 0 0 1.7\n0 0 2 1.5\n")
    assert command.main(["areas", str(tmp_path / "s.xyzr"), "-o", str(tmp_path / "s.csv")]) == 0
    assert list(pd.read_csv(tmp_path / "s.csv")) == ["atom", "accessible", "excluded"]


def test_what_has_no_areas_is_refused_in_a_sentence(three_chains, tmp_path):
    with pytest.raises(InputError, match="dots hold"):
        sparsurf.areas(sparsurf.Surface([[0, 0, 0]], [[0, 0, 1]]))
    with pytest.raises(InputError, match="spheres have no residues"):
        _ = sparsurf.areas(([[0, 0, 0]], [1.5])).residues
    names = ("ALA", "SER")
    overlapping = peptide(names) + peptide(names, chain="B") + "END\n"
    with pytest.raises(
        InputError,
        match="position of an atom of another chain or ligand, the first ones in ALA 1 A and ALA 1 B",
    ):
        sparsurf.areas(write(tmp_path / "twice.pdb", overlapping))
    with pytest.raises(InputError, match="no frame 3"):
        sparsurf.areas(three_chains, frame=3)
