"""What a residue is and which of its locations count: small tables with one answer each."""

import numpy as np
import pytest

from peptides import ALANINE, STEP, atom_line, peptide
from sparsurf.errors import InputError
from sparsurf.molecules.atom_table import atom_table, choose_altlocs, gather_residues, missing_residues
from sparsurf.molecules.mmcif import read_mmcif
from sparsurf.molecules.pdb import _decode_number, encode_label, read_pdb
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.molecules.residues import (
    HEAVY_ATOMS,
    count_heavy_atoms,
    element_of,
    find_particles,
    residue_kinds,
)

NUCLEOTIDE = {"P": (0, 0, 0), "C5'": (1.5, 0, 0), "C3'": (3, 0, 0), "O3'": (4.4, 0, 0)}


def kinds(*residues, hetero):
    """Kind of each residue, given as (name, atoms, shift along x in Å)."""
    rows = [
        (name, r, atom, np.add(place, (shift, 0, 0)))
        for r, (name, atoms, shift) in enumerate(residues)
        for atom, place in atoms.items()
    ]
    names, index, atoms, xyz = map(np.array, zip(*rows, strict=True))
    return residue_kinds(names, index, atoms, np.array(hetero)[index], xyz)[0].tolist()


# ---- bonds of residues that the file marks as hetero groups


def test_hetero_groups_belong_to_the_protein_where_a_peptide_bond_says_so():
    alone, bonded = ALANINE, {name: np.add(place, STEP) for name, place in ALANINE.items()}
    assert kinds(("ALA", alone, 0), hetero=[True]) == ["other"]
    assert kinds(("ALA", alone, 0), hetero=[False]) == ["protein"]
    assert kinds(("ALA", alone, 0), ("XYZ", bonded, 0), hetero=[False, True]) == ["protein"] * 2
    assert kinds(("XYZ", alone, 0), ("ALA", bonded, 0), hetero=[True, True]) == ["protein"] * 2
    assert kinds(("ALA", alone, 0), ("ALA", bonded, 5), hetero=[False, True]) == ["protein", "other"]
    bonded = {name: np.add(place, STEP) for name, place in ALANINE.items()}  # C-N 1.33 Å
    for longer, kind in ((0.5, "protein"), (0.8, "other")):
        assert kinds(("ALA", ALANINE, 0), ("XYZ", bonded, longer), hetero=[False, True])[1] == kind


def test_what_is_bonded_to_the_end_of_a_chain_belongs_to_it_and_a_ligand_nearby_does_not():
    next_atom = np.add(ALANINE["N"], STEP)
    for name, shift, kind in (
        ("N", 0, "protein"), ("C7", 0, "protein"), ("N", 0.6, "other"), ("HN", 0, "other"),
    ):  # fmt: skip
        ligand = {name: np.add(next_atom, (shift, 0, 0)), "C9": np.add(next_atom, (shift + 1.4, 0, 0))}
        assert kinds(("ALA", ALANINE, 0), ("LIG", ligand, 0), hetero=[False, True]) == ["protein", kind]
        assert kinds(("LIG", ligand, 0), ("ALA", ALANINE, 0), hetero=[True, False]) == [kind, "protein"]
    c = np.add(ALANINE["C"], (0, 0, 0))
    for distance, kind in ((1.0, "other"), (1.2, "protein"), (1.7, "protein"), (1.8, "other")):
        place = c + np.array([np.cos(1), np.sin(1), 0]) * distance  # away from the other atoms of the residue
        ligand = {"C7": place, "C9": place + np.array([0, 1.0, 1.0])}
        assert kinds(("ALA", ALANINE, 0), ("LIG", ligand, 0), hetero=[False, True])[1] == kind, distance
    for gap, kind in ((2.0, "protein"), (2.4, "other")):  # between the atoms of the ligand itself
        ligand = {"C7": next_atom, "C9": np.add(next_atom, (gap, 0, 0))}
        assert kinds(("ALA", ALANINE, 0), ("LIG", ligand, 0), hetero=[False, True])[1] == kind, gap
    for atoms in (
        {"O": next_atom},
        {"N": next_atom, "C9": (9, 9, 9)},
    ):  # an ion, and dummy atoms of one number
        assert kinds(("ALA", ALANINE, 0), ("ION", atoms, 0), hetero=[False, True])[1] == "other"


