"""What buries what: chains, ligands and named groups, against positions on spheres that are tried one by one."""

import gzip
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import sparsurf
from conftest import sphere
from peptides import atom_line, peptide, write
from sparsurf.api.surroundings import contacts_on_page
from sparsurf.cli import command
from sparsurf.errors import InputError
from sparsurf.molecules.selection import groups_of_atoms, partners_of_atoms
from sparsurf.surfaces.radii import radii as radii_of
from sparsurf.surfaces.surface import Placement

NAMES = ("ALA", "SER", "LYS")
FAR = 0.35  # Å^2 that areas by positions may differ from exact ones


def complex_of(shift=0.0):
    """Three chains of which B lies between A and C, two ligands that bear the letter A, of one name, and a water."""
    text = "".join(peptide(NAMES, chain, origin=(0, 0, 5.0 * k)) + "TER\n" for k, chain in enumerate("ABC"))
    for number, place in (("500", (1.5, 4.3, -1.5 - shift)), ("501", (5.0, -2.0, 7.5))):
        text += atom_line("C1", "LIG", "A", number, place, record="HETATM")
        text += atom_line("C2", "LIG", "A", number, np.add(place, (0.9, 1.2, 0)), record="HETATM")
    return text + atom_line("O", "HOH", "A", "600", (9.0, 6.0, 2.5), record="HETATM")


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return write(tmp_path_factory.mktemp("partners") / "three.pdb", complex_of() + "END\n")


def tried(molecule, present, frame=0, n=6000):
    """Accessible area of the atoms that are present, by n positions on the sphere of each."""
    xyz, reach, unit = molecule.xyz[frame].round(3), radii_of(molecule, "bondi") + 1.4, sphere(n)[0]
    areas = np.zeros(len(xyz))
    for atom in np.flatnonzero(present):
        places = xyz[atom] + reach[atom] * unit
        free = np.ones(n, bool)
        for k in np.flatnonzero(present):
            free &= (k == atom) | (((places - xyz[k]) ** 2).sum(axis=1) >= reach[k] ** 2)
        areas[atom] = free.mean() * 4 * np.pi * reach[atom] ** 2
    return areas


def buried_of(molecule, own, other, frame=0):
    """Area of each atom of its own group that another group buries where both are alone."""
    return tried(molecule, own, frame) * own - tried(molecule, own | other, frame) * own


def test_partners_that_are_far_apart_have_no_contacts(tmp_path):
    far = peptide(NAMES) + "TER\n" + peptide(NAMES, "B", origin=(0, 0, 40.0)) + "END\n"
    found = sparsurf.areas(write(tmp_path / "far.pdb", far))
    assert not len(found.contacts) and not len(found.pairs) and found.buried.sum() == 0


def test_each_chain_and_each_ligand_is_a_partner_and_all_waters_are_one(path):
    molecule = sparsurf.read_molecule(path, selection="all")
    partners = partners_of_atoms(molecule)
    assert partners.names == ["A", "B", "C", "LIG 500 A", "LIG 501 A", "water"]
    table = sparsurf.areas(molecule, radii="bondi").chains.set_index("chain")
    assert table.index.tolist() == partners.names
    for name in ("A", "LIG 500 A"):
        own = partners.labels == name
        alone = tried(molecule, own)[own].sum()
        together = tried(molecule, np.ones(molecule.n_atoms, bool))[own].sum()
        assert table.loc[name, "accessible"] == pytest.approx(together, abs=3 * FAR)
        assert (
            table.loc[name, "buried"] == pytest.approx(alone - together, abs=3 * FAR) and alone > together + 5
        )


