"""The corpus: files and planted changes, one row each, and what becomes of them.

An outcome is what is measured (of a molecule: frames, atoms, residues and area in Å^2 at one dot per Å^2, as far as the row
gives them), then ~ and words of the warning if there is one. An outcome of ! and words is a refusal, in one sentence with the
name of the file. Words are regular expressions.
"""

import bz2
import gzip
import io
import logging
import lzma
import os
import random
import re
import shutil
import signal
import struct
import warnings
import zipfile
from dataclasses import replace
from pathlib import Path

import gemmi
import mdtraj
import numpy as np
import pandas as pd
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

import sparsurf
from conftest import ROOT, make_blob, sphere
from peptides import ALANINE, STEP, atom_line, peptide
from sparsurf.api.inputs import as_dots, as_molecule
from sparsurf.cli.command import main
from sparsurf.dot_fields.charges import pqr_charges
from sparsurf.dot_fields.columns import TableOfAtoms
from sparsurf.errors import InputError, naming_file
from sparsurf.molecules import plausibility
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.molecules.trajectory import check_dcd
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.surfaces.spacing import nearest_neighbours
from sparsurf.surfaces.surface import Surface

EXAMPLE = ROOT / "data" / "tdp43" / "topology.pdb"
SEEDS = ROOT / "tests" / "library" / "corpus"
SECONDS = 60  # an answer that takes longer is none; kernels may have to be compiled
MAX_WORDS = 40


def judge(expected, measure, caplog, name):
    """Compare what `measure` returns, or what is said, with an outcome; `name` stands in every sentence."""
    numbers, _, words = (part.strip() for part in expected.replace("!", "! ~", 1).partition("~"))
    caplog.clear()
    signal.signal(signal.SIGALRM, lambda *_: pytest.fail(f"no answer in {SECONDS} s"))
    signal.alarm(SECONDS)
    try:
        with caplog.at_level(logging.WARNING, "sparsurf"):
            found = [float(number) for number in measure()]
        said = "\n".join(caplog.messages)
    except InputError as error:
        found, said = None, str(error)
        assert "\n" not in said and said.endswith(".") and said.isprintable(), said
        assert len(re.sub(r"/\S+", "path", said).split()) <= MAX_WORDS, said
    finally:
        signal.alarm(0)
    assert (found is None) == (numbers == "!"), (found, said)
    assert re.search(words, said) if words or found is None else said == "", said
    assert not said or name in said or re.match(r"\w+: |no dms", said), said  # of a file, or of a key
    for number, value in zip(numbers.split(), found or (), strict=False):
        assert number == "!" or value == pytest.approx(float(number), abs=0.06), (found, said)


def area(molecule):
    """Area of a surface of one dot per Å^2."""
    return sparsurf.surface(molecule, density=1.0).area.sum()


def measured(molecule):
    """What an outcome holds of a molecule."""
    yield from (molecule.n_frames, molecule.n_atoms, molecule.n_residues)
    yield area(molecule)


# ---- inputs: residues 209 to 222 of the example as chain A, and a peptide of four alanines


def put(line, **columns):
    """Return a PDB line with other values in some columns; `by` moves the atom."""
    places = {
        "record": (0, 6, "<6"), "name": (12, 16, "<4"), "altloc": (16, 17, "<1"), "residue_name": (17, 20, ">3"),
        "chain": (21, 22, "<1"), "residue": (22, 26, ">4"), "code": (26, 27, "<1"), "occupancy": (54, 60, ">6"),
        "b_factor": (60, 66, ">6"), "segid": (72, 76, "<4"), "element": (76, 78, ">2"),
    }  # fmt: skip
    line = f"{line.rstrip():<80s}\n"
    for column, value in columns.items():
        if column == "by":
            xyz = np.add([float(line[k : k + 8]) for k in (30, 38, 46)], value)
            line = line[:30] + "".join(f"{x:8.3f}" for x in xyz) + line[54:]
        else:
            begin, end, form = places[column]
            line = f"{line[:begin]}{value:{form}s}{line[end:]}"
    return line


def every(lines, **columns):
    return [put(line, **columns) for line in lines]


def of(lines, *residues):
    return [line for line in lines if line[22:26].strip() in residues]


def without(lines, *residues):
    return [line for line in lines if line[22:26].strip() not in residues]


def end(*parts):
    """Return lines and strings as one PDB file."""
    return "".join("".join(part) for part in parts) + "END\n"


def models(*parts):
    return "".join(f"MODEL     {k:4d}\n{''.join(part)}ENDMDL\n" for k, part in enumerate(parts, 1)) + "END\n"


def cif(text):
    structure = gemmi.read_pdb_string(text)
    structure.setup_entities()
    structure.assign_label_seq_id()
    return structure.make_mmcif_document().as_string()


def atoms(residue_name, residue, places, **columns):
    """HETATM lines of a residue from names and places."""
    return [
        put(atom_line(name, residue_name[:3], "A", residue, place, record="HETATM"), **columns)
        for name, place in places.items()
    ]


ALL = [
    put(line, chain="A")
    for line in EXAMPLE.read_text().splitlines()
    if line.startswith("ATOM") and 209 <= int(line[22:26]) <= 222
]
HEAVY = [line for line in ALL if line[76:78].strip() != "H"]
HYDROGENS = [line for line in ALL if line[76:78].strip() == "H"]
PDB = end(HEAVY)
CIF = cif(PDB)
AWAY = (40.0, 0.0, 0.0)
COPY = every(HEAVY, by=AWAY)
WATER = {"O": (0, 0, 50), "H1": (0.76, 0.59, 50), "H2": (-0.76, 0.59, 50)}
ACE = {"CH3": (1.46, -1.21, 0), "C": (0, -1.33, 0), "O": (-0.9, -2.1, 0)}
GOOD = peptide() + "END\n"
SHORT = "\n".join(line[:54] for line in GOOD.split("\n"))
LACKING_IN_B = (
    "SEQRES   1 B    6  ALA ALA ALA ALA ALA ALA\n"
    + peptide()
    + "TER\n"
    + peptide(chain="B", origin=(0, 30, 0))
    + "END\n"
)
APART = peptide(chain="A") + peptide(chain="B", first=98, origin=(0, 0, 9))
SEQUENCE = "SEQRES   1 A    9  ALA ALA ALA ALA ALA ALA ALA ALA ALA\n"
NEGATIVE = peptide(["ALA"] * 7, first=-5) + "END\n"
INSERTED = peptide(["ALA"]) + "".join(
    peptide(["ALA"], origin=STEP * (1 + k)).replace("A   1 ", f"A   1{code}") for k, code in enumerate("ABC")
)
EITHER = peptide(["SER"], altloc="A", occupancy=0.4) + peptide(["THR"], altloc="B", occupancy=0.6)
ZIPPED = gzip.compress(GOOD.encode())
GRO_LINE = "    1ALA     CA    1   0.100   0.200   0.300\n"
ITEMS = [
    "group_PDB", "auth_atom_id", "auth_comp_id", "auth_asym_id", "auth_seq_id", "Cartn_x", "Cartn_y", "Cartn_z",
]  # fmt: skip
TINY = "data_x\nloop_\n" + "".join(f"_atom_site.{item}\n" for item in ITEMS)
TINY += "ATOM CA ALA A 1 1.0 2.0 3.0\nATOM CB ALA A 1 2.0 2.0 3.0\n"
LABELS = (
    "group_PDB id type_symbol label_atom_id label_comp_id label_asym_id label_seq_id Cartn_x Cartn_y Cartn_z"
)


def tiny(order=1, quote="", newline="\n", between=" "):
    """Return the peptide as mmCIF: columns in one order or the other, names in quotes or not."""
    rows = [line.split() for line in peptide().splitlines()]
    rows = [
        ["ATOM", str(k), row[-1], f"{quote}{row[2]}{quote}", row[3], "A", row[5], *row[6:9]]
        for k, row in enumerate(rows)
    ]
    lines = ["data_x", "loop_", *(f"_atom_site.{label}" for label in LABELS.split()[::order])]
    return newline.join([*lines, *(between.join(row[::order]) for row in rows), "#", ""])


def without_chain_names(text):
    return "".join(
        put(line, chain=" ") if line.startswith("ATOM") else line + "\n" for line in text.splitlines()
    )


def gro(lines, nm=0.1, shift=0.0):
    """Return lines of a PDB file as a GRO file."""
    rows = "".join(
        f"{line[22:26].strip():>5s}{line[17:20]:<5s}{line[12:16].strip():>5s}{k:5d}"
        + "".join(f"{(float(line[a : a + 8]) + shift) * nm:8.3f}" for a in (30, 38, 46)) + "\n"
        for k, line in enumerate(lines, 1)
    )  # fmt: skip
    return f"title\n{len(lines)}\n{rows}   0.00000   0.00000   0.00000\n"


# ---- structures


def ligand(name="LIG", residue="300", at=(30, 0, 0), **columns):
    return atoms(name, residue, {"C1": at, "O2": np.add(at, (1.4, 0, 0))}, **columns)


def long_names(text, *names):
    """Give ligands of mmCIF names of five letters."""
    for short, name in zip(("L06", "L07"), names, strict=True):
        text = text.replace(f" {short} ", f" {name} ")
    return text


def reordered(n, order):
    """Return a peptide whose residues have the places of others."""
    lines, rows = (
        peptide(["ALA"] * n).splitlines(keepends=True),
        np.arange(5 * n).reshape(n, 5)[order].ravel(),
    )
    return "".join(line[:30] + lines[row][30:] for line, row in zip(lines, rows, strict=True)) + "END\n"


def spread(n):
    """Return atoms that are bonded to none."""
    lines = peptide(["ALA"] * 2).splitlines(keepends=True)[:n]
    return "".join(
        f"{line[:30]}{3.0 * k:8.3f}{k % 3:8.3f}{k % 4:8.3f}{line[54:]}" for k, line in enumerate(lines)
    )


def by_element(lines):
    return sorted(lines, key=lambda line: line[76:78])


def plddt(lines, scale=1.0):
    """Give each residue one pLDDT, below 70 in residues 209 to 212."""
    return [put(line, b_factor=f"{(60 if int(line[22:26]) < 213 else 90) * scale:.2f}") for line in lines]


def with_items(text, column, change):
    """Change the values of one column of the _atom_site loop of gemmi's mmCIF."""
    block = gemmi.cif.read_string(text).sole_block()
    values = block.find_loop(f"_atom_site.{column}")
    assert len(values)
    for k in range(len(values)):
        values[k] = change(k, values[k])
    return block.as_string()


NUCLEOTIDE = {"P": (0, 0, 0), "C5'": (1.5, 0, 0), "C3'": (3, 0, 0), "O3'": (4.4, 0, 0)}


def dna(chain, residue="1", by=(0, 0, 9)):
    return atoms("DA", residue, NUCLEOTIDE, chain=chain, record="ATOM", by=by)


LONG = [put(line) for line in EXAMPLE.read_text().splitlines() if line.startswith("ATOM")]


def coded(*labels):
    """Return a peptide whose residues have some numbers with insertion codes, in this order."""
    lines = (
        atom_line(name, residue=label, place=np.add(place, k * STEP))
        for k, label in enumerate(labels) for name, place in ALANINE.items()
    )  # fmt: skip
    return "".join(lines) + "END\n"


def numbered(first, write, n=20, places=()):
    """Return a peptide whose numbers beyond 9999 are written by a function."""
    lines = (
        atom_line(name, residue=str(first + k), place=np.add(place, k * STEP)) if first + k < 10_000
        else put(atom_line(name, place=np.add(place, k * STEP)), residue=write(first + k))
        for k in (*range(n), *places) for name, place in ALANINE.items()
    )  # fmt: skip
    return "".join(lines) + "END\n"


def glycines(lines):
    return [put(line, residue_name="GLY") for line in lines if line[12:16].strip() in ("N", "CA", "C", "O")]


def renamed(lines, name):
    """Give residues a name of four letters, the last in column 21."""
    return [line[:17] + name + line[21:] for line in lines]


def pdbqt(lines):
    """Return lines with charge and type of AutoDock behind the B factor."""
    types = {"O": "OA", "N": "NA", "S": "SA"}
    return [
        f"{line[:66]}    {k % 7 / 10 - 0.3:6.3f} {types.get(line[77], line[77])}\n"
        for k, line in enumerate(lines)
    ]


def drude(line):
    return put(line, name=("D" + line[12:16].strip())[:4], element="", by=(0.05, -0.05, 0.05))


def lone_pairs(line):
    names = ("LPOA", "LPOB") if line[12:16].strip() == "O" else ()
    return [put(line, name=name, element="", by=(0.3 * k - 0.45, 0, 0)) for k, name in enumerate(names)]