def test_water_is_known_by_its_atoms_whatever_its_name():
    water = {"O": (0, 0, 0), "H1": (1, 0, 0), "H2": (0, 1, 0), "EPW": (0.1, 0.1, 0)}
    phenol = {"O": (0, 0, 0), "H1": (1, 0, 0), "C1": (0, 1, 0)}
    for name, atoms, kind in (
        ("XYZ", water, "water"), ("OPC", {"O": (0, 0, 0)}, "water"), ("XYZ", {"O": (0, 0, 0)}, "other"),
        ("OPC", phenol, "other"), ("OPC", {"O": (0, 0, 0), "D1": (1, 0, 0)}, "water"),
        ("XYZ", dict([*water.items()][:2]), "other"),
        ("XYZ", water | {"H3": (0, 0, 1)}, "other"), ("XYZ", {"O": (0, 0, 0), "1H": (1, 0, 0), "2H": (0, 1, 0)}, "water"),
        ("XYZ", water | {"O2": (9, 0, 0)}, "other"),
    ):  # fmt: skip
        assert kinds((name, atoms, 0), hetero=[True]) == [kind], (name, atoms)


def test_hetero_nucleotides_belong_together_within_a_phosphodiester_bond():
    for gap, kind in ((1.6, "nucleic"), (2.1, "nucleic"), (2.3, "other"), (9.0, "other")):
        pair = ("DA", NUCLEOTIDE, 0), ("DC", NUCLEOTIDE, 4.4 + gap)
        assert kinds(*pair, hetero=[True, True]) == [kind] * 2, gap
    strand = [(f"D{base}", NUCLEOTIDE, 6.0 * k) for k, base in enumerate("ACGT")]
    for far in (0, 3):
        moved = [(name, atoms, shift + 30 * (k == far)) for k, (name, atoms, shift) in enumerate(strand)]
        wanted = ["other" if k == far else "nucleic" for k in range(4)]
        assert kinds(*moved, hetero=[True] * 4) == wanted


def test_heavy_atoms_are_counted_against_the_standard_residue():
    names, index = np.array(["ALA"] * 7 + ["HID"] * 2 + ["XYZ", "GLY"]), np.array([0] * 7 + [1] * 2 + [2, 3])
    elements = np.array(
        ["N", "C", "C", "O", "C", "H", "O", "N", "D", "C", "H"]
    )  # with the second O of an end
    found, expected = count_heavy_atoms(names, index, elements)
    assert (found.tolist(), expected.tolist()) == ([5, 1, 0, 0], [5, 10, 0, 4])


def test_heavy_atoms_are_those_that_most_residues_of_real_structures_have(shared):
    counts = {}
    for name in ("1BD2.pdb.gz", "1a8o_mse.pdb", "3mht_dna.pdb"):
        molecule = read_molecule(shared / "data" / "structures" / name, selection="all")
        heavy = ~np.isin(molecule.element, ["H", "D"]) & (molecule.name != "OXT")
        for residue in np.unique(molecule.residue_index):
            own = molecule.residue_index == residue
            counts.setdefault(molecule.residue_name[own][0], []).append(int((own & heavy).sum()))
    usual = {name: max(set(found), key=found.count) for name, found in counts.items() if name in HEAVY_ATOMS}
    assert usual == {name: HEAVY_ATOMS[name] for name in usual} and HEAVY_ATOMS.keys() - usual == set("ACGU")
    deoxy = [HEAVY_ATOMS[f"D{base}"] for base in "ACG"]  # without O2'; and T is U with a carbon for it
    assert [HEAVY_ATOMS[base] for base in "ACGU"] == [n + 1 for n in deoxy] + [HEAVY_ATOMS["DT"]]


# ---- elements