@pytest.mark.parametrize(
    ("groups", "members"),
    [
        ("A,C+B", {"A,C": ["A", "C"], "B": ["B"]}),
        ([["A", "C"], "B"], {"A,C": ["A", "C"], "B": ["B"]}),
        ("B+A", {"B": ["B"], "A": ["A"]}),
        ("A+LIG", {"A": ["A"], "LIG": ["LIG"]}),  # an atom belongs to the group that names it most closely
        ("LIG+A,B", {"LIG": ["LIG"], "A,B": ["A", "B"]}),
        ("A+A:1-2,B", {"A": ["A3"], "A:1-2,B": ["A1", "A2", "B"]}),
        ("A:1-501+LIG", {"A:1-501": ["A"], "LIG": ["LIG"]}),  # a ligand inside of the range of another group
        ("LIG+A:1-3,A:400-501,B", {"LIG": ["LIG"], "A:1-3,A:400-501,B": ["A", "B"]}),
        ("LIG,A:1-2+A,B", {"LIG,A:1-2": ["LIG", "A1", "A2"], "A,B": ["A3", "B"]}),
    ],
)
def test_groups_hold_what_they_name_most_closely_and_nothing_else_is_present(path, groups, members):
    areas = sparsurf.areas(path, radii="bondi", groups=groups)
    molecule = areas.molecule
    chain = np.where(molecule.residue_name == "LIG", "LIG", molecule.chain)
    labels = np.char.add(chain, molecule.residue)
    masks = {name: np.isin(chain, of) | np.isin(labels, of) for name, of in members.items()}
    first, second = masks.values()
    assert (first ^ second).all()  # each atom is in one, and no other atom is there
    pairs = areas.pairs
    assert list(pairs) == ["group", "other", "buried"]
    for (name, own), (other_name, other) in zip(masks.items(), [*masks.items()][::-1], strict=True):
        expected = buried_of(molecule, own, other)
        assert areas.buried[own] == pytest.approx(expected[own], abs=FAR)
        row = pairs[(pairs["group"] == name) & (pairs["other"] == other_name)]
        assert row["buried"].item() == pytest.approx(areas.buried[own].sum()) and areas.buried[own].sum() > 5
    assert areas.groups["group"].tolist() == [*members]
    assert areas.groups["buried"].sum() == pytest.approx(areas.buried.sum())


def test_contacts_are_those_of_two_partners_alone_and_sum_to_pairs(path):
    """C lies behind B, which stands in no way of what A and LIG bury of each other."""
    molecule = sparsurf.read_molecule(path, ligands="LIG")
    areas = sparsurf.areas(molecule, radii="bondi")
    partners, contacts = partners_of_atoms(molecule), areas.contacts
    assert list(contacts) == ["chain", "residue", "residue_name", "partner", "buried", "distance"]
    for this, that in (("A", "B"), ("B", "A"), ("B", "LIG 501 A"), ("LIG 501 A", "C")):
        expected = buried_of(molecule, partners.labels == this, partners.labels == that)
        of_residues = pd.Series(expected).groupby(molecule.residue_index).sum()
        labels = molecule.residues.assign(expected=of_residues, partner=that)
        found = labels.merge(contacts, how="left").fillna({"buried": 0.0})
        of_this = found.iloc[np.unique(molecule.residue_index[partners.labels == this])]
        assert of_this["buried"].to_numpy() == pytest.approx(of_this["expected"].to_numpy(), abs=2 * FAR)
    sums = contacts.groupby("partner")["buried"].sum()
    assert sums.to_dict() == pytest.approx(areas.pairs.groupby("other")["buried"].sum().to_dict())
    both = areas.pairs.set_index(["chain", "other"])["buried"]
    assert ("A", "C") not in both.index and both["A", "B"] != pytest.approx(both["B", "A"], abs=0.1)