BESIDE_DNA = end(peptide(), dna("B"))
FOUR_OF_DNA = end(
    peptide(), dna("C", "402"), dna("C", "403", (0, 9, 9)), dna("D", "403", (0, 18, 9)), dna("D", "421", (0, 27, 9))
)  # fmt: skip
LIGANDS_APART = end(
    peptide(), peptide(chain="B", origin=(0, 0, 20)),
    *(atoms("LIG", "8", {"C1": (0, 0, 5)}), atoms("LIG", "9", {"C1": (0, 0, 25)}, chain="B")),
    atoms("CMO", "12", {"C1": (0, 0, 9)}),
)  # fmt: skip
BESIDE_PROTEIN = end(
    peptide(), peptide(("GLY",), first=201, origin=(0, 0, 30), record="HETATM"),
    *(atoms("HOH", "300", {"O": (0, 9, 9)}), atoms("HOH", "301", {"O": (9, 9, 9)}), atoms("ZN", "302", {"ZN": (18, 9, 9)})),
    *(atoms("NAG", "303", {"C1": (27, 9, 9), "H1": (27, 9, 10)}), atoms("LIG", "304", {"C2": (36, 9, 9)})),
)  # fmt: skip
TWIN = every([line for line in of(HEAVY, "213") if line[12:16].split()[0] in ALANINE], residue_name="ALA")
BRIDGE = "LINK         CG  ALA A   3                 NZ  ALA A   5     1555   1555  1.33\n"
LACKING = "".join(
    line for k, line in enumerate(peptide(["ALA"] * 5).splitlines(keepends=True)) if k != 14
)  # CB of 3
UNNUMBERED = [
    put(line, residue="****") for k in range(5) for line in atoms("HOH", "1", {"O": (3 * k, 0, 50)})
]
WHOLE = "1 119 14 1281.3"
WITH_HYDROGENS = f"1 {len(ALL)} 14 1313.8"
TWICE = f"1 238 28 {2 * 1281.31:.1f}"
STRUCTURES = {  # name: content, keys of read_molecule, outcome
    "example.pdb": (PDB, {}, WHOLE),
    "example.cif": (CIF, {}, WHOLE),
    "example.gro": (gro(HEAVY), {}, "1 119 14"),
    # the order of lines
    "hydrogens behind the chain.pdb": (end(HEAVY, HYDROGENS), {"hydrogens": "remove"}, WHOLE),
    "hydrogens.pdb": (end(ALL), {}, WITH_HYDROGENS),
    "no elements, names at the left.pdb": (
        end(line[:12] + line[12:16].strip().ljust(4) + line[16:66] + "\n" for line in ALL), {}, WITH_HYDROGENS),
    "atoms in the order of elements.pdb": (end(by_element(HEAVY)), {}, WHOLE),
    "residues backwards.pdb": (end(*(of(HEAVY, str(k)) for k in range(222, 208, -1))), {}, WHOLE),
    "a modified residue behind the chain.pdb": (
        end(without(HEAVY, "213"), every(of(HEAVY, "213"), record="HETATM", residue_name="DGN")), {}, WHOLE),
    "a modified residue behind the chain.cif": (
        cif(end(without(HEAVY, "213"), every(of(HEAVY, "213"), record="HETATM", residue_name="DGN"))), {}, WHOLE),
    "an unknown cap bonded to the first residue.pdb": (
        end(atoms("XYZ", "208", {"C1": (0, -1.33, 0), "O1": (-0.9, -2.1, 0)}), peptide(first=209)), {}, "1 22 5"),
    "a cap behind the chain.pdb": (end(peptide(), atoms("ACE", "0", ACE)), {}, "1 23 5"),
    "a cap of the number of the first residue.pdb": (end(atoms("ACE", "1", ACE), peptide()), {}, "1 23 5"),
    "a lipid on the first residue.pdb": (
        end(peptide(), atoms("MYR", "99", {f"C{k}": (0, -1.33 - 1.5 * k, 0) for k in range(5)})), {}, "1 25 5"),
    "a ligand beside the end of the chain.pdb": (
        end(peptide(), atoms("XYZ", "9", {"C1": (0, -3.4, 0), "O1": (-0.9, -4.5, 0)})), {}, "1 20 4 ~ left out 1 XYZ"),
    # chains and molecules
    "two copies of one chain letter, by TER.pdb": (end(HEAVY, "TER\n", COPY), {}, f"{TWICE} ~ called A, B"),
    "two copies of one chain letter, by segments.pdb": (
        end(every(HEAVY, segid="PROA"), every(COPY, segid="PROB")), {"chains": "PROB"}, f"{WHOLE} ~ called PROA, PROB"),
    "a range in both copies.pdb": (
        end(every(HEAVY, segid="PROA"), every(COPY, segid="PROB")), {"residues": "209-212"}, "! in PROA, PROB: name one"),
    "a range in one copy.pdb": (
        end(every(HEAVY, segid="PROA"), every(COPY, segid="PROB")), {"residues": "PROB:209-212"}, "1 37 4 ~ called PROA"),
    "a range in one of two chains.pdb": (
        end(every(HEAVY, segid="PROA"), every(COPY, segid="PROB")), {"residues": "209-212", "chains": "PROB"},
        "1 37 4 ~ called PROA"),
    "a copy in two pieces.pdb": (
        end(peptide(), "TER\n", peptide(["ALA"] * 2, origin=(0, 30, 0)), "TER\n",
            peptide(["ALA"] * 2, first=3, origin=(0, 60, 0))), {}, "1 40 8 ~ called A, B(\n|$)"),
    "chains of two letters.pdb": (end(line[:20] + "AB" + line[22:] for line in HEAVY), {"chains": "AB"}, WHOLE),
    "a chain without its name in some rows.cif": (
        with_items(CIF, "auth_asym_id", lambda k, value: "?" if k % 3 else value), {"chains": "A"}, WHOLE),
    "no label of the chain in some rows.cif": (
        with_items(CIF, "label_asym_id", lambda k, value: "." if k % 2 else value), {}, WHOLE),
    "no numbers of the authors in some rows.cif": (
        with_items(with_items(CIF, "label_seq_id", lambda k, _: HEAVY[k][23:26]), "auth_seq_id",
                   lambda k, value: value if k % 4 else "."),
        {"residues": "A:209-222"}, WHOLE),
    "no number of any water.cif": (
        with_items(cif(end(HEAVY, *(atoms("HOH", str(k), {"O": (0, 3.0 * k - 900, 50)}) for k in range(300, 309)))),
                   "auth_seq_id", lambda k, value: value if k < 121 else "?"), {"selection": "all"}, "1 128 23"),
    "a chain taken out.cif": (
        CIF.replace("\nAxp A\n", "\nAxp A\nBxp A\n"), {}, f"{WHOLE} ~ no atoms for Bxp"),
    "no chain.pdb": (without_chain_names(PDB), {"chains": "A"}, "! one chain, which has no name: leave out"),
    "DNA without a chain.pdb": (
        end(dna("")), {}, "! name the chains of the nucleic acids, as `chains` ''"),
    "DNA by a chain without a name.pdb": (end(dna("")), {"chains": ""}, "1 4 1 ~ lacks heavy atoms"),
    "DNA beside a protein.pdb": (BESIDE_DNA, {}, "1 20 4 ~ left out 1 DA$"),
    "DNA by its chain.pdb": (BESIDE_DNA, {"chains": ["B"]}, "1 4 1 ~ lacks heavy atoms"),
    "residues of the protein beside DNA.pdb": (BESIDE_DNA, {"residues": "1-4"}, "1 20 4 ~ left out 1 DA$"),
    "residues of both.pdb": (BESIDE_DNA, {"residues": iter(["A:1", "B:1"])}, "1 9 2 ~ lacks heavy atoms"),
    "residues of both, one without its chain.pdb": (BESIDE_DNA, {"residues": "1,B:1"}, "1 9 2 ~ lacks heavy atoms"),
    "residues of DNA alone.pdb": (FOUR_OF_DNA, {"residues": "402-410"}, "! name the chain of nucleic acids, as in C:402-403"),
    "a residue of DNA alone.pdb": (FOUR_OF_DNA, {"residues": ["421"]}, "! 4 nucleic residues: .* as in D:421-421"),
    "two ranges of DNA alone.pdb": (FOUR_OF_DNA, {"residues": "421,402-403"}, "! as in C:402-403"),
    "residues of DNA by their chain.pdb": (FOUR_OF_DNA, {"residues": "C:402-403"}, "1 8 2 ~ lack heavy atoms"),
    "an expression that no residue of DNA fits.pdb": (
        FOUR_OF_DNA, {"residues": "402", "selection": "name XX"}, r"! 4 nucleic residues\.$"),
    "residues that lack in the middle.pdb": (
        end(without(HEAVY, "214", "215")), {}, "1 103 12 ~ 2 residues are missing .* GLN 213"),
    "residues that lack beside a chain with its sequence.pdb": (
        "SEQRES   1 B    4  ALA ALA ALA ALA\n" + end(without(HEAVY, "211", "214", "215"), peptide(chain="B", origin=(0, 0, 60))),
        {}, "1 112 15 ~ 3 residues are missing within its chains, the first between ... 210 A and ... 212 A"),
    "a number that jumps without a gap.pdb": (peptide(["ALA"] * 2) + "".join(
        peptide(["ALA"] * 2, first=9, origin=2 * STEP)) + "END\n", {}, "1 20 4"),
    # alternate locations
    "A and B of a residue.pdb": (
        end(every(of(HEAVY, "209"), altloc="A"), every(of(HEAVY, "209"), altloc="B", by=(0.5, 0, 0)), without(HEAVY, "209")),
        {}, WHOLE),
    "blank and A of a residue.pdb": (
        end(without(HEAVY, "209"), of(HEAVY, "209"), every(of(HEAVY, "209"), altloc="A", by=(0.5, 0, 0))), {}, WHOLE),
    "all A behind all B.pdb": (
        end(every(HEAVY, altloc="B", by=(0.3, 0, 0)), every(HEAVY, altloc="A")), {"altloc": "A"}, WHOLE),
    "B of the highest occupancy.pdb": (EITHER, {"altloc": "highest"}, "1 5 1 ~ THR 1 A"),
    "a second molecule in location A.pdb": (
        end(peptide(["SER"], altloc="A"), peptide(["SER"], altloc="B"), peptide(["ALA"] * 3, first=2, origin=STEP), "TER\n",
            peptide(["GLY"] * 4, origin=(0, 30, 0), altloc="A")), {}, "1 40 8 ~ called A, B"),
    "a copy in location A.pdb": (end(HEAVY, "TER\n", every(COPY, altloc="A")), {}, f"{TWICE} ~ called A, B"),
    "a letter that no residue has.pdb": (PDB, {"altloc": "Q"}, f"{WHOLE} ~ altloc Q changes nothing"),
    # waters, ions, ligands
    "water TP3.pdb": (end(HEAVY, atoms("TP3", "300", WATER), atoms("TP3", "301", WATER, by=(9, 0, 0))), {"ligands": True}, WHOLE),
    "water SWM4 with a Drude particle.pdb": (
        end(HEAVY, (line[:17] + "SWM4" + line[21:] for line in atoms("SWM", "300", WATER | {"DOH2": (0, 0, 50)}))),
        {"ligands": True}, WHOLE),
    "water of an unknown name.pdb": (end(HEAVY, atoms("XYZ", "300", WATER)), {"ligands": True}, WHOLE),
    "ion SOD.pdb": (
        end(HEAVY, atoms("SOD", "300", {"SOD": (0, 0, 50)}, element="")), {"ligands": ["SOD"]}, "1 120 15 ~ radius for NA"),
    "ion POT of element P.pdb": (
        end(HEAVY, atoms("POT", "300", {"POT": (0, 0, 50)}, element="P")), {"ligands": ["POT"]}, "1 120 15 ~ radius for K"),
    "a ligand that is not there.pdb": (end(HEAVY, ligand()), {"ligands": ["XXX"]}, "! XXX"),
    "components of five letters.cif": (
        long_names(cif(end(HEAVY, ligand("L06"), ligand("L07", "301", (60, 0, 0)))), "A1LU6", "A1LU7"),
        {"ligands": ["A1LU7"]}, "1 121 15 ~ left out 1 A1LU6"),
    "besides a protein.pdb": (BESIDE_PROTEIN, {}, "1 20 4 ~ left out 1 GLY, 1 NAG$"),
    "a ligand besides a protein.pdb": (BESIDE_PROTEIN, {"ligands": "NAG"}, "1 22 5 ~ left out 1 GLY$"),
    "a ligand without its hydrogens.pdb": (BESIDE_PROTEIN, {"ligands": "NAG", "hydrogens": "remove"}, "1 21 5 ~ left out 1 GLY$"),
    "a ligand and an ion.pdb": (BESIDE_PROTEIN, {"ligands": ["NAG", "ZN"]}, "1 23 6 ~ left out 1 GLY$"),
    "every ligand but single atoms.pdb": (BESIDE_PROTEIN, {"ligands": True}, "1 27 6"),
    "a ligand that is none of these.pdb": (BESIDE_PROTEIN, {"ligands": ["HEM"]}, r"! contains GLY, HOH, LIG, NAG, ZN\.$"),
    "a ligand outside of the residues.pdb": (
        LIGANDS_APART, {"ligands": ["LIG", "CMO"], "residues": "A:1-9"},
        r"! ligands: CMO of .* lies outside of the requested chains and residues: add A:12 to the residues\.$"),
    "a ligand outside of the chains.pdb": (
        LIGANDS_APART, {"ligands": ["LIG", "CMO"], "chains": ["B"]}, r"! CMO of .* add A to the chains\.$"),
    "a ligand outside of both.pdb": (
        LIGANDS_APART, {"ligands": ["LIG", "CMO"], "chains": "B", "residues": "1-9"},
        r"! add A to the chains and A:12 to the residues\.$"),
    "a ligand of the residues.pdb": (LIGANDS_APART, {"ligands": ["LIG"], "residues": "A:1-9"}, "1 21 5 ~ no residue 9 of"),
    "every ligand of a chain.pdb": (LIGANDS_APART, {"ligands": True, "selection": "all", "chains": ["B"]}, "1 21 5"),
    "a ligand among the residues.pdb": (LIGANDS_APART, {"ligands": ["CMO"], "residues": "A:1-3,12"}, "1 16 4"),
    "heavy-water.pdb": (GOOD[:-4] + atom_line("D1", "DOD", residue="9", record="HETATM", element="D"), {}, "1 20 4"),
    "deuterium.pdb": (
        GOOD[:-4] + atom_line("D", residue="4", place=(1, 1, 1), element="D"), {"hydrogens": "remove"}, "1 20 4"),
    # pLDDT
    "ColabFold.pdb": (end(plddt(HEAVY)), {"plddt": 70}, "1 82 10 ~ left out 4 of 14 residues"),
    "ESMFold, 0 to 1.pdb": (end(plddt(HEAVY, 0.01)), {"plddt": 70}, "1 82 10 ~ scale of 0 to 1"),
    "Boltz.pdb": ("TITLE     BOLTZ-1 PREDICTION\n" + end(plddt(HEAVY)), {"plddt": 70}, "1 82 10 ~ left out 4"),
    "ModelCIF, 0 to 1.cif": (
        cif(end(plddt(HEAVY, 0.01))) + "_ma_qa_metric.id 1\n_ma_qa_metric.type pLDDT\n_ma_qa_metric.name pLDDT\n",
        {"plddt": 70}, "1 82 10 ~ scale of 0 to 1"),
    "a crystal of the same B factors.pdb": ("EXPDTA    X-RAY DIFFRACTION\n" + end(plddt(HEAVY)), {"plddt": 70}, WHOLE),
    "SWISS-MODEL, 0 to 1.pdb": (
        "EXPDTA    THEORETICAL MODEL (SWISS-MODEL SERVER)\nREMARK   3 GMQE 0.75\n" + end(plddt(HEAVY, 0.01)), {"plddt": 70},
        "! without pLDDT"),
    "no B factors.gro": (gro(HEAVY), {"plddt": 70}, "1 119 14 ~ plddt is not applied"),
    "B factors that are no pLDDT.pdb": (PDB, {"plddt": 70}, f"{WHOLE} ~ plddt is not applied"),
    # models
    "models that are copies elsewhere.pdb": (models(HEAVY, COPY), {}, "2 119 14 ~ copies of the first at other places"),
    "models that are copies 0.9 Å away.pdb": (models(peptide(), peptide(origin=(0, 0, 0.9))), {}, "2 20 4"),
    "copies 1.2 Å away, and another shape.pdb": (
        models(peptide(), peptide(origin=(0, 0, 1.2)), peptide().replace("  -0.800   1.200", "  -0.300   1.600", 1)), {},
        "3 20 4 ~ 2 of its 3 models are copies of the first at other places"),
    "models of five atoms that are copies elsewhere.pdb": (
        models(peptide(["ALA"]), peptide(["ALA"], origin=(0, 0, 9))), {}, "2 5 1"),
    "seven chains that lack a residue.pdb": (
        "".join(f"SEQRES   1 {c}    3  ALA ALA ALA\n" for c in "ABCDEFG")
        + "TER\n".join(peptide(["ALA"] * 2, c, origin=(0, 0, 9 * k)) for k, c in enumerate("ABCDEFG")) + "END\n", {},
        "1 70 14 ~ no coordinates for 7 residues of the sequence: 1 in chain A, .*1 in chain E and 2 more chains"),
    "an assembly of other chain letters.pdb": (models(HEAVY, every(COPY, chain="B")), {}, "! one molecule by `assembly`"),
    "an assembly.pdb": (models(HEAVY, COPY), {"assembly": True}, TWICE),
    "an assembly with a conformation.pdb": (
        models(HEAVY, COPY, every(HEAVY, by=(0.3, 0, 0))), {"assembly": True}, "! lie within one another"),
    "another residue in the second model.pdb": (
        models(peptide(), peptide(["ALA", "SER", "ALA", "ALA"])), {}, "! models of different atoms .* 20 20"),
    "a model of frames.gro": (gro(HEAVY), {"model": 1}, "! has frames and no models: leave out the model"),
    "an assembly of frames.gro": (gro(HEAVY), {"assembly": True}, "! it takes all models of a structure"),
    "the third model repeats.pdb": (
        models(peptide(), peptide(origin=(0, 0, 0.5)), peptide(origin=(0, 0, 0.5))), {},
        "3 20 4 ~ 1 frame repeats the one before, the first is frame 2"),
    "models and a stride.pdb": (
        models(*(peptide(origin=(0, 0, 0.1 * k)) for k in range(5))), {"stride": 4}, "2 20 4"),
    "models and a stride beyond them.pdb": (
        models(*(peptide(origin=(0, 0, 0.1 * k)) for k in range(5))), {"stride": 5},
        "1 20 4 ~ has 5 frames, of which a stride of 5 leaves only"),
    "a model that is not there.pdb": (
        models(peptide(), peptide(origin=(0, 0, 0.5))).replace("   1\n", "   3\n").replace("   2\n", "   7\n"), {"model": 1},
        "! no model 1: its models are 3, 7"),
    "a model beyond twelve.pdb": (
        models(*12 * [peptide()]), {"model": 13}, r"! its models are 1, 2, 3, 4, 5, 6, 7, 8, 9, \.\.\.\.$"),
    "the only model, without a number.pdb": (peptide(), {"model": 1}, "1 20 4"),
    "models that repeat.pdb": (models(HEAVY, HEAVY), {}, "2 119 14 ~ 1 frame repeats the one before"),
    "a model that is no number.pdb": (models(HEAVY, COPY), {"model": True}, "! True is not a whole number"),
    "models.pdb": (models(peptide(), peptide(["ALA"] * 3)), {}, "! models of different atoms .* 20 15.*model"),
    "fewer models than announced.pdb": (
        "NUMMDL    3\n" + models(peptide(), peptide(origin=(0, 0, 0.5))).replace("MODEL        2", "MODEL        5"), {},
        "2 20 4 ~ announces 3 models and holds 2"),
    "open-model.pdb": ("MODEL        1\n" + peptide(), {}, "1 20 4 ~ its last MODEL has no ENDMDL"),
    "open-second-model.pdb": (
        f"MODEL        1\n{peptide()}ENDMDL\nMODEL        2\n{peptide(['ALA'])}", {}, "! its last MODEL has no ENDMDL"),
    # incomplete and damaged
    "empty.pdb": ("", {}, "! holds no atoms"),
    "Damaged.PDB": (GOOD.replace("   1.460", "   1x460", 1), {}, "! Line 2 of .* no readable coordinates"),
    "comma.pdb": (GOOD.replace(".", ","), {}, "! Line 1 of .* no readable coordinates"),
    "short-line.pdb": (GOOD[:40] + "\n" + GOOD, {}, "! Line 1 of .* is cut short"),
    "shifted.pdb": (GOOD.replace("A   1  ", "A   1 1", 1), {}, "! Line 1 of .* not in the columns"),
    "keyword.pdb": (GOOD.replace("ATOM  ", "ATQM  ", 1), {}, "! Line 1 of .* holds an atom but begins with 'ATQM"),
    "tab.pdb": (GOOD.replace("ATOM  ", "ATOM\t", 1), {}, "! Line 1 of .* holds an atom but begins with 'ATOM"),
    "number.pdb": (GOOD.replace("A   1 ", "A  1x ", 1), {}, "! Line 1 of .* not in the columns"),
    "cut.pdb": (GOOD[:-24], {}, "! cut short: it stops in the middle"),
    "zeros.pdb": (GOOD + "\0", {}, "! damaged or not a text file"),
    "escape.pdb": (GOOD[:-4] + atom_line("C1", "\x1b[3", residue="9", place=(0, 40, 0), record="HETATM"), {}, r"! '\\x1b\[3'"),
    "no-end.pdb": (SEQUENCE + peptide(), {}, "! 4 of the 9 residues .* SEQRES .* no END"),
    "no-end of two chains.pdb": (
        SEQUENCE + SEQUENCE.replace("A    9", "B    6").replace(" ALA\n", "\n", 1) + peptide()
        + peptide(["ALA"] * 2, "B", origin=(0, 30, 0)), {}, "! 6 of the 17 residues"),
    "hydrogens-only.pdb": (
        "".join(atom_line("HA", residue=str(i), place=(3.8 * i, 0, 0), element="H") for i in range(1, 6)), {},
        "! only hydrogens"),
    "ca-only.pdb": ("".join(line + "\n" for line in GOOD.split("\n") if " CA " in line), {}, "! 20 % of the heavy atoms"),
    "backbone.pdb": (
        "".join(line + "\n" for line in peptide(["LEU"] * 4).split("\n") if line and " CB " not in line), {},
        "! 50 % of the heavy atoms"),
    "two C-alpha.pdb": (atom_line() + atom_line(residue="2", place=(3.8, 0, 0)), {}, 
                         "1 2 2 ~ 2 residues lack heavy atoms, the first is ALA 1 A"),
    "ions.pdb": (
        "".join(atom_line("NA  ", "NA", residue=str(i), place=(i, 0, 0), element="NA") for i in range(3)), {},
        "! there is no protein; the file has chain A with 3 NA"),
    "one-place.pdb": (
        re.sub(r"(?m)^(.{30}).{24}", r"\1   0.000   0.000   0.000", peptide()), {}, "! all atoms at one position"),
    "an atom twice.pdb": (end(HEAVY[:5], HEAVY[4], HEAVY[5:]), {}, "1 120 14 1281.3 ~ 1 atom is repeated in its residue"),
    "two atoms twice.pdb": (
        end(HEAVY[:5], HEAVY[4], HEAVY[5], HEAVY[5:]), {}, "1 121 14 ~ 2 atoms are repeated in their residues"),
    "a residue twice under two names.pdb": (
        end(HEAVY[:46], TWIN, HEAVY[46:]), {}, "1 124 15 ~ GLN 213 A and O of ALA 213 A lie 0.0 Å apart"),
    "an occupancy above 1.pdb": (
        end(HEAVY[:7], put(HEAVY[7], occupancy="37.00"), HEAVY[8:]), {},
        f"{WHOLE} ~ 1 atom has an occupancy outside 0 to 1, such as 37;"),
    "an atom lacks.pdb": (end(HEAVY[:8], HEAVY[9:]), {}, "1 118 14 ~ 1 residue lacks heavy atoms, the first is GLU 209 A"),
    "an atom whose neighbours lack.pdb": (
        end(line for line in HEAVY if line[22:26] != " 214" or line[12:16].strip() not in ("CZ", "CE1", "CE2")), {},
        r"1 116 14 ~ ^[^\n]* 1 residue lacks heavy atoms, [^\n]*$"),
    "an atom that a bridge replaces.pdb": (BRIDGE + LACKING, {}, "1 24 5"),
    "an atom that a metal does not replace.pdb": (
        BRIDGE.replace(" NZ  ALA A   5", "ZN    ZN A   9") + LACKING, {}, "1 24 5 ~ lacks heavy atoms, the first is ALA 3 A"),
    "two atoms and one bridge.pdb": (
        BRIDGE + "".join(LACKING.splitlines(keepends=True)[:13] + LACKING.splitlines(keepends=True)[14:]), {},
        "1 23 5 ~ lacks heavy atoms"),
    "wrong elements.pdb": (
        end(put(line, element="S") if k in (1, 20, 33) else line for k, line in enumerate(HEAVY)), {},
        "1 119 14 ~ has the element S; 3 atoms have"),
    "residues that are not there.pdb": (PDB, {"residues": "1-222"}, f"{WHOLE} ~ has no residue 1 of '1-222'"),
    # mmCIF
    "is-cif.pdb": (TINY, {}, "1 2 1 57.2 ~ 1 residue lacks heavy atoms"),
    "is-pdb.cif": (GOOD, {}, "1 20 4 279.2"),
    "no-loop.cif": ("data_x\n_cell.length_a 10\n", {}, "! holds no atoms"),
    "nan.cif": (TINY.replace("3.0", "nan", 1), {}, "! not numbers"),
    "cut.cif": (TINY[:-8], {}, "! not a readable mmCIF file .*Wrong number of values"),
    "no-x.cif": (TINY.replace("Cartn_y", "Cartn_q"), {}, "! has no y in its _atom_site"),
    "number.cif": (TINY.replace(" A 1 ", " A one ", 1), {}, "! residue numbered 'one'"),
    "lost-chain.cif": (
        "data_x\nloop_\n_struct_asym.id\nA\nB\n" + TINY[7:-1].replace("auth_asym_id", "label_asym_id"), {},
        "! cut short: it has no atoms for B"),
    "lost chain and waters.cif": (
        "data_x\nloop_\n_entity.id\n_entity.type\n1 polymer\n2 water\nloop_\n_struct_asym.id\n_struct_asym.entity_id\n"
        "A 1\nB 1\nC 2\n" + TINY[7:].replace("auth_asym_id", "label_asym_id"), {},
        "1 2 1 ~ has no atoms for B, C of its _struct_asym list"),
    "lost waters.cif": (
        "data_x\nloop_\n_entity.id\n_entity.type\n1 polymer\n2 water\nloop_\n_struct_asym.id\n_struct_asym.entity_id\n"
        "A 1\nC 2\n" + TINY[7:].replace("auth_asym_id", "label_asym_id"), {}, "1 2 1 ~ lacks heavy atoms"),
    "plain.cif": (TINY, {}, "1 2 1 ~ lacks heavy atoms"),
    "two blocks.cif": (TINY + TINY.replace("data_x", "data_y"), {}, "1 2 1 ~ 2 data blocks with atoms: the first is read"),
    "reversed.cif": (tiny(-1), {}, "1 20 4"),
    "quoted.cif": (tiny(quote='"'), {}, "1 20 4"),
    "tabs.cif": (tiny(between="\t"), {}, "1 20 4"),
    # GRO and others
    "broken.gro": ("title\n 2\n    1ALA     CA    1   0.1\n", {}, "! cut short within its first frame"),
    "a line of one number.gro": (
        f"title\n 2\n{GRO_LINE}    1ALA     CB    2   0.1\n1 1 1\n", {}, "! line 4 has no three coordinates"),
    "count.gro": ("title\nx\n", {}, "! line 2 is not the number of atoms"),
    "few.gro": (f"title\n 2\n{GRO_LINE}", {}, "! cut short within its first frame"),
    "no-box.gro": (f"title\n 1\n{GRO_LINE}1.0 1.0\n", {}, "! line 4 is not a box of 3 or 9 numbers"),
    "a box whose numbers touch.gro": (f"title\n 1\n{GRO_LINE}{3 * '40000.00000'}\n", {}, "1 1 1 ~ a single atom"),
    "a tilted box whose numbers touch.gro": (f"title\n 1\n{GRO_LINE}{9 * '40000.00000'}\n", {}, "1 1 1 ~ a single atom"),
    "a box of words.gro": (f"title\n 1\n{GRO_LINE}no box. at. all.\n", {}, "! line 4 is not a box of 3 or 9 numbers"),
    "a wide box.gro": (gro(HEAVY).replace("   0.00000" * 3, " 40000.00000" * 3), {}, "1 119 14"),
    "in Å.gro": (gro(HEAVY, nm=1.0), {}, "! give lengths in nm"),
    "numbers that touch.gro": (gro(GOOD.splitlines()[:20], shift=-2000), {}, "1 20 4"),
    "empty.psf": ("", {}, "! no section !NATOM"),
    "is-pdb.txt": (GOOD, {}, "1 20 4 279.2"),
    "notes.txt": ("Of the protein\n", {}, "! not a structure by its content: give a file of one of the formats PDB, mmCIF"),
    # encodings, compression, ends of lines, columns
    "is-not.pdb.gz": (GOOD, {}, "! is named .gz but is not compressed so"),
    "more behind it.pdb.gz": (ZIPPED + b"text", {}, "! damaged inside its compression"),
    "cut.pdb.gz": (ZIPPED[:-9], {}, "! cut short or damaged inside its compression"),
    "twice.pdb.gz": (gzip.compress(ZIPPED), {}, "! is compressed twice"),
    "members.pdb.gz": (gzip.compress(GOOD[:162].encode()) + gzip.compress(GOOD[162:].encode()), {}, "1 20 4"),
    "once.pdb.gz.gz": (ZIPPED, {}, "1 20 4 279.2"),
    "a.pdb.bz2": (bz2.compress(GOOD.encode()), {}, "1 20 4 279.2"),
    "a.pdb.xz": (lzma.compress(GOOD.encode()), {}, "1 20 4 279.2"),
    "no suffix but.xz": (lzma.compress(GOOD.encode()), {}, "1 20 4 279.2"),
    "cut.pdb.bz2": (bz2.compress(GOOD.encode())[:-9], {}, "! cut short or damaged inside its compression"),
    "cut.pdb.xz": (lzma.compress(GOOD.encode())[:-40], {}, "! cut short or damaged inside its compression"),
    "damaged.pdb.bz2": (
        bz2.compress(GOOD.encode()).replace(b"1AY&SY", b"1AY&SX"), {}, "! is damaged inside its compression"),
    "gz.pdb.bz2": (ZIPPED, {}, "! is named .bz2 but is not compressed so"),
    "twice.pdb.xz": (lzma.compress(ZIPPED), {}, "! is compressed twice: .* name it .gz"),
    "xz.pdb": (lzma.compress(GOOD.encode()), {}, "! is compressed: add .xz to its name"),
    "BZh in its title.gro": ("BZh" + gro(GOOD.splitlines()[:20])[3:], {}, "1 20 4"),
    "a.pdb.zst": (b"\x28\xb5\x2f\xfd" + bytes(9), {}, "! is compressed with zstd, which is not read; unpack it"),
    "a.zip": (b"PK\x03\x04" + bytes(26) + b"a.pdb" + GOOD.encode(), {}, "! is compressed with zip, which is not read; unpack it"),
    "utf16.pdb": (GOOD.encode("utf-16"), {}, "! stored as UTF-16"),
    "utf16 of the other order.pdb": (b"\xfe\xff" + GOOD.encode("utf-16-be"), {}, "! stored as UTF-16"),
    "bom before Latin-1.pdb": (b"\xef\xbb\xbf" + GOOD.encode()[:-4] + b"REMARK \xe5\nEND\n", {}, "1 20 4"),
    "bom.pdb": ("\ufeff" + GOOD, {}, "1 20 4"),
    "mixed.pdb": (b"REMARK \xe9\nREMARK \xc3\xa9\n" + GOOD.encode(), {}, "1 20 4"),
    "crcrlf.pdb": (GOOD.replace("\n", "\r\r\n"), {}, "1 20 4"),
    "mac.pdb": (GOOD.replace("\n", "\r"), {}, "1 20 4"),
    "name.ent": (GOOD, {}, "1 20 4"),
    "a name with blanks, Å and ü.pdb": (GOOD, {}, "1 20 4"),
    "rstripped.pdb": ("\n".join(line.rstrip() for line in peptide().split("\n")), {}, "1 20 4"),
    "disordered.pdb": (  # waters have the chain's name, but are not of its sequence
        SEQUENCE + end(peptide(), *(atoms("HOH", str(k), {"O": (0, 9.0 * k, 50)}) for k in range(20, 25))), {},
        "1 20 4 ~ no coordinates for 5 residues"),
    "one-atom.pdb": (atom_line(), {}, "1 1 1 ~ a single atom"),
    "one-residue.pdb": (peptide(["ALA"]), {}, "1 5 1"),
    "no-chain.pdb": (peptide(chain=" "), {}, "1 20 4"),
    "short-lines.pdb": (SHORT, {}, "1 20 4"),
    "words.pdb": (f"{'AUTHOR':30}   1.000 and.so  and.so  \n" + GOOD, {}, "1 20 4"),
    "no-element.pdb": ("\n".join(line[:66] for line in GOOD.split("\n")), {}, "1 20 4"),
    "remark.pdb": (peptide().replace("ATOM  ", "REMARK") + peptide().replace("ATOM  ", "SIGATM") + GOOD, {}, "1 20 4"),
    "hybrid36.pdb": (GOOD.replace("A   2 ", "AA000 "), {"residues": "A:10000"}, "1 5 1"),
    # ranges of residues
    "negative.pdb": (NEGATIVE, {"residues": "A:-5--3,1"}, "1 20 4"),
    "backwards.pdb": (NEGATIVE, {"residues": "A:-1--5"}, "! 'A:-1--5' ends before it begins"),
    "dashes.pdb": (NEGATIVE, {"residues": "-5\u2013-1"}, "! chain:first-last"),
    "codes.pdb": (INSERTED, {"residues": "1A-1B"}, "1 10 2"),
    # columns 67 to 76
    "charges and types of PDBQT.pdb": (end(pdbqt(HEAVY)), {}, WHOLE),
    "charges and types of PDBQT of a metal.pdb": (
        end(pdbqt(HEAVY), put(ligand("ZN", by=(0, 9, 0))[0], name="ZN", element="")[:70] + "  2.000 Zn\n"),
        {"ligands": ["ZN"]}, "1 120 15 1305.2"),
    "scores in columns 67 to 76.pdb": (end(line[:66] + f"{k / 7:10.3f}" + line[76:] for k, line in enumerate(HEAVY)), {}, WHOLE),
    "scores in columns 73 to 76.pdb": (end(put(line, segid=f"{k % 9 / 9:.2f}") for k, line in enumerate(HEAVY)), {}, WHOLE),
    "marks of ZDOCK.pdb": (
        end(f"{line[:54]}{k % 20:4d}  7.00  0  {-0.1 * (k % 3):5.2f}\n" for k, line in enumerate(HEAVY)), {},
        f"{WHOLE.rpartition(' ')[0]} ~ outside 0 to 1"),
    "a segment on some atoms of each residue.pdb": (
        end(put(line, segid="A" if k % 3 else "") for k, line in enumerate(HEAVY)), {}, WHOLE),
    "a segment on some atoms of residues with codes.pdb": (
        end(put(line, segid="A" if k % 3 else "") for k, line in enumerate(coded("1A", "1B", "1C", "1D").splitlines()[:-1])), {},
        "1 20 4"),
    "a segment on new atoms.pdb": (
        end(put(line, segid="new" if line[12:16].strip() == "CB" else "") for line in HEAVY), {}, WHOLE),
    "segments BB and SC.pdb": (
        end(put(line, segid="BB" if line[12:16].strip() in ("N", "CA", "C", "O") else "SC") for line in HEAVY), {}, WHOLE),
    "a segment on heavy atoms alone.pdb": (
        end(line if line in HYDROGENS else put(line, segid="PROT") for line in ALL), {"hydrogens": "remove"}, WHOLE),
    "two segments on heavy atoms alone.pdb": (
        end(put(line, segid="" if line in HYDROGENS else "PROA") for line in ALL)[:-4]
        + end(put(line, segid="" if line in HYDROGENS else "PROB", by=AWAY) for line in ALL),
        {"hydrogens": "remove"}, f"{TWICE} ~ called PROA, PROB"),
    # names of residues
    "a lipid anchor, CYSP.pdb": (end(of(HEAVY, "209"), renamed(of(HEAVY, "210"), "PHEP"), without(HEAVY, "209", "210")),
                                 {"chains": "A"}, WHOLE),
    "GLYM and CYSP.pdb": (
        "".join(peptide([name], first=k, origin=k * STEP) for k, name in enumerate(["GLYM", "ALA", "CYSP", "ALA"], 1)) + "END\n",
        {"chains": "A"}, "1 20 4"),
    "a chain of two letters behind one of one.pdb": (
        peptide() + peptide(["ALA", "SER"], chain="AB", origin=(0, 40, 0)) + "END\n", {"chains": "AB"},
        "1 10 2 ~ lacks heavy atoms"),
    "a name that changes within the residue.pdb": (
        end(renamed([line], "GLUP")[0] if line[12:16].split()[0] in ("CG", "CD", "OE1", "OE2") and line[17:20] == "GLU" else line
            for line in HEAVY), {"chains": "A"}, WHOLE),
    "a name that changes within cysteine.pdb": (
        peptide(["CYS"] * 3).replace("CB  CYS ", "CB  DISU") + "END\n", {}, "1 15 3 ~ 3 residues lack heavy atoms"),
    "a name that changes within the residue.cif": (
        with_items(CIF, "label_comp_id", lambda k, value: "GLH" if 2 < k < 7 else value), {}, WHOLE),
    "some names of authors unknown.cif": (
        TINY.replace("_atom_site.Cartn_x", "_atom_site.label_comp_id\n_atom_site.Cartn_x").replace(" A 1 ", " A 1 ALA ").replace(
            "CA ALA", "CA ."), {}, "1 2 1 ~ lacks heavy atoms, the first is ALA 1 A"),
    "a phosphate of the number of its serine.pdb": (
        end(HEAVY[:36], atoms("PO4", "212", {"P": (47.5, 37.9, 9), "O1": (48.9, 37.9, 9), "O2": (46.2, 37, 9)}), HEAVY[36:]),
        {}, f"{WHOLE} ~ left out 1 PO4"),
    # particles that are not atoms
    "pseudoatoms of CYANA.pdb": (
        end(HEAVY, (put(line, name="QB", element="Q", by=(0.5, 0.5, 0)) for line in HEAVY if line[12:16].strip() == "CB")), {},
        f"{WHOLE} ~ left out 13 particles .*: QB"),
    "pseudoatoms of CYANA, without elements.pdb": (
        end(HEAVY, (put(line, name="QB", element="", by=(0.5, 0.5, 0)) for line in HEAVY if line[12:16].strip() == "CB")), {},
        f"{WHOLE} ~ left out 13 particles"),
    "pseudoatoms of PyMOL.pdb": (end(HEAVY, atoms("PSD", "1", {"PS1": (0, 0, 50)}, element="PS")), {"selection": "all"},
                                 f"{WHOLE} ~ left out 1 particle"),
    "Drude particles.pdb": (
        end(part for line in HEAVY for part in (line, drude(line), *lone_pairs(line))), {}, f"{WHOLE} ~ left out 147 particles"),
    "Drude particles.cif": (
        with_items(cif(end(part for line in HEAVY for part in (line, drude(line)))), "type_symbol",
                   lambda k, value: HEAVY[k // 2][77] if not k % 2 else "?"), {}, f"{WHOLE} ~ left out 119 particles"),
    "masses of virtual hydrogens.pdb": (
        end(HEAVY, (put(line, name=f"MCB{k}", element="", by=(0.1 * k, 0.3, 0)) for line in of(HEAVY, "210") for k in (1, 2)
                    if line[12:16].strip() == "CB")), {}, f"{WHOLE} ~ left out 2 particles"),
    "virtual sites of water.pdb": (
        end(HEAVY, atoms("SOL", "300", {"OW": (0, 0, 50), "HW1": (0.8, 0.6, 50), "HW2": (-0.8, 0.6, 50), "MW": (0, 0.1, 50)})),
        {"selection": "all"}, "1 122 15"),
    "virtual sites of water and pseudoatoms.pdb": (
        end(HEAVY, put(HEAVY[4], name="QB", element="Q", by=(0.5, 0.5, 0)),
            atoms("SOL", "300", {"OW": (0, 0, 50), "HW1": (0.8, 0.6, 50), "HW2": (-0.8, 0.6, 50), "MW": (0, 0.1, 50)})),
        {"selection": "all"}, "1 122 15 ~ left out 2 particles"),
    "a lone pair of a ligand.pdb": (
        end(HEAVY, ligand(), atoms("LIG", "300", {"LP1": (32, 0, 0)}, element="")), {"ligands": True},
        "1 121 15 ~ left out 1 particle"),
    "deuterium in place of hydrogen.pdb": (
        end(put(line, name=line[12:16].strip().replace("H", "D", 1), element="D") if line in HYDROGENS else line for line in ALL),
        {}, f"1 {len(ALL)} 14"),
    "magnesium is no virtual site.pdb": (
        end(HEAVY, atoms("MG", "300", {"MG": (0, 0, 50)}, element="")), {"ligands": ["MG"]}, "1 120 15 ~ radius for MG"),
    "N or O unknown.pdb": (
        end(put(line, name={"OE1": "AE1", "NE2": "AE2"}.get(line[12:16].strip(), line[12:16].strip()), element="A")
            if line[12:16].strip() in ("OE1", "NE2") and line[17:20] == "GLN" else line for line in HEAVY), {}, WHOLE),
    # insertion codes in the order of the chain
    "codes behind their number, 52 52A 52B 53.pdb": (coded("52", "52A", "52B", "53"), {"residues": "A:52-53"}, "1 20 4"),
    "codes before their number, 112B 112A 112.pdb": (
        coded("111", "111A", "112B", "112A", "112", "113"), {"residues": "A:111-112"}, "1 25 5"),
    "codes that run backwards, 1B 1A 1 2.pdb": (coded("1B", "1A", "1", "2", "3"), {"residues": "1B-2"}, "1 20 4"),
    "codes that run backwards, an end that lacks.pdb": (
        coded("1B", "1A", "1", "2", "3"), {"residues": "A:0-1"}, "1 15 3 ~ no residue 0 of 'A:0-1': it has residues A 1B to 3"),
    "codes that run backwards.cif": (cif(coded("1B", "1A", "1", "2", "3")), {"residues": "A:1B-1"}, "1 15 3"),
    "codes from the end to the beginning.pdb": (coded("1B", "1A", "1", "2"), {"residues": "1-1B"}, "! ends before it begins"),
    "a range within codes.pdb": (coded("1B", "1A", "1", "2"), {"residues": "A:1A"}, "1 5 1"),
    "a peptide bond that lacks at a code.pdb": (
        peptide(["ALA"] * 2, first=51) + "".join(
            peptide(["ALA"], first=52, origin=(9, 9, 0)).replace("A  52 ", "A  52A")) + "END\n", {},
        "1 15 3 ~ 1 peptide bond is missing, between ALA 52 A and ALA 52A A"),
    "an expression names one residue of several codes.pdb": (
        coded("52", "52A", "52B", "53"), {"selection": "residue 52"}, "1 5 1 ~ left out 3 ALA"),
    "an expression of a range takes codes along.pdb": (
        coded("1B", "1A", "1", "2", "3"), {"selection": "residue 1 to 2"}, "1 10 2 ~ left out 3 ALA"),
    "an expression of numbers and a chain.pdb": (
        end(HEAVY, peptide(chain="B", first=209, origin=(0, 0, 60))), {"selection": "resSeq 210 to 220 and segname B"},
        "1 15 3 ~ left out"),
    "an expression of a range behind 52A.pdb": (
        coded("52", "52A", "52B", "53"), {"selection": "residue 52 to 53"}, "1 20 4"),
    # residue numbers beyond 9999
    "hexadecimal as of VMD.pdb": (numbered(9998, lambda n: f"{n:x}"), {"residues": "A:10005-10010"}, "1 30 6"),
    "hexadecimal with a letter after a gap.pdb": (
        numbered(9998, lambda n: f"{n:x}", 2, range(12, 20)), {"residues": "A:10010-10013"}, "1 20 4"),
    "hexadecimal, and another chain of decimal numbers.pdb": (
        numbered(9998, lambda n: f"{n:x}")[:-4] + peptide(chain="B", first=2730, origin=(0, 40, 0)) + "END\n",
        {"residues": "B:2730"}, "1 5 1"),
    "hybrid-36 behind 9999.pdb": (
        numbered(9998, lambda n: f"A{n - 10000:03d}", 8), {"residues": "A:9998-10001"}, "1 20 4"),
    "numbers that start again.pdb": (
        peptide(["ALA"] * 2, first=9998) + "TER\n" + peptide(["ALA"] * 2, first=2710, origin=(0, 40, 0)) + "END\n",
        {"residues": "A:2710"}, "1 5 1"),
    # other formats, other content
    "gzip by its content.pdb": (ZIPPED, {}, "! is compressed: add .gz to its name"),
    "gzip by its content.cif": (gzip.compress(CIF.encode()), {}, "! is compressed: add .gz to its name"),
    "PQR with blanks.pdb": (
        "".join(f"ATOM {k} {name} ALA A {k} {x:.3f} {y:.3f} {z:.3f} -0.30 1.85\n"
                for k, (name, (x, y, z)) in enumerate(ALANINE.items())), {}, "! as words between blanks, like a PQR file"),
    "names with blanks in quotes.cif": (
        with_items(with_items(CIF, "auth_asym_id", lambda k, _: "' A'"), "label_comp_id", lambda k, value: f"'{value} '"),
        {"chains": "A"}, WHOLE),
    "a backbone of glycine.pdb": (end(glycines(HEAVY)), {}, "1 56 14 ~ all its 14 residues are glycines"),
    "a backbone of glycine but for one residue.pdb": (
        end(of(HEAVY, "209"), glycines(without(HEAVY, "209"))), {}, "1 61 14"),
    "a short peptide of glycine.pdb": (end(glycines(of(HEAVY, "209", "210", "211", "212", "213"))), {}, "1 20 5"),
    "a backbone of unknown residues.pdb": (
        end(every(glycines(HEAVY), residue_name="UNK")), {}, "1 56 14 ~ 14 residues are unknown .UNK. without a side chain"),
    "unknown residues with side chains.pdb": (end(every(of(HEAVY, "213"), residue_name="UNK"), without(HEAVY, "213")), {}, WHOLE),
    "a pocket.pdb": (
        end(line for line in HEAVY if line[12:16].strip() in ("CA", "CG", "CD", "OE1", "CE1", "CZ", "SD")), {},
        "! parts of residues, as of a pocket"),
    "a crystal of the core dictionary.cif": (
        "data_x\nloop_\n_atom_site_label\n_atom_site_fract_x\nC1 0.5\n", {}, "! CIF of a small molecule or crystal"),
    "a component of the dictionary.cif": (
        "data_ALA\nloop_\n_chem_comp_atom.comp_id\n_chem_comp_atom.atom_id\nALA N\n", {}, "! describes components"),
    "reflections.cif": ("data_x\nloop_\n_refln.index_h\n_refln.F_meas_au\n1 2.0\n", {}, "! holds reflections and no atoms"),
    # serial numbers beyond 99999, and residue numbers that the columns do not hold
    "serial numbers that begin a column earlier.pdb": (
        end(f"ATOM {100_000 + k}{line[11:]}" for k, line in enumerate(HEAVY)), {}, WHOLE),
    "serial numbers that move the line.pdb": (
        end(f"{line[:6]}{100_000 + k}{line[11:]}" for k, line in enumerate(HEAVY)), {}, WHOLE),
    "waters numbered ****.pdb": (end(HEAVY, UNNUMBERED), {}, WHOLE),
    "waters numbered ****, all atoms.pdb": (end(HEAVY, UNNUMBERED), {"selection": "all"}, "1 124 19"),
    "residues numbered ****.pdb": (
        end(of(HEAVY, "209"), every(of(HEAVY, "210"), residue="****")), {}, r"! Line 10 of .* number is \*\*\*\*: write"),
    # hydrogens that are all called H
    "hydrogens all called H behind the chain.pdb": (end(HEAVY, every(HYDROGENS, name=" H")), {}, f"1 {len(ALL)} 14"),
    "hydrogens all called H at their atoms.pdb": (
        end(put(line, name=" H") if line in HYDROGENS else line for line in ALL), {}, f"1 {len(ALL)} 14"),
    "hydrogens all called H before their atoms.pdb": (
        end(line for k in range(209, 223)
            for line in (*every(of(HYDROGENS, str(k)), name=" H"), *of(HEAVY, str(k)))), {}, f"1 {len(ALL)} 14"),
    "hydrogens all called H in two locations.pdb": (
        end(of(HEAVY, "209"), *(every(of(HYDROGENS, "209"), name=" H", altloc=letter) for letter in "AB"), without(HEAVY, "209")),
        {}, f"1 {119 + len(of(HYDROGENS, '209'))} 14"),
    "hydrogens all called H, one of them twice.pdb": (
        end(HEAVY, every(HYDROGENS, name=" H"), every(HYDROGENS[:1], name=" H")), {},
        f"1 {len(ALL) + 1} 14 ~ 1 atom is repeated in its residue"),
    # plausibility of coordinates
    "a part far away.pdb": (peptide(["ALA"] * 9) + peptide(chain="B", origin=(0, 600, 0)), {}, r"! of ALA 1 B lies 58\d Å"),
    "residues in another order.pdb": (reordered(20, np.random.default_rng(5).permutation(20)), {}, "! only .* of the bonds"),
    "residues in another order, five bonds lost.pdb": (
        reordered(20, [1, 0, 2, 4, 3, *range(5, 20)]), {},
        "1 100 20 ~ 5 peptide bonds are missing, the first between ALA 1 A and ALA 2 A, 6.0 Å"),
    "ten atoms apart.pdb": (spread(10), {}, "! only 0 % of the bonds that its names imply"),
    "two chains of a crystal.pdb": (peptide() + peptide(chain="B", origin=(0, 300, 0)), {}, "1 40 8"),
    # chains, models and ligands that are chosen
    "a model that repeats.pdb": (
        models(*(peptide(origin=(x, 0, 0)) for x in (0, 1, 2, 3, 2))), {"stride": 2},
        "3 20 4 ~ 1 frame repeats the one before, the first is frame 4"),
    "no name.pdb": (peptide(chain=" "), {"chains": ""}, "1 20 4"),
    "no name, another one.pdb": (
        peptide(chain=" "), {"chains": "A"}, r"! name.* has one chain, which has no name: leave out `chains`\.$"),
    "a range of another chain.pdb": (
        APART, {"residues": "A:3,99"}, "! '99' is not in .*, which has residues A 1 to 4, B 98 to 101"),
    "a range across chains.pdb": (
        APART, {"residues": "A:3-99"}, "1 10 2 ~ has no residue 99 of 'A:3-99': it has residues A 1 to 4, B 98 to 101"),
    "falling numbers.pdb": (
        peptide(first=11) + peptide(first=1, origin=(0, 0, 9)), {"residues": "A:99"}, r"! which has residues A 1 to 14\.$"),
    "the sequence of another chain.pdb": (LACKING_IN_B, {"chains": "A"}, "1 20 4"),
    "the sequence of all chains.pdb": (
        LACKING_IN_B, {}, "1 40 8 ~ no coordinates for 2 residues of the sequence: 2 in chain B"),
    "no ligands.pdb": (peptide(), {"ligands": "HEM, ZN"}, "! no ligand HEM, ZN: .* nothing.$"),
}  # fmt: skip


@pytest.mark.parametrize("name", STRUCTURES)
def test_structures(tmp_path, caplog, name):
    content, keys, expected = STRUCTURES[name]
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    judge(expected, lambda: measured(read_molecule(path, **keys)), caplog, name)


SHARED = {  # of the reference data: the file, its trajectory, and the outcome without what is said of good files
    "bad/1ubi_CAonly.pdb": "! 13 % of the heavy atoms .*C-alpha",
    "bad/3enl_TRUNCATED_at60000bytes.pdb": "! cut short: it stops in the middle of an atom",
    "bad/header_only.pdb": "! holds no atoms",
    "bad/adk_notop_BAD.psf": "! cut short: it has 3327 of 3341 atoms",
    "bad/1lcd_models_differ.pdb": "3 497 51", "bad/blank_occupancy.pdb": "1 3 1", "structures/1BD2.cif.gz": "1 6339 815",
    "structures/1BD2.pdb.gz": "1 6339 815", "structures/1a8o_mse.cif": "1 556 70", "structures/1a8o_mse.pdb": "1 556 70",
    "structures/1fas.cif": "1 468 61", "structures/1hvr_dimer_ligand_CSO.pdb": "1 1844 198", "structures/1ubi.pdb": "1 602 76",
    "structures/2beg_fibril5chains.pdb": "1 1855 130", "structures/2k39_nmr15.pdb.gz": "15 1231 76",
    "structures/3mht_dna.pdb": "1 2606 327", "structures/3nzmA_negres.pdb.gz": "1 1285 163", "structures/4cup.cif": "1 924 115",
    "structures/6zu5_ribosome.cif.gz": "1 80970 10308", "structures/7etn_tiny.cif.gz": "1 150 8",
    "structures/A6PA6_13res_nochain.pdb": "1 137 13", "structures/ala3_3res.pdb": "1 33 3",
    "structures/cobrotoxin_gmx_nochain.pdb": "1 918 62", "structures/neopetrosiamide_nmr24.pdb": "24 392 28",
    "trajectories/1vii_3frames.pdb": "3 596 36", "trajectories/ala2.h5": "100 22 3",
    "trajectories/trpcage_38models.pdb.gz": "38 304 20",
    "trajectories/adk.psf adk_dims.dcd": "98 3341 214", "trajectories/DPDP.parm7 DPDP.nc": "100 332 22",
    "trajectories/tz2.parm7 tz2.nc": "101 223 13", "trajectories/tz2.parm7 DPDP.nc": "! 332 atoms and .*tz2.parm7 has 223",
    "trajectories/tz2.parm7": "! holds no coordinates: give the trajectory",
    "trajectories/tz2.nc": "! is a trajectory: give it as",
    "trajectories/tz2.parm7 1vii_3frames.pdb": "! 596 atoms and .*tz2.parm7 has 223",
    "trajectories/tz2.parm7 none.xtc": "! does not exist",
}  # fmt: skip


@pytest.mark.parametrize("names", SHARED)
def test_files_of_the_reference_data(shared, caplog, monkeypatch, names):
    path, *trajectory = (Path(name) for name in names.split())
    path = shared / "data" / path
    if not SHARED[names].startswith("!"):
        monkeypatch.setattr(logging.getLogger("sparsurf"), "disabled", True)

    def measure():
        molecule = read_molecule(path, *(path.parent / name for name in trajectory))
        assert set(molecule.element) <= {"C", "N", "O", "S", "H", "SE"} and np.isfinite(molecule.xyz).all()
        return molecule.n_frames, molecule.n_atoms, molecule.n_residues

    judge(SHARED[names], measure, caplog, (trajectory or [path])[-1].name)


TOPOLOGIES = {"perm.xtc": "top.pdb", "twice.dcd": "top.pdb"} | dict.fromkeys(
    ["two_bmir.dcd", "two_bscale.dcd", "two_bstretch.dcd", "wrongbox2.2.xtc"], "top2.pdb"
)
SILENT = {  # good, or what no check can notice
    "fs.nc", "top.pdb", "top2.pdb", "README.tsv", "247_latin.gro",
    # mirror images, one axis stretched by less than 15 %, and a part of the dots inward or in nm
    "083_models_mirror2.pdb", "f5_mir.dcd", "mirall.dcd", "two_bmir.dcd", "116_coord_stretch_x1.12.pdb",
    "010_last400_inward.csv", "038_tail_nm.csv",
}  # fmt: skip


def test_each_bad_file_of_the_reference_data_is_refused_or_reported(shared, caplog, tmp_path):
    (tmp_path / "top.pdb").write_text(PDB)
    silent = set()
    for path in sorted(
        each for kind in ("second", "third") for each in (shared / "data" / "bad" / kind).rglob("*.*")
    ):
        if not path.is_file() or path.suffix in (".sites", ".yaml", ".tsv") or path.name == "grid_full.csv":
            continue
        paths = [path]
        if path.name in TOPOLOGIES:
            paths = [path.with_name(TOPOLOGIES[path.name]), path]
        elif path.parent.name == "traj" and path.name not in ("top.pdb", "top2.pdb"):
            paths = [tmp_path / "top.pdb", path]
        read = read_surface if {".csv", ".npz", ".dms"} & set(path.suffixes) else read_molecule
        caplog.clear()
        with caplog.at_level(logging.WARNING, "sparsurf"):
            if is_read(read, *paths) and not caplog.text:
                silent.add(path.name)
        assert "\x1b" not in caplog.text
    assert silent <= SILENT, silent


FIFTH = {  # files of programs that bend the formats: keys and outcome; areas are those of the same atoms in a plain file
    "pdbqt_as.pdb": ({}, "1 396 50 3452.6"), "segid_phenix_partly.pdb": ({}, "1 396 50 3452.6"),
    "segid_not_on_H.pdb": ({}, "1 780 50 3506.9"), "lipid_CYSP.pdb": ({"chains": "A"}, "1 396 50 3460.1"),
    "partly_GLUP.pdb": ({"chains": "A"}, "1 396 50 3452.6"),
    "cyana_pseudo.pdb": ({}, "1 780 50 3506.9 ~ left out 44 particles"),
    "pymol_pseudo.pdb": ({}, "1 780 50 3506.9 ~ left out 4 particles"),
    "ligand_LP.pdb": ({"ligands": True}, "1 403 51 3574.0 ~ left out 1 particle"),
    "drude.pdb": ({}, "1 780 50 3506.9 ~ left out 496 particles"),
    "kabat.pdb": ({}, "1 396 50"), "thrombin_order.pdb": ({"residues": "A:1H-5"}, "1 111 13"),
    "hex_resid_protein.pdb": ({}, "1 396 50 3452.6"), "rfdiffusion.pdb": ({}, "1 200 50 ~ all its 50 residues are glycines"),
    "gz_named.pdb": ({}, "! is compressed: add .gz to its name"),
    "ambiguous_AD.pdb": ({}, "1 396 50 3452.6"), "cut0.pdb": ({}, "1 792 100 6889.2"),
}  # fmt: skip


@pytest.mark.parametrize("name", FIFTH)
def test_files_of_programs_that_bend_the_formats(shared, caplog, name):
    keys, expected = FIFTH[name]
    judge(
        expected,
        lambda: measured(read_molecule(shared / "data" / "bad" / "fifth" / name, **keys)),
        caplog,
        name,
    )


PEPTIDE_ELEMENTS = {"C": 113, "H": 160, "N": 24, "O": 25, "S": 1}
SIXTH = {  # files of molecular dynamics, and files that other programs bend: trajectory (or topology in front), keys, outcome
    "T.DCD": ("top.pdb T.DCD", {}, "3 323 20"),
    "blank_line_at_end.gro": ("blank_line_at_end.gro", {}, "1 323 20"),
    "dna_five_prime_end.pdb": ("dna_five_prime_end.pdb", {"chains": "B,C"}, "1 445 22"),
    "dna_old_names.pdb": ("dna_old_names.pdb", {"chains": "B,C"}, "1 445 22"),
    "drude_ile.psf": ("drude_ile.psf drude_ile.dcd", {}, "3 323 20 ~ left out 163 particles"),
    "fractional.cif": ("fractional.cif", {}, "1 163 20"),
    "heavy_hydrogens.psf": ("heavy_hydrogens.psf T.DCD", {}, "3 323 20"),
    "inpcrd.crd": ("top.pdb inpcrd.crd", {}, "1 323 20"),
    "insertion_codes.psf": ("insertion_codes.psf T.DCD", {}, "3 323 20"),
    "ions_without_names.pdb": ("ions_without_names.pdb", {}, "1 163 20"),
    "model_without_endmdl.pdb": ("model_without_endmdl.pdb", {}, "1 163 20 ~ its last MODEL has no ENDMDL"),
    "names.gro": ("names.gro", {}, "1 323 20"),
    "netcdf4_compressed.nc": ("top.pdb netcdf4_compressed.nc", {}, "! is a NetCDF-4 file"),
    "precision10.xtc": ("top.pdb precision10.xtc", {}, "! rounded to 1 Å"),
    "residue_numbers.parm7": ("residue_numbers.parm7 T.DCD", {"residues": "A:215-234"}, "3 323 20"),
    "scale_factor.nc": ("top.pdb scale_factor.nc", {}, "3 323 20"),
    "three_unknown_residues.pdb": ("three_unknown_residues.pdb", {}, "1 163 20"),
    "vmd_zero_cell.pdb": ("vmd_zero_cell.pdb", {}, "1 163 20"),
}  # fmt: skip


@pytest.mark.parametrize("name", SIXTH)
@pytest.mark.filterwarnings("ignore")
def test_files_of_molecular_dynamics(shared, caplog, name):
    files, keys, expected = SIXTH[name]
    paths = [shared / "data" / "bad" / "sixth" / file for file in files.split()]
    found = []

    def measure():
        found.append(read_molecule(*paths, **keys))
        return found[0].n_frames, found[0].n_atoms, found[0].n_residues

    judge(expected, measure, caplog, name)
    if found and found[0].n_atoms == sum(PEPTIDE_ELEMENTS.values()):
        elements, counts = np.unique(found[0].element, return_counts=True)
        assert dict(zip(elements.tolist(), counts.tolist(), strict=True)) == PEPTIDE_ELEMENTS
        plain = read_molecule(shared / "data" / "bad" / "sixth" / "top.pdb")
        assert found[0].name.tolist() == plain.name.tolist()
        assert np.abs(found[0].xyz[0] - plain.xyz[0]).max() < 0.011
        if name == "insertion_codes.psf":
            labels = found[0].residues["residue"].tolist()
            assert labels == ["215", "216", "217", "218", "219", "219A", "219B", *map(str, range(220, 233))]


SEVENTH = {  # files with radii, small molecules, cells and columns: topology, keys, and outcome with the area or the radius
    "cell_of_each_model.pdb": ("", {}, "3 329 20 11.051 11.051 11.051"),
    "general_triclinic.lammpstrj": ("top.pdb", {}, "3 329 20 11.051"), "image_flags.data": ("top.pdb", {}, "1 329 20 11.051"),
    "properties_charge_first.xyz": ("top.pdb", {}, "3 329 20 11.051"),
    "properties_id_first.xyz": ("top.pdb", {}, "3 329 20 11.051"), "remd.mdcrd": ("top.pdb", {}, "3 329 20 11.051"),
    "columns_touch.pqr": ("", {}, "233 2043.8"), "element_last.pqr": ("", {}, "233 2043.8"),
    "radius_first.pqr": ("", {}, "! exchange charge and radius"), "nanometres.pqr": ("", {}, "! give lengths in Å"),
    "two_models_end.pqr": ("", {}, "233 2043.8 ~ several models: the first is read"),
    "dummy_atom.mol2": ("", {}, "13 116.3 ~ left out 1 particle"), "gaff_types.mol2": ("", {}, "13 116.3"),
    "tritium.sdf": ("", {}, "13 116.3"), "v3000_continued.sdf": ("", {}, "13 116.3"),
    "crystal_of_minerals.cif": ("", {}, r"! CIF of a small molecule or crystal"),
    "gromos.g96": ("", {}, r"! is a GROMOS96 file .\.g96."), "hydrogens_all_named_H.pdb": ("", {}, "1 195 20"),
    "old_atp_names.pdb": ("", {"ligands": ["ATP"]}, "1 241 31"),
    "pocket_atoms.pdb": ("", {}, "! parts of residues, as of a pocket"),
    "serial_beyond_99999.pdb": ("", {}, "1 233 30"), "top.pdb": ("", {}, "1 329 20 11.051"),
    "unk_backbone.pdb": ("", {}, "1 120 30 ~ 30 residues are unknown"), "waters_without_number.pdb": ("", {}, "1 233 30"),
}  # fmt: skip


@pytest.mark.parametrize("name", SEVENTH)
def test_files_with_radii_cells_and_columns(shared, caplog, name):
    topology, keys, expected = SEVENTH[name]
    folder = shared / "data" / "bad" / "seventh"
    found = []

    def measure():
        path = folder / name
        if path.suffix in (".pqr", ".mol2", ".sdf"):
            dots = sparsurf.surface(path)
            return len(dots.origin.radii), dots.area.sum()
        molecule = read_molecule(folder / topology, path, **keys) if topology else read_molecule(path, **keys)
        found.append(molecule)
        moved = molecule.xyz - molecule.xyz.mean(axis=1, keepdims=True)
        radii_of_gyration = np.sqrt((moved**2).sum(axis=2).mean(axis=1))
        assert np.ptp(radii_of_gyration) < 0.006
        return molecule.n_frames, molecule.n_atoms, molecule.n_residues, *radii_of_gyration

    judge(expected, measure, caplog, name)
    if topology:
        first = found[0].xyz[0] - read_molecule(folder / topology).xyz[0]
        assert np.abs(first - first[0]).max() < 1e-3
    if name == "old_atp_names.pdb":
        assert "".join(found[0].element[-8:]) == "HCOCONPC"


BONDI = "--radii bondi -o a.csv"
EIGHTH = {  # answers to other questions than were asked: command, and words of the terminal, or numbers of columns of the table
    "surface scores.pdb --fields bfactor -o a.bild":
    "coloured by bfactor from 0 to 60, its lowest and highest value; `--limits` fixes them",
    "surface scores_doubled.pdb --fields bfactor --limits=0,60 -o a.pml": "coloured by bfactor from 0 to 60\n",
    "surface plain.pdb --fields potential -o a.png": "coloured by potential from -5 to 5\n",
    f"areas ligand_same_chain.pdb --ligands LIG --of pairs {BONDI}": {"buried": [29.45, 27.01]},
    f"areas dimer_by_remark350.pdb --assembly --of chains {BONDI}": {"buried": [147.8, 147.8]},
    "residues site_100.pdb --residues 229,231 --fields bfactor -o a.csv": {"mean_bfactor": [0, 100]},
    f"areas plain.pdb --selection sidechain {BONDI}": "the selection is measured alone, without the other",
    f"areas plain.pdb --of chains {BONDI}": {"polar": [2885.5], "apolar": [2921.7]},
    f"areas plain.pdb.bz2 --of chains {BONDI}": {"polar": [2885.5], "apolar": [2921.7]},
    "points predictions -o a.parquet": "a.parquet: 2 structures in 2 folders, 2,048 rows",
    "points predictions/job/seed-1_sample-0/model.pdb predictions/job/seed-1_sample-1/model.pdb -o a.parquet":
    "left out 1 LIG\n.*a.parquet: 2 structures in 2 folders, 2,048 rows",
    "surface plain.pdb --mesh --step 2 -o a.ply": r"a\.ply: 9,816 triangles, 7,223 Å\^3",
}  # fmt: skip


@pytest.mark.parametrize("words", EIGHTH)
def test_what_people_asked_is_answered_or_refused(shared, tmp_path, capsys, words):
    expected = EIGHTH[words]
    if ".parquet" in words:
        pytest.importorskip("pyarrow", reason="pyarrow is installed by the extra `many`")
    if ".png" in words:
        pytest.importorskip("matplotlib", reason="matplotlib is installed by the extra `plot`")
    line = [str(shared / "data" / "bad" / "eighth" / word) if word.startswith(("scores", "plain", "site", "ligand_", "dimer_",
            "predictions")) else word for word in words.split()]  # fmt: skip
    line[-1] = str(tmp_path / line[-1])
    main(line)
    if isinstance(expected, str):
        assert re.search(expected, capsys.readouterr().err)
        return
    table = pd.read_csv(line[-1])
    for column, numbers in expected.items():
        assert table[column].tolist() == pytest.approx(numbers, abs=1.5 if numbers[0] > 999 else 0.1)


def test_pseudoatoms_of_pymol_are_left_out_without_their_element(shared, tmp_path, caplog):
    text = (shared / "data" / "bad" / "fifth" / "pymol_pseudo.pdb").read_text()
    (tmp_path / "a.pdb").write_text(
        "\n".join(line[:76] if "PS" in line else line for line in text.split("\n"))
    )
    judge(
        "1 780 50 3506.9 ~ left out 4 particles",
        lambda: measured(read_molecule(tmp_path / "a.pdb")),
        caplog,
        "a.pdb",
    )


def test_a_table_that_excel_exports_is_read_unless_rows_have_more_cells_than_the_header(
    shared, tmp_path, caplog
):
    path = shared / "data" / "bad" / "sixth" / "excel_sep.csv"
    judge("400", lambda: [len(read_surface(path))], caplog, path.name)
    lines = path.read_text().splitlines()[1:]
    for change, expected in (
        ([line + ",," for line in lines], "400"),
        (["sep=;", *lines], "400"),
        ([lines[0], *(line + "," for line in lines[1:])], "! more values than its header has names"),
        ([*lines[:9], *(line + "," for line in lines[9:])], "! line 10 has 7 values, not 6"),
        ([*lines, 5 * ","], "! line 402 has NaN or infinite coordinates"),
    ):
        (tmp_path / "a.csv").write_text("\n".join(change) + "\n")
        judge(expected, lambda: [len(read_surface(tmp_path / "a.csv"))], caplog, "a.csv")


@pytest.mark.parametrize("name", ["charmm_octa.dcd", "scaled.lammpstrj"])
def test_frames_of_two_whole_chains_stay_as_they_are(shared, name):
    folder = shared / "data" / "bad" / "fifth"
    frames = read_molecule(folder / "dimer.pdb", folder / name)
    first = frames.chain == "A"
    centres = frames.xyz[:, first].mean(axis=1) - frames.xyz[:, ~first].mean(axis=1)
    np.testing.assert_allclose(np.linalg.norm(centres, axis=1), np.full(5, 32.0), atol=0.005)


def test_five_letters_pass_through_a_study(tmp_path):
    path = tmp_path / "a.cif"
    path.write_text(STRUCTURES["components of five letters.cif"][0])
    read_molecule(path, ligands=True).write_pdb(tmp_path / "a.pdb")
    assert {"A1LU6", "A1LU7"} < set(read_molecule(tmp_path / "a.pdb", selection="all").residue_name)


def test_labels_of_copies_are_known_apart(tmp_path):
    path = tmp_path / "a.pdb"
    path.write_text(STRUCTURES["two copies of one chain letter, by segments.pdb"][0])
    assert len(read_molecule(path).residues.drop_duplicates()) == 28


# ---- plausibility of coordinates: planted in six frames of the example


@pytest.fixture(scope="module")
def example():
    frames = read_molecule(EXAMPLE, EXAMPLE.with_name("trajectory.xtc"), residues="209-222", stride=180)
    return replace(frames, frame_number=np.arange(6))


def at(molecule, residue, name):
    return int(np.flatnonzero((molecule.residue == str(residue)) & (molecule.name == name))[0])


def moved(place):
    """Return a change of a molecule by a function that changes its coordinates."""

    def change(molecule):
        xyz = molecule.xyz.copy()
        place(molecule, xyz)
        return replace(molecule, xyz=xyz)

    return change


def shift(frame, atom, by):
    """Move an atom, (residue, name), or residues from a number on, in one frame or all."""

    def place(molecule, xyz):
        xyz[frame, at(molecule, *atom) if isinstance(atom, tuple) else molecule.residue_index >= atom] += by

    return moved(place)


def scale(*by, frames=slice(None)):
    def place(molecule, xyz):
        xyz[frames] *= by if len(by) > 1 else by[0]

    return moved(place)


def bond(frame, first, second, length):
    """Give one bond another length."""

    def place(molecule, xyz):
        a, b = xyz[frame, at(molecule, *first)], xyz[frame, at(molecule, *second)]
        b += (b - a) * (length / np.linalg.norm(b - a) - 1)

    return moved(place)


def mixed(molecule):
    """Exchange the atoms inside each residue."""
    rng = np.random.default_rng(5)
    parts = [rng.permutation(np.flatnonzero(molecule.residue_index == k)) for k in range(molecule.n_residues)]
    return replace(molecule, xyz=molecule.xyz[:, np.concatenate(parts)])


def elements(**changed):
    """Give other elements to atoms by their positions, as _3='O'."""

    def change(molecule):
        element = molecule.element.astype("<U2")
        for atom, symbol in changed.items():
            element[int(atom[1:])] = symbol
        return replace(molecule, element=element)

    return change


def doubled(by, change=lambda first, second, frame: second):
    """Add a copy as chain B; `change` moves it in later frames."""

    def double(molecule):
        n, names = molecule.n_atoms, ("name", "residue_name", "element", "residue", "kind", "b_factor")
        second = molecule.xyz + np.asarray(by)
        for frame in range(1, len(second)):
            second[frame] = change(molecule.xyz[frame], second[frame], frame)
        return replace(
            molecule, xyz=np.concatenate([molecule.xyz, second], axis=1), chain=np.repeat(["A", "B"], n),
            residue_index=np.concatenate([molecule.residue_index, molecule.residue_index + molecule.n_residues]),
            **{name: np.tile(getattr(molecule, name), 2) for name in names},
        )  # fmt: skip

    return double


GEOMETRY = {
    "nothing": (lambda m: m, ""),
    "turned and moved": (lambda m: replace(m, xyz=m.xyz[:, :, [1, 2, 0]] + [900.0, -900, 0]), ""),
    "an atom 30 Å away": (shift(4, (213, "CG"), 30.0), "! GLN 213 is 56 Å wide in frame 4 .atom CG is farthest out"),
    "nm as Å": (scale(10.0), "! PHE 221 is 97 Å wide in frame 0 .* give lengths in nm, or repair"),
    "Å as nm": (scale(0.1), r"! 0\.11 Å apart, but bonds are 1 Å or longer"),
    "two parts 6 Å apart": (shift(5, 7, 6.0), r"! the bond C-N of GLY 215 is 11\.1 Å long in frame 5"),
    "two parts 900 Å apart": (shift(4, 7, 900.0), r"! HN of ASP 216 lies 899 Å from the other atoms in frame 4; give"),
    "two parts apart in all frames": (
        shift(slice(None), 7, 9.0), r"~ 1 peptide bond is missing, between GLY 215 and ASP 216, 15\.5 Å"),
    "a bond of 2.9 Å": (bond(3, (214, "CZ"), (214, "OH"), 2.95), ""),
    "a bond of 3.1 Å": (bond(3, (214, "CZ"), (214, "OH"), 3.05), "! the bond CZ-OH of TYR 214 is 3.[01] Å long in frame 3"),
    "a bond of the backbone 1.3 times as long": (
        bond(4, (214, "N"), (214, "CA"), 1.9), "~ bond N-CA of TYR 214 is 1.9 Å long instead of 1.5 Å in frame 4"),
    "a bond of the backbone 1.2 times as long": (bond(4, (214, "N"), (214, "CA"), 1.75), ""),
    "atoms of a residue exchanged": (mixed, "! only 0 % of the bonds that its names imply"),
    "1.25 times as long": (scale(1.25), "! 1.25 times as long as usual in frame 0, and half of them differ by 25 %"),
    "1.25 times as long from frame 5 on": (scale(1.25, frames=slice(5, None)), "! as usual in frame 5"),
    "1.1 times as long": (scale(1.1), "~ differ by 10 % from their usual length in frame 0"),
    "1.17 times as long": (scale(1.17), "! backbone are 1.17 times as long"),
    "1.13 times as long": (scale(1.13), "~ differ by 13 % from"),
    "1.045 times as long": (scale(1.045), "~ half of the bonds of the backbone differ by [45] %"),
    "1.03 times as long": (scale(1.03), ""),
    "0.4 times as long": (scale(0.4), r"! 0\.44 Å apart"),
    "half as long": (scale(0.5), r"! backbone are 0\.50 times as long"),
    "two molecules 1.25 times as long": (
        lambda m: scale(1.25)(doubled((40, 0, 0))(m)), r"! backbone are 1\.25 times as long as usual in frame 0"),
    "a copy that grows later": (
        doubled((60, 0, 0), lambda a, b, k: b * (1 if k < 3 else 1.2)),
        r"! of the chain of GLU 209 B are 1\.19 times as long as usual in frame 3"),
    "two atoms of a residue 0.45 Å apart": (
        bond(0, (213, "CB"), (213, "CG"), 0.45), "~ CG of GLN 213 and CB of GLN 213 lie 0.4 Å apart in frame 0"),
    "two atoms of a residue 0.55 Å apart": (bond(0, (213, "CB"), (213, "CG"), 0.55), ""),
    "an atom 2.9 Å from its residue": (bond(0, (214, "CZ"), (214, "OH"), 2.9), ""),
    "an atom 3.2 Å from its residue": (bond(0, (214, "CZ"), (214, "OH"), 3.2), r"~ OH of TYR 214 lies 3\.2 Å from the nearest"),
    "two parts 470 Å apart": (shift(4, 7, [470.0, 0, 0]), "! the bond C-N"),
    "two parts 540 Å apart": (shift(4, 7, [540.0, 0, 0]), "! Å from the other atoms in frame 4"),
    "18 wrong elements": (elements(**{f"_{k}": "S" for k in range(18)}), "~ N of GLU 209 has the element S; 18 atoms have"),
    "40 wrong elements": (elements(**{f"_{k}": "S" for k in range(40)}), "! N of GLU 209 has the element S; 40 atoms"),
    "z left out": (scale(1, 1, 0), "! all atoms are in one plane in frame 0"),
    "1.02 times as long": (scale(1.02), ""),
    "noise of 0.2 Å": (
        moved(lambda m, xyz: np.add(xyz, np.random.default_rng(0).normal(0, 0.2 / 3**0.5, xyz.shape), out=xyz)),
        r"~ half of the bonds .* by 8 % .* in frame 0\n.*C-O of MET 218 is 0\.9 Å long instead of 1\.2 Å in frame 1"),
    "one atom": (lambda m: m.take([4]), "~ a single atom"),
    "one atom elsewhere": (shift(0, (213, "CB"), [0, 8, 0]), r"~ CB of GLN 213 lies 5\.7 Å from the nearest atom of its residue"),
    "two atoms of a residue in one place": (
        bond(0, (213, "CB"), (213, "CG"), 0.0), "~ CG of GLN 213 and CB of GLN 213 lie 0.0 Å apart in frame 0"),
    "a molecule twice": (doubled((0.67, 0.67, 0.33)), "~ 100 % of its atoms lie inside other residues"),
    "two molecules": (doubled((40, 0, 0)), ""),
    "a copy that shrinks later": (
        doubled((60, 0, 0), lambda a, b, k: b.mean(axis=0) + 0.3 * (b - b.mean(axis=0))),
        r"! chain of GLU 209 B are 0\.30 times as long as usual in frame 1, and half of them differ by 70 %"),
    "a copy laid on the first later": (
        doubled((60, 0, 0), lambda a, b, k: a + 0.05), r"~ SD of MET 218 B and SD of MET 218 A lie 0\.1 Å apart in frame 1"),
    "all elements C": (lambda m: replace(m, element=np.full(m.n_atoms, "C")), "! N of GLU 209 has the element C; 145 atoms"),
    "one wrong element": (elements(_3="O"), "~ H3 of GLU 209 has the element O; 1 atom has"),
    "selenium in place of sulfur": (elements(_3="SE"), ""),
    "not a number": (shift(2, (213, "CB"), np.nan), "! not numbers .* in frame 2"),
    "a coordinate of 1.1e5 Å": (shift(2, (213, "CB"), [0, 0, 1.1e5]), "! beyond 1e.05 Å in frame 2"),
}  # fmt: skip


@pytest.mark.parametrize("name", GEOMETRY)
def test_plausibility(example, monkeypatch, caplog, name):
    monkeypatch.setattr(plausibility, "FRAMES_AT_ONCE", 2)
    change, expected = GEOMETRY[name]

    def measure():
        molecule = change(example)
        with naming_file("run.xtc"):
            plausibility.refuse_invalid_coordinates(molecule.xyz, molecule.frame_number)
            plausibility.refuse_impossible(molecule, unit="nm")
        return ()

    judge(expected, measure, caplog, "run.xtc")


# ---- objects of other libraries: as the file


def with_biotite(path):
    pdb = pytest.importorskip(
        "biotite.structure.io.pdb", reason="biotite is installed by the extra `interop`"
    )
    return pdb.PDBFile.read(path).get_structure(model=1, altloc="all", extra_fields=["b_factor", "occupancy"])


def with_mdanalysis(path):
    universe = pytest.importorskip(
        "MDAnalysis", reason="MDAnalysis is installed by the extra `interop`"
    ).Universe
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return universe(str(path))


def with_biopython(path):
    parser = pytest.importorskip("Bio.PDB", reason="Biopython is installed by the extra `interop`").PDBParser
    return parser(QUIET=True).get_structure("a", str(path))


LIBRARIES = {
    "mdtraj": lambda path: mdtraj.load(str(path), standard_names=False), "biotite": with_biotite, "MDAnalysis": with_mdanalysis,
    "Biopython": with_biopython, "gemmi": lambda path: gemmi.read_pdb(str(path)),
}  # fmt: skip
OBJECTS = {  # rows of the corpus, and the libraries that leave something out when they read the file
    "example.pdb": "", "hydrogens behind the chain.pdb": "", "a modified residue behind the chain.pdb": "MDAnalysis",
    "two copies of one chain letter, by segments.pdb": "biotite Biopython", "A and B of a residue.pdb": "mdtraj",
    "water TP3.pdb": "", "an occupancy above 1.pdb": "mdtraj",
}  # fmt: skip


@pytest.mark.parametrize("library", LIBRARIES)
@pytest.mark.parametrize("name", OBJECTS)
def test_objects_of_other_libraries_are_taken_as_their_files(tmp_path, name, library):
    path = tmp_path / name
    path.write_text(STRUCTURES[name][0])
    molecule, of_object = read_molecule(path), as_molecule(LIBRARIES[library](path))
    if library in OBJECTS[name]:
        return
    for key in ("name", "residue_name", "chain", "residue", "residue_index", "element", "kind"):
        assert np.array_equal(getattr(of_object, key), getattr(molecule, key)), key
    np.testing.assert_allclose(of_object.xyz[:1], molecule.xyz, atol=1e-3)


def test_waters_of_gemmi_without_a_number():
    document = gemmi.cif.read_string(STRUCTURES["no number of any water.cif"][0])
    assert as_molecule(gemmi.make_structure_from_block(document.sole_block())).n_atoms == 119


# ---- trajectories: three frames of the example


def frames(n=3, step=0.0121):
    one = mdtraj.load(str(EXAMPLE))
    many = mdtraj.join([one] * n)
    many.xyz = many.xyz + step * np.arange(n)[:, None, None]  # so that no number ends in a 0
    many.time = np.arange(float(n))
    return many


def shorter(by):
    return lambda content: content[: len(content) - by]


def shorter_by_frames(share):
    """Leave out the end of the last of three frames of a text file, at the end of a line."""

    def change(content):
        lines = content.splitlines(keepends=True)
        title = len(lines) % 3
        n = (len(lines) - title) // 3
        return b"".join(lines[: len(lines) - round(share * n)])

    return change


def announced(n):
    """Give the header of a DCD file another number of frames."""
    return lambda content: content[:8] + n.to_bytes(4, "little") + content[12:]


def dcd_cut(n_frames, of_frames):
    return lambda content: content[: 276 + n_frames * (len(content) - 276) // of_frames]


def joined(*order, times=None):
    def change(several):
        chosen = mdtraj.join([several[k] for k in order])
        chosen.time = np.asarray(times if times else range(len(order)), float)
        return chosen

    return change


def zeroed(several):
    several.xyz[2, 100:300] = 0.0
    return several


def not_a_number(several):
    several.xyz[2, 5, 1] = np.nan
    return several


def longer(several):
    several.xyz *= 10
    return several


def boxless(content):
    """Leave out the boxes of three frames of a TRR file."""
    parts = (content[k * len(content) // 3 : (k + 1) * len(content) // 3] for k in range(3))
    return b"".join(part[:32] + bytes(4) + part[36:84] + part[120:] for part in parts)


def same(content):
    return content


CUT = "~ cut short: its incomplete last frame is left out, 2 were read"
TRAJECTORIES = {  # what becomes of frames of mdtraj, the formats, what becomes of the file, keys, outcome: frames
    "whole": (same, "xtc trr dcd nc h5 xyz lammpstrj gro mdcrd", same, {}, "3 953 61"),
    "a stride of 2": (same, "xtc trr dcd nc h5 xyz lammpstrj gro mdcrd", same, {"stride": 2}, "2 953 61"),
    "a stride of 3": (
        same, "xtc trr dcd nc h5 xyz lammpstrj gro mdcrd", same, {"stride": 3},
        "1 953 61 ~ has 3 frames, of which a stride of 3 leaves only"),
    "a stride beside one frame": (joined(0), "xtc", same, {"stride": 2}, "1 953 61"),
    "frames at some times": (same, "xtc trr nc h5 gro", same, {"times": [2.0]}, "2 953 61"),
    "without a time that is named": (same, "xtc", same, {"times": [9.0]}, "1 953 61 ~ no frame at any of the requested times"),
    "within a frame, at the end of a line": (same, "xyz lammpstrj mdcrd", shorter_by_frames(0.5), {}, f"2 953 61 {CUT}"),
    "within a frame, and a stride of 2": (
        same, "xyz", shorter_by_frames(0.5), {"stride": 2}, "1 953 61 ~ last frame is left out, 1 were read .stride 2"),
    "within a number": (same, "xyz lammpstrj mdcrd", shorter(2), {}, f"2 953 61 {CUT}"),
    "without the last newline": (same, "xyz lammpstrj gro mdcrd", shorter(1), {}, "3 953 61"),
    "behind a frame": (same, "xyz lammpstrj gro mdcrd", shorter_by_frames(1), {}, "2 953 61"),
    "within the first frame": (joined(0), "xyz", shorter(2), {}, "! cut short within its first frame"),
    "half a file": (joined(0), "xtc trr dcd nc", lambda content: content[: len(content) // 3], {}, "! cannot be read"),
    "nothing": (same, "xtc trr dcd nc h5", lambda content: b"", {}, "! cannot be read"),
    "fewer frames than announced": (same, "dcd", dcd_cut(2, 3), {}, "2 953 61 ~ holds 2 frames, and its header announces 3"),
    "more frames than announced": (same, "dcd", announced(2), {}, "3 953 61 ~ continues after the 2 frames"),
    "without a box": (same, "trr", boxless, {}, "3 953 61"),
    "the same frame again": (joined(0, 1, 1, 2), "xtc trr dcd nc xyz", same, {}, "3 953 61 ~ 1 frame repeats the one before"),
    "all frames again": (joined(0, 1, 0, 1), "xtc trr dcd nc xyz", same, {}, "4 953 61 ~ its second half repeats the first"),
    "frames there and back": (joined(0, 1, 1, 0), "xtc", same, {}, "3 953 61 ~ repeats the one before"),
    "a time that goes back": (joined(0, 1, 2, times=[0, 2, 1]), "xtc", same, {}, "3 953 61 ~ time goes back to 1 ps at frame 2"),
    "a time that stands still": (joined(0, 1, 2, times=[0, 1, 1]), "xtc", same, {}, "3 953 61"),
    "zeros": (zeroed, "xtc dcd trr nc", same, {}, "! in frame 2"),
    "not a number": (not_a_number, "dcd", same, {}, "! not numbers .* in frame 2"),
    "other atoms": (lambda several: several.atom_slice(range(950)), "xtc dcd nc xyz", same, {}, "! 950 atoms and .* has 953"),
    "ten times as long": (
        longer, "dcd nc", same, {}, r"! run\.(dcd|nc): .* lengths in Å, and atoms in the order of .*topology\.pdb"),
    "ten times as long as": (
        longer, "xtc trr", same, {}, r"! run\.(xtc|trr): .* lengths in nm, and atoms in the order of .*topology\.pdb"),
}  # fmt: skip
EVERY_TRAJECTORY = [f"{name}.{kind}" for name, row in TRAJECTORIES.items() for kind in row[1].split()]


@pytest.mark.parametrize("name", EVERY_TRAJECTORY)
@pytest.mark.filterwarnings("ignore")
def test_trajectories(tmp_path, caplog, name):
    row, _, kind = name.partition(".")
    change, _, damage, keys, expected = TRAJECTORIES[row]
    path = tmp_path / f"run.{kind}"
    several = change(frames())
    if kind == "mdcrd":
        several.unitcell_vectors = None
    several.save(str(path))
    path.write_bytes(damage(path.read_bytes()))
    top = path if kind in ("h5", "gro") else EXAMPLE

    def measure():
        molecule = read_molecule(top, None if top == path else path, **keys)
        return molecule.n_frames, molecule.n_atoms, molecule.n_residues

    judge(expected, measure, caplog, path.name)


@pytest.mark.parametrize(("order", "cell"), [("<", False), (">", True)])
def test_frames_of_a_dcd_file_are_counted_by_its_size(tmp_path, caplog, order, cell):
    def record(content):
        return (length := struct.pack(order + "i", len(content))) + content + length

    path, frame = tmp_path / "a.dcd", cell * record(bytes(48)) + 3 * record(bytes(16))
    for n, count, stride, words in (
        (100, 100, 1, ""), (99, 100, 1, "~ continues after the 99"), (1, 2, 1, "~ continues after the 1 "), (0, 2, 1, ""),
        (101, 100, 1, "~ cut short"), (100, 100, 2, ""), (103, 100, 2, "~ holds 100 frames, and its header announces 103"),
    ):  # fmt: skip
        head = record(b"CORD" + struct.pack(order + "i", n) + bytes(76)) + record(bytes(84))
        path.write_bytes(head + record(struct.pack(order + "i", 4)) + count * frame)
        found = -(-count // stride)
        with naming_file(path):
            judge(
                words,
                lambda n=found, s=stride: check_dcd(path, 4, n, slice(0, None, s)) or (),
                caplog,
                "a.dcd",
            )


@pytest.mark.parametrize(
    ("unit", "expected"),
    [("femtosecond", "0.001"), ("picosecond", "1"), ("nanosecond", "1000"), ("year", "! 'year'")],
)
def test_times_of_netcdf_are_read_in_their_unit(tmp_path, caplog, unit, expected):
    from scipy.io import netcdf_file

    several = frames()
    with netcdf_file(tmp_path / "a.nc", "w", version=2) as file:
        file.Conventions, file.ConventionVersion = "AMBER", "1.0"
        for name, size in (("frame", 0), ("spatial", 3), ("atom", several.n_atoms)):
            file.createDimension(name, size)
        times = file.createVariable("time", "f4", ("frame",))
        places = file.createVariable("coordinates", "f4", ("frame", "atom", "spatial"))
        times.units, places.units = unit, "angstrom"
        for k in range(3):
            times[k], places[k] = k, 10 * several.xyz[k]
    judge(expected, lambda: read_molecule(EXAMPLE, tmp_path / "a.nc").time_ps[1:2], caplog, "a.nc")


def test_velocities_between_positions_are_no_frames(tmp_path, caplog):
    """A TRR file with velocities at 0, 5, 10 ps and positions at 0 and 10 ps."""
    path = tmp_path / "a.trr"
    frames().save(str(path))
    content = path.read_bytes()
    size = len(content) // 3
    sizes = slice(size + 24 + 28, size + 24 + 36)  # of the positions and the velocities of the second frame
    path.write_bytes(content[: sizes.start] + content[sizes][4:] + content[sizes][:4] + content[sizes.stop :])
    judge("2 953 61", lambda: measured(read_molecule(EXAMPLE, path)), caplog, "a.trr")
    named = read_molecule(EXAMPLE, path, times=[2.0])  # ps, of the third frame
    assert named.time_ps.tolist() == [0, 2] and np.diff(named.xyz, axis=0) == pytest.approx(0.242, abs=0.002)


# ---- dots: changes of a surface of the example, as a file and as arrays


@pytest.fixture(scope="module")
def dots():
    molecule = read_molecule(EXAMPLE, residues="209-222", hydrogens="remove")
    return molecular_surface(molecule.xyz[0], radii(molecule))


def flipped(share):
    def change(points, normals):
        wrong = np.random.default_rng(1).random(len(points)) < share
        return points, np.where(wrong[:, None], -normals, normals)

    return change


def random_normals(share):
    def change(points, normals):
        rng = np.random.default_rng(2)
        other = rng.normal(size=normals.shape)
        other /= np.linalg.norm(other, axis=1)[:, None]
        return points, np.where(rng.random(len(points))[:, None] < share, other, normals)

    return change


def some(share, by=1.0):
    """Take dots at random; `by` multiplies the normals."""

    def change(points, normals):
        few = np.random.default_rng(3).choice(len(points), int(share * len(points)), replace=False)
        return points[few], normals[few] * by

    return change


def ball(n, radius, without=0, places=(0, 0, 0)):
    """Return dots spread evenly over a sphere but for the first ones, which lie around a pole, and their normals."""
    unit = sphere(n)[0][without:]
    return lambda *_: (radius * unit + places, unit)


def pile(points, normals):
    return np.where((np.arange(len(points)) < 0.3 * len(points))[:, None], points[0], points), normals


def lifted(by):
    """Move one dot up."""

    def change(points, normals):
        points = points.copy()
        points[np.argmax(points[:, 2])] += [0, 0, by]  # the highest: nothing lies above it
        return points, normals

    return change


def inward(n):
    """Return n dots on a ball with normals inward."""
    return lambda *_: (5 * sphere(n)[0], -sphere(n)[0])


def far(repeats):
    """Move one dot away, behind `repeats` further copies of the first one."""

    def change(points, normals):
        rows = np.append(np.zeros(repeats, int), np.arange(len(points)))
        points = points[rows]
        points[7 + repeats, 1] -= 5000
        return points, normals[rows]

    return change


UPRIGHT, OPPOSE = (
    r"! not perpendicular .*dots 0\.44\)",
    "of neighbouring dots have normals that oppose each other",
)
DOTS = {
    "nothing": (lambda p, n: (p, n), ""),
    "turned": (lambda p, n: (p[:, [2, 0, 1]] + 3000, n[:, [2, 0, 1]]), ""),
    "columns of normals exchanged": (lambda p, n: (p, n[:, [1, 0, 2]]), UPRIGHT),
    "columns of normals exchanged, few dots": (
        lambda p, n: some(0.06)(p, n[:, [1, 0, 2]]), r"! not perpendicular .*dots 0\.4\d\)"),
    "one axis mirrored": (lambda p, n: (p, n * [1, 1, -1]), UPRIGHT),
    "points inexact": (
        lambda p, n: (p + np.random.default_rng(0).normal(0, 0.5, p.shape), n), r"! not perpendicular .*dots 0\.49\)"),
    "normals of the next row": (lambda p, n: (p, np.roll(n, -1, axis=0)), "! fit the dots 1 row further down"),
    "normals two rows before": (lambda p, n: (p, np.roll(n, 2, axis=0)), "! fit the dots 2 rows further up"),
    "normals three rows before": (lambda p, n: (p, np.roll(n, 3, axis=0)), "! fit the dots 3 rows further up"),
    "normals of another row": (lambda p, n: (p, np.roll(n, 7, axis=0)), f"! 2[68] % {OPPOSE}"),
    "every 10th flipped": (flipped(0.1), f"! 20 % {OPPOSE}: give outward normals"),
    "every 4th flipped": (flipped(0.25), f"! 39 % {OPPOSE}: give outward normals"),
    "every 5th random": (random_normals(0.2), f"! 19 % {OPPOSE}"),
    "all inward": (lambda p, n: (p, -n), "~ normals point inwards"),
    "twice as long": (lambda p, n: (2 * p, n), r"~ curves of 3\.4 Å; are lengths in Å"),
    "in nm": (lambda p, n: (p / 10, n), r"! 0\.038 Å apart on curves of 0\.17 Å: the lengths seem to be in nm"),
    "a tenth of the dots": (some(0.1), ""),
    "one dot in fifty": (some(0.02), ""),
    "the first half, in the order of atoms": (
        lambda p, n: (p[: len(p) // 2], n[: len(p) // 2]), r"~ do not close around a molecule \(4 % of"),
    "a dot 5 Å above the others": (
        lifted(5), r"~ (line 6437|dot 6436) lies 5\.1 Å from the nearest other dot, where most lie 0\.4 Å"),
    "a dot 1.5 Å above the others": (lifted(1.5), ""),
    "a dot 2.7 Å above the others": (lifted(2.7), r"~ (line 6437|dot 6436) lies 2\.\d Å from the nearest other dot"),
    "49 dots inward": (inward(49), ""),
    "50 dots inward": (inward(50), "~ normals point inwards"),
    "a ball of 1000 dots without 4 %": (ball(1044, 5.0, 44), ""),
    "a ball of sparse dots without 4 %": (ball(1200, 8.5, 44), ""),
    "a dot far from the others": (far(0), r"! (line 9|dot 8) lies 4990 Å from all other dots"),
    "a dot far from the others, the first thrice": (far(2), r"! (line 11|dot 10) lies 4990 Å from all other dots"),
    "a heap of dots": (pile, r"! (line 2|dot 1) and others lie in one place"),
    "two dots in one place": (lambda p, n: (np.tile(p[:1], (2, 1)), n[:2]), "! lie in one place"),
    "normals of length 0": (lambda p, n: (p, np.where(np.arange(len(n))[:, None] == 5, 0, n)), "! normal of length 0"),
    "normals of length 0.2 to 6": (
        lambda p, n: (p, n * np.random.default_rng(1).uniform(0.2, 6, (len(n), 1))), "~ are scaled to 1"),
    "normals and points exchanged": (lambda p, n: (n, p), "! exchange the columns"),
    "a ball of 0.35 Å": (ball(900, 0.35), r"! 0\.039 Å apart on curves of 0\.35 Å: the lengths seem to be in nm"),
    "a ball of 0.5 Å": (ball(900, 0.5), ""),
    "a ball of 12 Å": (ball(900, 12.0), "~ dots lie on curves of 12 Å; are lengths in Å?"),
    "a ball of 104 Å": (ball(900, 104.0), ""),
    "a ball without 4 %": (ball(1200, 5.0, 44), r"~ do not close around a molecule \(4 % of the normals do not cancel\)"),
    "a ball without 2.5 %": (ball(1200, 5.0, 30), ""),
    "half a ball inward": (
        lambda *_: (ball(2002, 5.0, 1001)()[0], -ball(2002, 5.0, 1001)()[1]), r"~ ^[^\n]* normals point inwards; [^\n]*$"),
    "half a ball": (ball(2002, 5.0, 1001), r"~ do not close .*\(50 % of"),
    "normals of 170 dots flipped": (lambda *_: flipped(0.5)(*ball(170, 9.0)()), ""),
    "normals of 400 dots flipped": (lambda *_: flipped(0.5)(*ball(400, 9.0)()), f"! 53 % {OPPOSE}"),
    "a plane": (
        lambda *_: (np.column_stack([*np.divmod(np.arange(100.0), 10), np.zeros(100)]), np.tile([0, 0, 1.0], (100, 1))), ""),
}  # fmt: skip


@pytest.mark.parametrize("name", DOTS)
@pytest.mark.parametrize("form", ["a.csv", "surface"])
def test_dots(dots, caplog, tmp_path, name, form):
    change, expected = DOTS[name]
    if form == "surface" and name.startswith("normals") and ("length" in name or "points" in name):
        expected = "! normals are not of unit length"
    points, normals = change(dots.points, dots.normals)
    path = tmp_path / "a.csv"
    np.savetxt(path, np.column_stack([points, normals]), "%.4f", ",", header="x,y,z,nx,ny,nz", comments="")

    def measure():
        surface = read_surface(path) if form == "a.csv" else as_dots((points, normals))
        assert np.abs(np.linalg.norm(surface.normals, axis=1) - 1).max() < 2e-3
        return ()

    judge(expected, measure, caplog, form)


@pytest.mark.parametrize(("density", "probe"), [(1.0, 1.4), (20.0, 1.4), (3.0, 0.8), (3.0, 3.0)])
def test_true_surfaces_of_every_kind_pass(dots, caplog, density, probe):
    molecule = read_molecule(EXAMPLE, residues="209-222", hydrogens="remove")
    found = molecular_surface(molecule.xyz[0], radii(molecule), probe=probe, density=density)
    judge("", lambda: as_dots((found.points, found.normals)) and (), caplog, "surface")


def value_at(name, value, row=5):
    def change(columns):
        columns[name] = columns[name].astype(type(value))
        columns[name][(row, 1) if name == "points" else row] = value

    return change


def times(name, factor):
    def change(columns):
        columns[name] = columns[name] * factor

    return change


def of_type(name, kind):
    def change(columns):
        columns[name] = columns[name].astype(kind)

    return change


def left_out(name):
    return lambda columns: columns.pop(name)


ARRAYS = {  # of an NPZ file: what is changed, and the sum of areas with the outcome; nan stands for an estimate
    "nothing": (lambda columns: None, "1280.7"),
    "areas in nm^2": (times("area", 0.01), r"nan ~ 0\.01 times as large .* they are left out, and estimated"),
    "areas six times too large": (times("area", 6.0), r"! 6\.2 times as large as the spacing"),
    "areas 1.4 times too large": (times("area", 1.4), "1793.0"),
    "areas 1.55 times too large": (times("area", 1.55), r"! 1\.6 times as large as the spacing"),
    "areas 0.7 times as large": (times("area", 0.7), "896.5"),
    "areas 0.6 times as large": (times("area", 0.6), r"nan ~ 0\.62 times as large .* they are left out, and estimated"),
    "areas of 0": (times("area", 0.0), "nan ~ all areas are 0; they are estimated"),
    "positions in half precision": (of_type("points", np.float16), "1280.7 ~ float16, which rounds them by up to 0.03 Å"),
    "a negative area": (value_at("area", -0.1), "! dot 6 has a negative area: repair or remove it"),
    "an area of 1e4": (value_at("area", 1e4), r"! dot 6 has an area above 185 Å\^2"),
    "a kind of 3": (value_at("kind", 3), "! dot 6 has a kind other than"),
    "a kind of 256": (value_at("kind", 256), "! dot 6 has a kind other than"),  # which is 0 in a byte
    "an atom of -2": (value_at("atom", -2), "! dot 6 has an atom that is not an index"),
    "a point at -2.1e6": (value_at("points", -2.1e6), r"! dot 6 has a coordinate beyond 2e\+06 Å \(.+, -2.1e\+06, .+\)"),
    "no normals": (left_out("normals"), "! has no normals"),
    "objects": (
        lambda columns: columns.update(kind=np.array([None] * len(columns["kind"]))),
        "! a.npz is not a surface written by this program, or damaged"),
}  # fmt: skip


@pytest.mark.parametrize("name", ARRAYS)
def test_arrays_of_a_file(dots, tmp_path, caplog, name):
    change, expected = ARRAYS[name]
    columns = {key: getattr(dots, key).copy() for key in ("points", "normals", "area", "kind", "atom")}
    change(columns)
    np.savez(tmp_path / "a.npz", **columns)

    def measure():
        total = read_surface(tmp_path / "a.npz").area.sum()
        assert np.isnan(total) == expected.startswith("nan")
        return [] if np.isnan(total) else [total]

    judge(expected.removeprefix("nan"), measure, caplog, "a.npz")


WRONG = {  # arrays of Surface, and words of the refusal
    "points": [
        (None, "points has the shape"), ("dots.csv", "points must hold real numbers"),
        (3, "points must hold real numbers"), ([[1, 2, 3], [1, 2]], "points must hold real numbers"),
        (np.eye(3) * 1j, "points must hold real numbers"),
        (np.eye(3) > 0, "points holds True and False: give numbers"),
        (np.eye(3).astype("m8[s]"), "points must hold real numbers"),
        (np.ma.masked_array(np.eye(3), np.eye(3) > 0), "points has masked values"),
    ],
    "normals": [(np.eye(3) + 0j, "normals must hold real numbers"), (np.eye(3, dtype=bool), "normals holds True and False")],
    "area": [
        ("large", "area must hold real numbers"), ([None, 1, 1], "area that is NaN"),
        (np.ma.masked_array([1.0, 2, 3], [0, 1, 0]), "area has masked values"),
    ],
    "kind": [(np.array(["SC"] * 3), "kind must hold real numbers"), ([True, False, True], "kind holds True and False")],
    "atom": [([0, 1, 2**31], "dot 3 has an atom that is not an index"), ([0, 1, 2e40], "dot 3 has an atom that is not an index")],
    "fields": [
        (3, "fields must be a dictionary"), ({1: [1, 2, 3]}, "fields must be a dictionary of names"),
        ({"a": "b"}, "the field a must hold real numbers"), ({"a": np.ones(3) * 1j}, "the field a must hold real numbers"),
        ({"a": [1, 2]}, r"the field a has the shape \(2,\), not \(3,\)"),
        *(({name: [1, 2, 3]}, "a field cannot be called")
          for name in ("", "a b", "1a", "é", "q\n", "area", "Weight", "points", "file")),
    ],
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "value", "words"), [(name, *row) for name, rows in WRONG.items() for row in rows]
)
def test_something_else_than_arrays_of_numbers(caplog, name, value, words):
    given = {"points": np.eye(3), "normals": np.eye(3), name: value}
    judge(f"! {words}", lambda: Surface(**given) and (), caplog, "")
    if name in ("points", "normals"):
        judge(f"! {words}", lambda: as_dots((given["points"], given["normals"])) and (), caplog, "")


def test_nearest_dots_are_those_of_a_search_over_all(dots):
    points, chosen = dots.points[:300], np.array([0, 5, 299])
    every_distance = np.linalg.norm(points[:, None] - points, axis=2) + np.diag(np.full(300, np.inf))
    distance, other = nearest_neighbours(points, chosen)
    assert other.tolist() == every_distance[chosen].argmin(axis=1).tolist()
    np.testing.assert_allclose(distance, every_distance[chosen].min(axis=1), rtol=1e-12)


# ---- files of dots

N = 300
BLOB = make_blob(N + 60)  # points and normals
TABLE = np.column_stack(BLOB)
ROWS = [[f"{value:.4f}" for value in row] for row in TABLE]
CSV = "x,y,z,nx,ny,nz\n" + "".join(",".join(row) + "\n" for row in ROWS)
VERTEX = "element vertex {}\n" + "".join(f"property float {a}\n" for a in ["x", "y", "z", "nx", "ny", "nz"])
WORDS = "".join(" ".join(row) + "\n" for row in ROWS)
BEFORE = "element camera 1\nproperty float view\nelement face 2\nproperty list uchar int vertex_indices\n"
DMS = "".join(
    f"ALA {k + 1:5d}   CA {x:8.3f} {y:8.3f} {z:8.3f} SC0 {0.3:6.3f}{u:7.3f}{v:7.3f}{w:7.3f}\n"
    for k, (x, y, z, u, v, w) in enumerate(TABLE)
)


def ply(kind, n=N + 60, table=None, before=""):
    """Return a PLY file: its header, and words or bytes."""
    head = (f"ply\nformat {kind} 1.0\n{before}" + VERTEX + "end_header\n").format(n).encode()
    return head + (WORDS.encode() if table is None else table)


def member(content):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("points.npy", content)
    return stream.getvalue()


def numpy_header(text):
    return b"\x93NUMPY\x01\x00v\x00" + text.ljust(117) + b"\n"


SURFACES = {  # content, and the number of dots with the outcome
    "good.csv": (CSV, "360"),
    "crlf.csv": (CSV.replace("\n", "\r\n"), "360"),
    "bom.csv": ("\ufeff" + CSV, "360"),
    "quoted.csv": (CSV.replace(",", '","').replace("\n", '"\n"')[:-1].join(['"', ""]), "360"),
    "each dot twice.csv": (CSV + CSV[15:], "360 ~ dots that occur twice are removed"),
    "utf16.csv": (CSV.encode("utf-16"), "! stored as UTF-16"),
    "semicolons.csv": (CSV.replace(",", ";").replace(".", ","), "! no commas in its header"),
    "header_twice.csv": (CSV + CSV, f"! line {N + 62} "),
    "wide.csv": (CSV + "1," * 2000 + "\n", "! more than 1000 values"),
    **{
        f"value {k}.csv": (CSV.replace(ROWS[9][0], value, 1), "! line 11 ")
        for k, value in enumerate(("NaN", "n/a", "", "-inf", "1e400", "0x10", "1_0", "\u22121", "1d0"))
    },
    "page.csv": ("<html><body>404, not found</body></html>", "! has no column x"),
    "bom.ply": (b"\xef\xbb\xbf" + ply("ascii"), "360"),
    "bom and an empty line.ply": (b"\xef\xbb\xbf\r\n" + ply("ascii"), "360"),
    "big.ply": (ply("binary_big_endian", table=TABLE.astype(">f4").tobytes()), "360"),
    "camera and faces first.ply": (
        ply("ascii", before=BEFORE).replace(b"end_header\n", b"end_header\n0.5\n3 0 1 2\n2 1 2\n"), "360"),
    "camera and faces first, binary.ply": (
        ply("binary_little_endian", before=BEFORE,
            table=struct.pack("<fB3iB2i", 0.5, 3, 0, 1, 2, 2, 1, 2) + TABLE.astype("<f4").tobytes()),
        "360"),
    "two lists of vertices.ply": (
        ply("ascii", before=VERTEX.format(1)).replace(b"end_header\n", b"end_header\n0 0 0 0 0 1\n"), "! several lists"),
    "faces that do not end.ply": (ply("ascii", before=BEFORE.replace("face 2", "face 9000")), "! cannot be read"),
    "more.ply": (ply("ascii", N), f"! more than the {N} vertices"),
    "more_bytes.ply": (ply("binary_little_endian", N, TABLE.astype("<f4").tobytes()), "! more than"),
    "good.dms": (DMS, "360 ~ they are left out"),
    "type.dms": (DMS.replace("SC0", "XX0", 1), "! line 1 is a dot of no type"),
    "cut.dms": (DMS[:-12], "! line 360 is not a dot"),
    "grid.dx": ("object 1 class gridpositions counts 3 3 3\norigin 0 0 0\n", "! holds no dots"),
    "no array.npz": (member(b"raw bytes"), "! or damaged"),
    "a huge shape.npz": (
        member(numpy_header(b"{'descr': '<f8', 'fortran_order': False, 'shape': (300000000000,), }")), "! or damaged"),
    "a negative shape.npz": (member(numpy_header(b"{'descr': '<f8', 'fortran_order': False, 'shape': (-1,), }")), "! or damaged"),
}  # fmt: skip


@pytest.mark.parametrize("name", SURFACES)
def test_files_of_dots(tmp_path, caplog, name):
    content, expected = SURFACES[name]
    (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())

    def measure():
        surface = read_surface(tmp_path / name)
        np.testing.assert_allclose(surface.points, BLOB[0], atol=0.003)
        return [len(surface)]

    judge(expected, measure, caplog, name)


def test_each_odd_file_of_the_list_is_a_case_or_a_test():
    """The list from which docs/reference/odd_files.md is written."""
    listed = yaml.safe_load((ROOT / "tests" / "library" / "odd_files.yaml").read_text(encoding="utf-8"))
    cases = [case for rows in listed.values() for _, _, case in rows]
    assert len(cases) > 40
    files = (ROOT / "tests" / "library").rglob("test_*.py")
    tests = {name for file in files for name in re.findall(r"^def (test_\w+)", file.read_text(), re.M)}
    assert {*cases} <= {
        *STRUCTURES,
        *SIXTH,
        *SEVENTH,
        *GEOMETRY,
        *TRAJECTORIES,
        *DOTS,
        *ARRAYS,
        *SURFACES,
        *tests,
    }


# ---- paths and keys

READERS = {  # of every kind of file that a command takes
    **dict.fromkeys(["pdb", "cif", "gro", "h5"], read_molecule),
    **dict.fromkeys(["psf", "prmtop"], lambda path: read_molecule(path, path.with_suffix(".xtc"))),
    **dict.fromkeys(["xtc", "dcd", "nc", "mdcrd", "rst7"], lambda path: read_molecule(EXAMPLE, path)),
    **dict.fromkeys(["csv", "npz", "dms"], read_surface),
    "pqr": pqr_charges,
    "table": lambda path: TableOfAtoms.read(path, read_molecule(EXAMPLE)).field("value"),
}
PLACES = {  # what stands where the path of a file is expected
    "a URL": ("https://files.rcsb.org/download/1ubi.pdb", "https://files.* is a URL: give a file; nothing is downloaded"),
    "a URL as a Path": (Path("https://files.rcsb.org/download/1ubi.pdb"), "is a URL: give a file; nothing is downloaded"),
    "the text of a file": (PDB, "the text of a file stands in place of its path, 'ATOM .*: store it in a file"),
    "a short text of a file": (PDB[:162], "the text of a file stands in place of its path"),
    "a null byte": ("a\0.pdb", "cannot be read: .*null"),
    "a drive": ("C:/a.pdb", "C:/a.pdb does not exist"),
}  # fmt: skip


@pytest.mark.parametrize("name", PLACES)
@pytest.mark.parametrize("read", [read_molecule, sparsurf.surface, read_surface, sparsurf.roughness])
def test_a_url_or_a_text_in_place_of_a_path(caplog, name, read):
    place, words = PLACES[name]
    with pytest.raises(InputError, match=words) as error:
        read(place)
    assert len(str(error.value)) < 300 and "\n" not in str(error.value)


class Foreign:
    """An object of another library whose properties need a package that is absent, or whose methods fail."""

    level = "S"

    def __init__(self, error):
        self.error = error

    def fail(self):
        raise self.error

    topology = xyz = coord = universe = weight = surface = property(fail)

    def get_atoms(self):
        self.fail()


@pytest.mark.parametrize(
    "error", [ImportError("no OpenMM"), RuntimeError("damaged"), AttributeError("gone"), KeyError(3)]
)
def test_an_object_whose_properties_raise_errors_is_no_molecule(error):
    for call in (sparsurf.surface, sparsurf.depth, sparsurf.roughness, sparsurf.points):
        with pytest.raises(InputError, match=r"a Foreign is not a (molecule|surface)"):
            call(Foreign(error))


PATHS = {
    "nothing": (lambda path: None, "does not exist"),
    "a pipe": (os.mkfifo, "is a pipe or a device: store its content in a file"),
    "a device": (lambda path: path.symlink_to(os.devnull), "is a pipe or a device"),
    "a folder": (lambda path: path.mkdir(), "is a folder: give one file"),
    "a circle of links": (lambda path: path.symlink_to(path.name), "cannot be read: Too many"),
    "a folder that is a file": (
        lambda path: path.parent.rmdir() or path.parent.touch(),
        "leads into a file: unpack an archive first",
    ),
}


@pytest.mark.parametrize("name", PATHS)
@pytest.mark.parametrize("kind", READERS)
def test_paths(tmp_path, caplog, name, kind):
    make, words = PATHS[name]
    path = tmp_path / "folder" / f"a.{kind}"
    path.parent.mkdir()
    make(path)
    judge(f"! {words}", lambda: READERS[kind](path) and (), caplog, path.name)


WITH_LIGAND = end(
    peptide(), peptide(chain="B", first=11, origin=(0, 9, 0)),
    (atom_line(name, "LIG", "A", "9", (9, 9, z), record="HETATM") for name, z in (("C1", 0), ("C2", 1))),
    (atom_line("O", "HOH", "B", str(k), (k, 9, 9), record="HETATM") for k in (21, 22)),
)  # fmt: skip
TRAJECTORY_APART = "leave out the trajectory and the model"
REFUSED_KEYS = [
    ({"trajectory": "a.xtc", "plddt": 70}, "plddt: a trajectory has none; remove `plddt`"),
    ({"trajectory": "a.xtc", "assembly": True}, TRAJECTORY_APART), ({"model": 1, "assembly": True}, TRAJECTORY_APART),
    ({"model": 1.0}, "model: 1.0 is not a whole number"), ({"stride": 0}, "stride is 0"),
    ({"times": [0]}, "^times: there is no trajectory to take frames from; give one"),
    ({"times": "soon"}, "times is 'soon'; it must be a list of numbers, ps"),
    ({"altloc": "AB"}, "altloc: 'AB' is neither first, highest nor one letter"),
    ({"altloc": ""}, "altloc: '' is neither"), ({"altloc": 1}, "altloc: '1' is neither"),
    ({"hydrogens": "drop"}, "hydrogens: 'drop' is neither keep nor remove"),
    ({"whole": "x"}, r"^whole is 'x'; it must be True or False\.$"),
    ({"chains": "C,A,D"}, r"has no chain C, D: its chains are A, B\.$"), ({"chains": ""}, "empty chain name; the chains of"),
    ({"chains": "A,"}, "chains: empty chain name"), ({"chains": [" "]}, "chains: empty chain name"),
    ({"chains": 5}, "chains is 5; it must be a string"),
    ({"residues": "A:500-600"}, "'A:500-600' is not in .* residues A 1 to 4"), ({"residues": "B:1"}, "'B:1' is not in"),
    ({"residues": "6-8"}, r"'6-8' is not in .*a\.pdb, which has residues A 1 to 4, B 11 to 14\.$"),
    ({"residues": "ten-12"}, "'ten-12' is not of the form"),
    ({"residues": "3-2"}, "'3-2' ends before it begins: swap the two numbers"),
    ({"residues": 5}, "residues is 5; it must be a string such as 'A:10-52A,60'"),
    ({"selection": " "}, "selection is empty"), ({"selection": 5}, "selection is 5; it must be"),
    ({"selection": "resname ==="}, "is not an mdtraj expression"),
    ({"selection": "__import__('os')"}, "is not an mdtraj expression"),
    ({"selection": "chain A"}, r"see mdtraj.org, or choose chains by `chains`\.$"),
    ({"selection": "name CA or " * 910}, "has 10,010 characters, more than 10,000"),
    ({"selection": "name XX"}, r"no atoms; the file has chains A, B with 8 protein residues, 2 HOH, 1 LIG\.$"),
    ({"ligands": 5}, "ligands is 5; it must be a string"),
    ({"ligands": "HEM"}, r"has no ligand HEM: besides polymers, the file contains HOH, LIG\.$"),
    ({"ligands": 999 * "QQQQQ,"}, r"has no ligand (QQQQQ, ){14}QQ\.\.\..* \(\d+ characters\)"),
]  # fmt: skip


@pytest.mark.parametrize(("keys", "words"), REFUSED_KEYS)
def test_keys_that_a_file_does_not_allow(caplog, tmp_path, keys, words):
    (tmp_path / "a.pdb").write_text(WITH_LIGAND)
    judge(f"! {words}", lambda: read_molecule(tmp_path / "a.pdb", **keys) and (), caplog, "")


KEYS = ["altloc", "hydrogens", "ligands", "chains", "residues", "selection", "model", "stride"]


@pytest.mark.parametrize(
    ("key", "value"),
    [(key, value) for key in KEYS for value in (np.zeros(3), 2.5, b"x", {"a": 1})]
    + [("plddt", value) for value in ("70", -1, 101, np.nan, [70])] + [("times", value) for value in (["a"], b"x", {"a": 1})],
)  # fmt: skip
def test_a_key_of_a_wrong_type(caplog, key, value):
    judge("!", lambda: read_molecule(EXAMPLE, **{key: value}) and (), caplog, "")


def test_control_characters_do_not_reach_the_terminal(tmp_path, caplog, capsys):
    path = tmp_path / "a.pdb"
    path.write_text(STRUCTURES["escape.pdb"][0])
    assert main(["surface", str(path), "-o", str(tmp_path / "a.csv")]) == 1
    assert "\x1b" not in capsys.readouterr().err
    assert str(InputError("a\x1b[31mb\0\nc")) == "a\\x1b[31mb\\x00\nc"
    logging.getLogger("sparsurf").warning("%s is odd", "a\x1b[31m.pdb")
    assert "\x1b" not in caplog.text and "\\x1b[31m.pdb is odd" in caplog.text


# ---- damage at random, and what fuzzing found

KINDS = {"pdb": read_molecule, "mmcif": read_molecule, "gro": read_molecule} | dict.fromkeys(
    ["dms", "csv", "ply", "npz"], read_surface
)
SUFFIXES = {"mmcif": "cif"}


def is_read(read, *paths):
    """Read a file; return whether it is not refused. The sentence of a refusal is one line that a terminal can show."""
    try:
        read(*paths)
    except InputError as error:
        assert str(error).isprintable()
        return False
    return True


@pytest.mark.parametrize("kind", KINDS)
def test_every_file_that_fuzzing_found_is_read_or_refused(tmp_path, kind):
    outcomes = {}
    for path in sorted((SEEDS / kind).iterdir()):
        copied = shutil.copy(path, tmp_path / f"{path.stem}.{SUFFIXES.get(kind, kind)}")
        outcomes[path.name] = is_read(KINDS[kind], copied)
    seeds = [name for name in outcomes if "." in name]
    assert seeds and all(outcomes[name] for name in seeds) and len(outcomes) > len(seeds)


@given(st.binary(max_size=300), st.sampled_from(["pdb", "cif", "pdb.gz", "ent", "gro", "psf", "h5"]))
@settings(max_examples=40)
def test_any_bytes_are_refused(tmp_path_factory, content, extension):
    path = tmp_path_factory.mktemp("fuzz") / f"a.{extension}"
    path.write_bytes(content)
    assert not is_read(read_molecule, path)


def damaged(content, rng):
    """Return content with one random fault of the kinds that disks, editors and killed copies make."""
    data = bytearray(content)
    start, length = rng.randrange(len(data)), rng.choice([1, 4, 16, 81, 1000])
    part = slice(start, start + length)
    fault = rng.choice(["cut", "flip", "delete", "repeat", "insert", "zero", "header"])
    if fault == "cut":
        del data[start:]
    elif fault == "flip":
        for _ in range(rng.choice([1, 5, 50])):
            data[rng.randrange(len(data))] = rng.randrange(256)
    elif fault == "repeat":
        data[start:start] = data[part]
    elif fault == "header":  # where binary formats keep their counts
        data[start % 400 : start % 400 + 4] = rng.choice(
            [b"\xff\xff\xff\x7f", bytes(4), b"\x7f\xff\xff\xff", b"9999"]
        )
    else:
        data[part] = {"delete": b"", "insert": rng.randbytes(length), "zero": bytes(length)}[fault]
    return bytes(data)


@pytest.mark.parametrize("kind", ["pdb", "cif", "gro", "xtc", "trr", "dcd", "nc", "h5"])
@pytest.mark.filterwarnings("ignore")
def test_damaged_files_are_read_or_refused(tmp_path, kind):
    """Neither a crash nor another error than a sentence; SPARSURF_FUZZ_CASES sets how many files."""
    whole, rng = tmp_path / f"whole.{kind}", random.Random(20260101)
    if kind in ("pdb", "cif"):
        whole.write_text(PDB if kind == "pdb" else CIF)
    else:
        frames().save(str(whole))
    outcomes = []
    for case in range(int(os.environ.get("SPARSURF_FUZZ_CASES", "6"))):
        path = tmp_path / f"{case}.{kind}"
        path.write_bytes(damaged(whole.read_bytes(), rng))
        outcomes.append(
            is_read(read_molecule, *([path] if kind in ("pdb", "cif", "gro", "h5") else [EXAMPLE, path]))
        )
    assert not all(outcomes)