@pytest.mark.parametrize(
    ("atom", "element"),  # element of the input, name, residue, whether of a polymer, whether alone
    [
        (("", "CA", "ALA", True, False), "C"), (("CA", "CA", "ALA", True, False), "C"), (("c", "CA", "ALA", True, False), "C"),
        (("HG", "HG", "SER", True, False), "H"), (("CD", "CD1", "LEU", True, False), "C"), (("", "1HB", "ALA", True, False), "H"),
        (("D", "D", "ALA", True, False), "D"), (("", "SE", "MSE", True, False), "SE"), (("", "SE", "MET", True, False), "S"),
        (("", "SD", "MSE", True, False), "S"), (("SE", "SE", "XYZ", True, False), "SE"), (("BR", "BR", "XYZ", True, False), "BR"),
        (("", "BR", "XYZ", True, False), "B"), (("X", "CB", "ALA", True, False), "C"), (("", "'1", "ALA", True, False), "X"),
        (("", "AE1", "GLN", True, False), "O"), (("", "AE2", "GLN", True, False), "N"), (("", "AD1", "ASN", True, False), "O"),
        (("", "AD2", "ASN", True, False), "N"), (("", "AD1", "HIE", True, False), "N"), (("", "AE2", "HIS", True, False), "N"),
        (("", "AD2", "HIS", True, False), "C"), (("", "AE1", "HIS", True, False), "C"), (("", "AE1", "LIG", True, False), "A"),
        (("", "CA", "LIG", False, False), "C"), (("CA", "CA", "LIG", False, False), "CA"),
        (("", "CL1", "LIG", False, False), "CL"),
        (("", "FE", "HEM", False, False), "FE"), (("", "HG", "LIG", False, False), "H"), (("", "HG", "HG", False, True), "HG"),
        (("", "CA", "CA", False, True), "CA"), (("C", "CAL", "CAL", False, True), "CA"), (("", "CA", "CA", False, False), "C"),
        (("", "CA", "CA", True, True), "C"), (("", "SOD", "SOD", False, True), "NA"), (("P", "POT", "POT", False, True), "K"),
        (("", "CLA", "CLA", False, True), "CL"), (("", "NA+", "NA+", False, True), "NA"), (("", "NA", "ION", False, True), "NA"),
        (("", "POT", "IONS", False, True), "K"), (("", "I", "IOD", False, True), "I"), (("", "C1", "XYZ", False, True), "C"),
        (("", "O", "HOH", False, True), "O"), (("", "MG", "C0", False, True), "MG"), (("", "C0", "C0", False, True), "CA"),
        (("LP", "N1", "LIG", False, False), "N"), (("P", "P", "SEP", True, False), "P"), (("", "SEX", "CYS", True, False), "S"),
        (("", "CLAA", "LIG", False, False), "CL"), (("", "CAA", "HEM", False, False), "C"), (("", "", "LIG", False, False), "X"),
    ],
)  # fmt: skip
def test_the_element_of_an_atom(atom, element):
    assert element_of(*atom) == element


def particles(*rows):
    """Which atoms (name, residue name, element, place) of one residue are none."""
    names, residue_names, elements, places = zip(*rows, strict=True)
    index = np.zeros(len(rows), int)
    return find_particles(
        *map(np.array, (names, residue_names)), index, np.array(elements), np.array(places, float)
    ).tolist()


def test_particles_that_are_no_atoms_are_known_by_element_name_and_place():
    at = (0, 0, 0)
    for name, residue, element, found in (
        ("QB", "ALA", "Q", True), ("QB", "ALA", "", True), ("QB", "LIG", "", False), ("CB", "ALA", "Q", False),
        ("PS1", "PSD", "PS", True), ("LP1", "LIG", "", True), ("LP1", "LIG", "LP", True), ("LP1", "LIG", "C", False),
        ("EPW", "XYZ", "", True), ("EP2", "SOL", "EP", True), ("VS1", "LIG", "VS", True), ("MW", "SOL", "", True),
        ("MW", "LIG", "", False), ("M", "HOH", "M", True), ("IW", "SOL", "", True), ("DUM1", "HOH", "", True),
        ("OM", "HOH", "O", True),
        ("OW", "HOH", "O", False), ("MCB1", "ALA", "", True), ("MNZ2", "LYS", "", True), ("MN", "MN", "", False),
        ("MTRP", "TRP", "X", True), ("LP1X2", "LIG", "", True), ("PB", "ATP", "", False), ("XA", "ALA", "X", False),
    ):  # fmt: skip
        assert particles((name, residue, element, at)) == [found], (name, residue, element)
    for distance, found in ((0.0, True), (0.55, True), (0.65, False)):
        pair = ("CB", "ALA", "C", at), ("DCB", "ALA", "", (distance, 0, 0))
        assert particles(*pair) == [False, found]
        assert particles(*pair[::-1]) == [found, False]
    assert particles(("DCG", "ALA", "", at), ("CB", "ALA", "C", at)) == [False, False]