def test_contacts_of_a_file_have_rows_of_its_ligands_and_all_other_areas_are_without_them(path, tmp_path):
    found = sparsurf.areas(path)
    whole = sparsurf.areas(sparsurf.read_molecule(path, ligands=True))
    pd.testing.assert_frame_equal(found.contacts, whole.contacts)
    alone = sparsurf.areas(sparsurf.read_molecule(path))
    for table in ("residues", "pairs", "chains"):
        pd.testing.assert_frame_equal(getattr(found, table), getattr(alone, table))
    without = whole.contacts[
        ~(whole.contacts["partner"] + whole.contacts["residue_name"]).str.contains("LIG")
    ]
    pd.testing.assert_frame_equal(without.reset_index(drop=True), alone.contacts)
    command.main(["areas", str(path), "--of", "contacts", "-o", str(tmp_path / "contacts.csv")])
    written = pd.read_csv(tmp_path / "contacts.csv", dtype={"residue": str})
    pd.testing.assert_frame_equal(written, whole.contacts, check_dtype=False, rtol=1e-6)


def test_the_distance_of_a_contact_is_that_of_the_nearest_atoms(path):
    molecule = sparsurf.read_molecule(path, ligands="all")
    labels = partners_of_atoms(molecule).labels
    for row in sparsurf.areas(molecule).contacts.itertuples():
        own = (molecule.chain == row.chain) & (molecule.residue == row.residue)
        steps = molecule.xyz[0][own][:, None] - molecule.xyz[0][labels == row.partner]
        assert row.distance == pytest.approx(np.linalg.norm(steps, axis=2).min(), abs=1e-9)


def test_a_ligand_at_the_place_of_the_protein_is_left_out_of_contacts_and_named(tmp_path, caplog):
    of_side_chain = next(line for line in complex_of().splitlines() if " CB  SER" in line)
    place = [float(of_side_chain[k : k + 8]) for k in (30, 38, 46)]
    text = complex_of() + atom_line("C1", "BAD", "A", "700", place, record="HETATM")
    text += atom_line("C2", "BAD", "A", "700", np.add(place, (0.9, 1.2, 0)), record="HETATM")
    overlapping = write(tmp_path / "overlapping.pdb", text + "END\n")
    right = sparsurf.areas(write(tmp_path / "three.pdb", complex_of() + "END\n")).contacts
    pd.testing.assert_frame_equal(sparsurf.areas(overlapping).contacts, right)
    assert "BAD 700 A" in caplog.text and "LIG 500" not in caplog.text and "choose ligands" in caplog.text
    command.main(["areas", str(overlapping), "--of", "contacts", "-o", str(tmp_path / "contacts.csv")])
    assert len(pd.read_csv(tmp_path / "contacts.csv")) == len(right)


def test_each_residue_is_a_partner_if_asked_for(path):
    areas = sparsurf.areas(path, radii="bondi", groups="residues")
    labels = np.array([areas.molecule.residue_label(k) for k in range(areas.molecule.n_atoms)])
    rows = areas.contacts.set_index(["chain", "residue", "partner"])["buried"]
    for own, other in (("SER 2 A", "LYS 3 A"), ("LYS 3 A", "LYS 3 B")):
        _, residue, chain = own.split()
        expected = buried_of(areas.molecule, labels == own, labels == other).sum()
        assert rows[chain, residue, other] == pytest.approx(expected, abs=2 * FAR) and expected > 5
    alone = tried(areas.molecule, labels == "ALA 1 A").sum()
    first = areas.residues.iloc[0]
    assert first["share_buried"] == pytest.approx(1 - first["accessible"] / alone, abs=0.01)


def test_of_a_list_of_ligands_those_that_a_file_has_are_read(path, caplog):
    found = sparsurf.read_molecule(path, ligands=["LIG", "HEM"])
    assert (found.residue_name == sparsurf.read_molecule(path, ligands="all").residue_name).all()
    assert "ligand HEM" in caplog.text
    with pytest.raises(InputError, match="ligand HEM, ZN"):
        sparsurf.read_molecule(path, ligands=["HEM", "ZN"])
    assert sparsurf.read_molecule(path, ligands="true").n_atoms == found.n_atoms
    with pytest.raises(InputError, match="all means every ligand"):
        sparsurf.read_molecule(path, ligands="LIG,all")