# ---- alternate locations


def located(*rows):
    """Table of one residue's atoms from (name, altloc, occupancy)."""
    names, letters, occupancies = zip(*rows, strict=True)
    n = len(rows)
    table = atom_table(name=names, altloc=letters, occupancy=occupancies, residue_name=["SER"] * n)
    return table.assign(residue_index=np.zeros(n, int))


ROWS = (
    ("N", "", 1.0), ("CB", "A", 0.4), ("OG", "A", 0.45), ("CB", "B", 0.6), ("OG", "B", 0.3), ("HG", "B", 0.6),
)  # fmt: skip


@pytest.mark.parametrize(
    ("altloc", "rows", "expected"),
    [
        ("first", ROWS, ["N", "CB A", "OG A", "HG B"]),  # an atom that only B has is kept: no hole
        ("highest", ROWS, ["N", "CB B", "OG B", "HG B"]),  # means .425 and .5
        ("B", ROWS, ["N", "CB B", "OG B", "HG B"]),
        ("C", ROWS, ["N", "CB A", "OG A", "HG B"]),
        ("highest", (("CB", "A", 0.5), ("CB", "B", 0.5)), ["CB A"]),
        (
            "highest",
            (("CB", "A", 0.3), ("OG", "A", 0.9), ("CB", "B", 0.7), ("OG", "B", 0.7)),
            ["CB B", "OG B"],
        ),
        ("highest", (("CB", "B", 0.3), ("CB", "A", 0.7)), ["CB A"]),
        ("first", (("CB", "B", 0.3), ("CB", "A", 0.7)), ["CB B"]),  # first in the file, not in the alphabet
        (
            "highest",
            (("CB", "A", 0.9), ("OG", "A", 0.9), ("HG", "A", 0.0), ("CB", "B", 0.7), ("OG", "B", 0.7)),
            ["HG A", "CB B", "OG B"],
        ),
        ("first", (("CB", "", 0.4), ("CB", "A", 0.6)), ["CB"]),  # both are locations
        ("highest", (("CB", "", 0.4), ("CB", "A", 0.6)), ["CB A"]),
        ("A", (("CB", "", 0.6), ("CB", "A", 0.4), ("OG", "", 1.0)), ["CB A", "OG"]),
    ],
)
def test_one_location_of_each_atom(altloc, rows, expected):
    kept = choose_altlocs(located(*rows), altloc)
    assert [each.strip() for each in kept.name + " " + kept.altloc] == expected


@pytest.mark.parametrize("column", ["model", "residue_index"])
def test_each_residue_of_each_model_has_a_location_of_its_own(column):
    rows = located(("CB", "A", 0.4), ("CB", "B", 0.6), ("CB", "A", 0.7), ("CB", "B", 0.3))
    kept = choose_altlocs(rows.assign(**{column: np.array([0, 0, 1, 1])}), "highest")
    assert kept.altloc.tolist() == ["B", "A"] and kept.occupancy.tolist() == [0.6, 0.7]


# ---- tables


def numbers_of(text):
    return gather_residues(read_pdb(text).atoms).residue_index.tolist()


def test_residues_are_numbered_in_each_model_and_end_where_their_name_changes():
    text = "".join(f"MODEL {k}\n{peptide(['ALA', 'GLY'])}ENDMDL\n" for k in (1, 2))
    assert numbers_of(text) == ([0] * 5 + [1] * 5) * 2
    for first, second, numbers in (
        ("A", "B", [0, 0]), ("", "", [0, 1]), ("", "B", [0, 1]), ("A", "", [0, 1]),
    ):  # fmt: skip
        text = atom_line("CA", "SER", altloc=first) + atom_line("CA", "THR", altloc=second, place=(0, 0, 1))
        assert numbers_of(text) == numbers, (first, second)
    assert numbers_of(2 * (atom_line() + "TER\n")) == [0, 1]


def test_sequences_and_linked_residues_are_read_and_a_complete_one_lacks_nothing():
    atoms = read_pdb(peptide(["ALA", "GLY"]) + "END\n").atoms
    assert missing_residues(atoms, {"A": ["ALA", "GLY"]}) == {}
    assert missing_residues(atoms, {"A": ["ALA", "GLY", "SER"]}) == {"A": (2, 3)}
    names = "GLY SER THR VAL LEU ILE PHE TYR TRP HIS LYS ARG ASP"
    text = f"SEQRES   1 A   14  {names}  1ABC  83\nSEQRES   2 A   14  GLU\nSEQRES   1 B    1  CYS\n"
    assert read_pdb(text + atom_line() + "END\n").sequences == {
        "A": [*names.split(), "GLU"],
        "B": ["CYS"],
    }
    link = "LINK         NZ ALYS A1003                 CG  ASP B   5A    1555   1555  1.33\n"
    assert read_pdb(link + atom_line()).crosslinked == {("A", "1003"), ("B", "5A")}


def test_hybrid_36_at_its_limits():
    for number, field in (
        (9999, "9999"), (10_000, "A000"), (10_035, "A00Z"), (1_223_055, "ZZZZ"), (1_223_056, "a000"),
    ):  # fmt: skip
        assert encode_label(str(number)) == f"{field} " and _decode_number(field) == str(number)
    for label, field in (("-999", "-999 "), ("2436111", "zzzz "), ("-999A", "-999A"), ("", "     ")):
        assert encode_label(label) == field
    for label in ("-1000", "2436112", "-1000A"):
        with pytest.raises(InputError, match=f"residue {label.rstrip('A')} does not fit .* -999 to 2436111"):
            encode_label(label)


def test_lines_of_a_pdb_file_are_read_in_their_columns(tmp_path):
    atoms = read_pdb(atom_line("CA")[:54] + "\n" + atom_line("CB", occupancy=0.5)).atoms
    assert atoms.occupancy.tolist() == [1.0, 0.5] and np.isnan(atoms.b_factor).tolist() == [True, False]
    full = atom_line("C1", "LIG")[:54] + "100.00-99.991234      FE2+\n"
    atoms = read_pdb(full + atom_line("C2", "LIG", element="Q")).atoms
    assert atoms.z.tolist() == [0, 0] and atoms.element.tolist() == ["FE", "Q"]
    assert element_of("Q", "C2", "LIG", False, False) == "C"
    assert (atoms.occupancy[0], atoms.b_factor[0]) == (100, -99.99)
    wide = "".join(atom_line(name, "ALA", "AB", "1", place) for name, place in ALANINE.items())
    long = "".join(atom_line(name, "HISE", "B", "2", place) for name, place in ALANINE.items())
    assert set(read_pdb(wide).atoms.chain) == {"AB"}
    atoms = read_pdb(long).atoms
    assert set(atoms.chain) == {"B"} and set(atoms.residue_name) == {"HISE"}
    numbered = "".join(f"{line[:72]}1ABC{k:4d}\n" for k, line in enumerate(peptide(["ALA"]).splitlines(), 1))
    assert set(read_pdb(numbered).atoms.segid) == {""}
    assert set(read_pdb(numbered.replace("1ABC   5", "1ABC   C")).atoms.segid) == {"1ABC"}
    lipid = read_pdb(atom_line("C1", "POPC", "B") + atom_line("CA", "ALA", "B", "2")).atoms
    assert lipid.residue_name.tolist() == ["POPC", "ALA"] and lipid.chain.tolist() == ["B", "B"]


CIF = """data_x
loop_
_atom_site.group_PDB
_atom_site.auth_atom_id
_atom_site.auth_comp_id
_atom_site.auth_asym_id
_atom_site.label_asym_id
_atom_site.auth_seq_id
_atom_site.Cartn_x
_atom_site.Cartn_y
_atom_site.Cartn_z
_atom_site.occupancy
ATOM CA ALA H A 1 1 2 3 0.5
? CA ALA H A 2 1 2 9 ?
HETATM CA ALA L B 3 1 2 6 1.0
"""