def test_main_chains_side_chains_and_polar_atoms_have_the_areas_of_their_atoms(tmp_path):
    """With hydrogens, which count as the atom that they are bonded to, a nucleotide and a ligand."""
    lines = (
        peptide(("ALA",) * 9)
        + atom_line("H", "ALA", "A", "2", (3.4, 0.5, 0.0))
        + atom_line("HB", "ALA", "A", "2", (5.5, 0.1, 2.1))
    )
    for name, place in (("P", (20, 0, 0)), ("O5'", (21.6, 0, 0)), ("N9", (25, 0, 0)), ("C8", (26.3, 0, 0))):
        lines += atom_line(name, "A", "B", "1", place)
    lines += atom_line("O1", "LIG", "C", "1", (40, 0, 0), record="HETATM")
    molecule = sparsurf.read_molecule(write(tmp_path / "a.pdb", lines + "END\n"), selection="all")
    areas = sparsurf.areas(molecule, radii="bondi")
    table = areas.residues.set_index(["chain", "residue"])
    main = np.isin(molecule.name, ["N", "CA", "C", "O", "H", "P", "O5'"]) & (molecule.residue_name != "LIG")
    polar = np.isin(molecule.name, ["N", "O", "H", "O5'", "N9", "O1"])
    serine = (molecule.chain == "A") & (molecule.residue == "2")
    assert areas.accessible[serine & (molecule.element == "H")].min() > 1
    for key, own in (
        (("A", "2"), serine),
        (("B", "1"), molecule.chain == "B"),
        (("C", "1"), molecule.chain == "C"),
    ):
        of_own = table.loc[key]
        expected = [
            areas.accessible[own & mask].sum()
            for mask in (main, ~main & (molecule.kind != "other"), polar, ~polar)
        ]
        assert of_own[["main_chain", "side_chain", "polar", "apolar"]].tolist() == pytest.approx(expected)


def test_frames_and_areas_have_the_same_groups_and_contacts(tmp_path):
    """The ligand leaves step by step; occupancy counts the frames in which at least 1 Å^2 is buried."""
    models = "".join(f"MODEL     {k + 1:4d}\n{complex_of(1.4 * k)}ENDMDL\n" for k in range(6))
    path = write(tmp_path / "six.pdb", models + "END\n")
    tables = sparsurf.frames(path, groups="B,C+A+LIG", radii="bondi")
    each = [sparsurf.areas(path, frame=k, groups="B,C+A+LIG", radii="bondi") for k in range(6)]
    for k, areas in enumerate(each):
        rows = tables.residues[tables.residues["frame"] == k]
        for name in ("accessible", "buried"):
            np.testing.assert_allclose(rows[name], areas.residues[name], atol=1e-9)
    keys = ["chain", "residue", "residue_name", "partner"]
    contacts = pd.concat([areas.contacts for areas in each]).groupby(keys)["buried"]
    found = tables.contacts.set_index(keys)
    assert set(found.index) == set(contacts.groups)
    expected = {
        "occupancy": contacts.agg(lambda buried: (buried >= 1).sum() / 6),
        "mean": contacts.sum() / 6,
        "highest": contacts.max(),
    }
    for name, values in expected.items():
        np.testing.assert_allclose(found[name], values[found.index], atol=1e-9)
    of_ligand = found.xs("LIG", level="partner").loc["A"]
    assert of_ligand["occupancy"].between(0.1, 0.9).any()
    for jobs in (1, 2):
        sparsurf.frames(
            path, path=tmp_path / f"run{jobs}.csv", groups=["B,C", "A", "LIG"], radii="bondi", jobs=jobs
        )
    assert (tmp_path / "run1_contacts.csv").read_bytes() == (tmp_path / "run2_contacts.csv").read_bytes()
    written = pd.read_csv(tmp_path / "run1_contacts.csv")
    np.testing.assert_allclose(written["mean"], tables.contacts["mean"], rtol=1e-8)