def test_mmcif_takes_the_authors_chains_and_what_is_unknown_for_ordinary():
    atoms = read_mmcif(CIF).atoms
    assert atoms.chain.tolist() == ["H", "H", "L"] and atoms.segid.tolist() == ["A", "A", "B"]
    unlabelled = read_mmcif(CIF.replace("H A 1", "H A 7").replace("? CA ALA H A 2", "? CB ALA H . 7")).atoms
    assert unlabelled.segid.tolist() == ["A", "A", "B"]  # that of the other atom of the residue
    assert atoms.hetero.tolist() == [False, False, True]
    assert atoms.occupancy.tolist() == [0.5, 1.0, 1.0]
    assert np.isnan(atoms.b_factor).all() and set(atoms.element) == set(atoms.altloc) == {""}


@pytest.mark.parametrize("occupancy", [-0.1, 1.1])
def test_the_highest_occupancy_is_not_chosen_among_impossible_ones(occupancy):
    rows = located(("CB", "A", 0.3), ("CB", "B", occupancy))
    with pytest.raises(InputError, match="0 and 1:"):
        choose_altlocs(rows, "highest")
    assert choose_altlocs(rows, "B").occupancy.tolist() == [occupancy]
    assert len(choose_altlocs(located(("N", "", 7.0), *ROWS), "highest")) == 5


def test_mmcif_says_the_box_and_each_place_of_the_sequence_once():
    cell = {
        "length_a": 30, "length_b": 40, "length_c": 50, "angle_alpha": 70, "angle_beta": 80, "angle_gamma": 100,
    }  # fmt: skip
    text = CIF.replace("loop_", "".join(f"_cell.{key} {value}\n" for key, value in cell.items()) + "loop_", 1)
    items = "".join(
        f"_pdbx_poly_seq_scheme.{key}\n" for key in ("asym_id", "seq_id", "pdb_strand_id", "mon_id")
    )
    text += f"loop_\n{items}A 1 H ALA\nA 2 H GLY\nA 2 H SER\nB 1 H ALA\nC 1 L ALA\n"  # GLY or SER
    file = read_mmcif(text)
    a, b, c = file.box
    lengths = [np.linalg.norm(side) for side in (a, b, c)]
    cosines = [b @ c / 2000, a @ c / 1500, a @ b / 1200]
    assert lengths == pytest.approx([30, 40, 50]) and np.degrees(np.arccos(cosines)) == pytest.approx(
        [70, 80, 100]
    )
    assert file.sequences == {"H": ["ALA", "SER", "ALA"], "L": ["ALA"]}
    assert read_mmcif(text.replace("_cell.angle_gamma 100", "")).box is None
    assert read_mmcif(CIF).box is None and file.atoms.model.tolist() == [1, 1, 1]
    numbered = CIF.replace("_atom_site.occupancy", "_atom_site.pdbx_PDB_model_num")
    several = numbered.replace("2 3 0.5", "2 3 4").replace("2 9 ?", "2 9 4").replace("2 6 1.0", "2 6 7")
    assert read_mmcif(several).atoms.model.tolist() == [4, 4, 7]


def test_mmcif_says_which_residues_a_covalent_bond_beside_the_backbone_joins():
    """Bonds to metals and hydrogens, and those to what is no polymer, take no atom away from a residue."""
    ends = [f"ptnr{k}_auth_{item}_id" for k in (1, 2) for item in ("asym", "seq", "comp")]
    items = ["conn_type_id", *ends, "pdbx_ptnr2_PDB_ins_code"]
    bonds = [
        "covale H 1 LYS H 9 ASP A",
        "metalc H 2 HIS H 3 HIS ?",
        "hydrog H 4 SER H 5 SER ?",
        "covale H 6 ASN L 7 NAG ?",
    ]
    text = CIF + "loop_\n" + "".join(f"_struct_conn.{item}\n" for item in items) + "\n".join(bonds) + "\n"
    assert read_mmcif(text).crosslinked == {("H", "1"), ("H", "9A")}
    assert read_mmcif(CIF).crosslinked == set()