def test_the_command_reads_what_groups_name_and_reports_rows_of_the_whole(path, tmp_path, capsys):
    def table(*words):
        assert (
            command.main(["areas", str(path), *words, "--radii", "bondi", "-o", str(tmp_path / "a.csv")]) == 0
        )
        return pd.read_csv(tmp_path / "a.csv", dtype={"residue": str})

    pairs = table("--groups", "A,B+LIG", "--of", "pairs")
    expected = sparsurf.areas(path, groups=["A,B", "LIG"], radii="bondi").pairs
    assert pairs["group"].tolist() == ["A,B", "LIG"] and pairs["buried"].tolist() == pytest.approx(
        expected["buried"].tolist()
    )
    assert "15 heavy atoms" in capsys.readouterr().err
    whole, rows = table(), table("--residues", "B:2-3")
    pd.testing.assert_frame_equal(rows, whole.iloc[[4, 5]].reset_index(drop=True))
    contacts = table("--residues", "B:2-3", "--of", "contacts")
    assert set(contacts["residue"]) == {"2", "3"} and set(contacts["chain"]) == {"B"}
    assert "measured alone" not in capsys.readouterr().err
    assert table("--selection", "sidechain")["accessible"].sum() != pytest.approx(
        whole["side_chain"].sum(), rel=0.05
    )
    assert "other 36 heavy" in capsys.readouterr().err
    assert (
        command.main(
            ["areas", str(path), "--residues", "B:2", "--of", "pairs", "-o", str(tmp_path / "a.csv")]
        )
        == 1
    )
    assert "rows of residues" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        ("A", "partner; name"),
        ("A,B,C", "one group has no partner"),
        ("A+Q", "'Q' is no chain, range or ligand of .* chains A, B, C, and besides polymers HOH, LIG"),
        ("A:1-2+A:2-3", "'A:2-3' is in two groups"),
        ("A+B,A", "'A' is in two groups"),
        ("A+", "a group or a name in it is empty"),
        ("A+A:1-3", "is left for the group 'A'"),
        ("B+A:500", "group 'A:500'"),
        ("1-2+LIG", "residues '1-2'"),
        (5, "groups is 5;"),
    ],
)
def test_what_is_no_group_is_refused_in_a_sentence(path, groups, message):
    with pytest.raises(InputError, match=message):
        sparsurf.areas(path, groups=groups)


def test_spheres_have_no_groups_and_a_molecule_in_memory_keeps_its_ligands(path):
    with pytest.raises(InputError, match="spheres have no chains"):
        sparsurf.areas(([[0, 0, 0], [0, 0, 3]], [1.5, 1.5]), groups="A+B")
    molecule = sparsurf.read_molecule(path, ligands="LIG")
    partners = groups_of_atoms(molecule, "A+B")  # whose letter the ligands bear
    assert set(molecule.residue_name[partners.number == 0].tolist()) == {*NAMES, "LIG"}


@pytest.mark.parametrize(
    ("name", "groups", "wanted"),
    [  # Shrake-Rupley of 10,000 points on spheres of Bondi
        ("bad/eighth/ligand_same_chain.pdb", "A+LIG", {"A": 29.49, "LIG": 26.97}),
        ("structures/1hvr_dimer_ligand_CSO.pdb", "A+B", {"A": 1857.7, "B": 1851.2}),
    ],
)
def test_buried_areas_of_structures(shared, name, groups, wanted):
    pairs = sparsurf.areas(shared / "data" / name, groups=groups, radii="bondi").pairs
    assert pairs.set_index("group")["buried"].to_dict() == pytest.approx(wanted, abs=0.06)


def test_side_chains_and_polar_atoms_of_a_structure(shared):
    """Of another implementation by positions, on spheres of Bondi."""
    areas = sparsurf.areas(shared / "data/bad/eighth/plain.pdb", radii="bondi")
    table = areas.residues.set_index("residue")
    assert table.loc["226", "accessible"] == pytest.approx(173.6, abs=0.05)
    assert 31.0 <= table.loc["210", "side_chain"] <= 31.2
    assert areas.chains[["polar", "apolar"]].iloc[0].tolist() == pytest.approx([2885.5, 2921.7], abs=1.5)


def test_contacts_pairs_and_the_page_agree_on_a_dimer_with_its_ligand(shared):
    molecule = sparsurf.read_molecule(shared / "data/structures/1hvr_dimer_ligand_CSO.pdb", ligands="XK2")
    areas = sparsurf.areas(molecule)
    assert set(areas.pairs["chain"]) == {"A", "B", "XK2 263 A"}
    sums = areas.contacts.assign(own=partners_of_residues(areas)).groupby(["own", "partner"])["buried"].sum()
    pairs = areas.pairs.set_index(["chain", "other"])["buried"]
    pd.testing.assert_series_equal(sums, pairs.sort_index(), check_names=False)
    page = contacts_on_page(molecule, [molecule.xyz[0]], Placement())
    names = {f"chain {name}": name for name in "AB"}
    listed = areas.contacts[areas.contacts["buried"] >= 1].sort_values("buried", ascending=False)
    assert page["mean"].tolist() == pytest.approx(listed["buried"].tolist())
    assert page["partner"].replace(names).tolist() == listed["partner"].tolist()
    labels = molecule.residues.iloc[page["number"]]
    assert labels["residue"].tolist() == listed["residue"].tolist()
    # two partners cover the same place of the ligand, so that their areas add up to more than both bury
    ligand, own = page[page["own"] == "XK2 263 A"], areas.partners.labels == "XK2 263 A"
    assert ligand["together"].tolist() == pytest.approx([areas.buried[own].sum()] * 2)
    assert ligand["together"].iloc[0] == pytest.approx(792.0, abs=0.1) and ligand["mean"].sum() > 940


def partners_of_residues(areas):
    """The partner that each residue of the contacts belongs to."""
    molecule = areas.molecule
    own = dict(zip(molecule.residue_index, areas.partners.labels, strict=True))
    numbers = {
        label: k
        for k, label in enumerate(molecule.residues[["chain", "residue"]].itertuples(index=False, name=None))
    }
    labels = areas.contacts[["chain", "residue"]].itertuples(index=False, name=None)
    return [own[numbers[label]] for label in labels]


def test_groups_have_the_areas_of_another_program(shared, tmp_path):
    """Of FreeSASA, by 100 slices of each atom, for the chains of 46 complexes together and alone."""
    freesasa = pytest.importorskip("freesasa", reason="freesasa is installed by the extra `evidence`")
    parameters = freesasa.Parameters({"algorithm": freesasa.LeeRichards, "n-slices": 100, "n-threads": 1})

    def accessible(xyz, radii):
        result = freesasa.calcCoord(xyz.ravel(), radii, parameters)
        return np.array([result.atomArea(k) for k in range(len(radii))])

    paths = sorted((shared / "data/complexes/bound").glob("*_l.pdb.gz"))
    assert len(paths) == 46
    for path in paths:
        sides = [gzip.decompress(Path(str(path).replace("_l.", f"_{side}.")).read_bytes()) for side in "rl"]
        lines = [line for side in sides for line in side.splitlines(True) if line.startswith(b"ATOM")]
        (tmp_path / "both.pdb").write_bytes(b"".join(lines))
        areas = sparsurf.areas(tmp_path / "both.pdb", groups="A+B", radii="bondi")
        molecule, table = areas.molecule, areas.groups
        xyz, radii = molecule.xyz[0].round(3), radii_of(molecule, "bondi")
        together = accessible(xyz, radii)
        for k, name in enumerate("AB"):
            own = molecule.chain == name
            alone = accessible(xyz[own], radii[own]).sum()
            row = table.iloc[k]
            assert row["accessible"] == pytest.approx(together[own].sum(), rel=1e-3), path.name
            assert row["accessible"] + row["buried"] == pytest.approx(alone, rel=1e-3), path.name
