"""Reading and writing of PDB files, column by column, every doubtful line refused.

Columns: wwPDB format 3.3 (https://www.wwpdb.org/documentation/file-format); residue numbers beyond 9999 in
hybrid-36 (http://cci.lbl.gov/hybrid_36). Written here because readers in common use are too kind: they take
'1x.812' for 1.0, merge residues of equal number where chains have no name (so that the order of the atoms
is no longer the trajectory's), cut residue names at three letters and stop at the first END.
"""

import re
from collections import defaultdict
from functools import cache
from itertools import product
from pathlib import Path
from string import ascii_lowercase, ascii_uppercase, digits

import gemmi
import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.files import shorten
from sparsurf.molecules.atom_table import AtomFile, box_vectors, log, missing_residues
from sparsurf.molecules.residues import HEAVY_ATOMS, VARIANTS, WATERS, standard_name

COLUMNS = [
    "model", "hetero", "name", "altloc", "residue_name", "chain", "residue", "x", "y", "z", "occupancy",
    "b_factor", "element", "terminated",
]  # fmt: skip
ATOM_RECORDS = ("ATOM  ", "HETATM")
AFTER_ATOMS = ("END", "ENDMDL", "MASTER", "CONECT")
FOUR_LETTER_NAMES = frozenset(name for name in VARIANTS.keys() | WATERS if len(name) == 4)
NUMBER = re.compile(r" *[-+]?(\d+\.?\d*|\.\d+) *")
# Hybrid-36: after 9999 comes A000, after ZZZZ a000.
HYBRID = re.compile(r"[A-Z][0-9A-Z]{3}|[a-z][0-9a-z]{3}")
UPPER, LOWER, LETTERED = int("A000", 36), int("a000", 36), 26 * 36**3


def read_pdb(text, path):
    """Atoms of a PDB file; MODEL, or an END with more atoms after it, starts another model.

    Parameters
    ----------
    text : str, lines ending in '\\n'
    path : named in messages

    Returns
    -------
    atoms.AtomFile

    Raises
    ------
    InputError : the file is another format, cut short or damaged, or holds no atoms
    """
    if text.lstrip().startswith(("data_", "loop_")):
        raise InputError(f"{path} is an mmCIF file by its content: rename it to .cif.")
    lines = text.split("\n")
    wide_chains = _has_wide_chains(lines)
    rows, box, promised, terminated = [], None, defaultdict(list), False
    used, next_model, last_atom, announced, linked = [], 1, 0, 0, set()
    for number, line in enumerate(lines, 1):
        record = line[:6].ljust(6)
        if record in ATOM_RECORDS:
            if next_model is not None:
                used.append(next_model)
                next_model = None
            rows.append((used[-1], *_atom(line, f"Line {number} of {path}", wide_chains), terminated))
            terminated, last_atom = False, number
        elif record == "TER   ":
            terminated = True
        elif record in ("MODEL ", "ENDMDL", "END   "):
            next_model = _model_number(line, used, path)
        elif record == "SEQRES":
            promised[line[11:12].strip()] += line[19:70].split()
        elif record == "CRYST1":
            box = _box(line)
        elif record == "NUMMDL":
            announced = int(line[10:14]) if line[10:14].strip().isdecimal() else 0
        elif record == "LINK  ":
            linked |= _linked(line)
        elif _is_damaged_atom(line):
            raise InputError(f"Line {number} of {path} holds an atom but begins with '{record}': repair it.")
    if not rows:
        raise InputError(f"{path} holds no atoms: give a file with ATOM records.")
    atoms = pd.DataFrame(rows, columns=COLUMNS)
    _check_end(lines, last_atom, atoms, promised, path)
    if len(used) < announced:
        log.warning("%s announces %d models and holds %d: is it cut short?", path, announced, len(used))
    return AtomFile(atoms, box, promised, frozenset(linked))


def _atom(line, where, wide_chains):
    """One row of the table, from an ATOM or HETATM record."""
    fields = line[30:38], line[38:46], line[46:54]
    if len(line) < 54:
        raise InputError(f"{where} is cut short: copy the file again or repair the line.")
    if not all(map(NUMBER.fullmatch, fields)):
        given = line[30:54].strip()
        raise InputError(f"{where} has no readable coordinates ('{given}'): repair the line.")
    name, number = line[12:16].strip(), _decoded(line[22:26].strip())
    joined = any(record in line[54:] for record in ATOM_RECORDS)  # two lines that lost their newline
    if not name or number is None or line[27:30].strip() or joined:
        raise InputError(f"{where} is not in the columns of a PDB file: repair the line.")
    split = 20 if wide_chains else 21
    return (
        line.startswith("HETATM"), name, line[16].strip(), line[17:split].strip(), line[split:22].strip(),
        number + line[26].strip(), *map(float, fields),
        float(line[54:60]) if NUMBER.fullmatch(line[54:60]) else 1.0,
        float(line[60:66]) if NUMBER.fullmatch(line[60:66]) else np.nan, _element(line[76:78].strip()),
    )  # fmt: skip


@cache
def _element(symbol):
    return symbol.upper() if symbol.isalpha() and gemmi.Element(symbol).name != "X" else ""


def _has_wide_chains(lines):
    """Whether column 21 belongs to a chain id of two letters; else to a residue name of four."""
    standard = (
        line for line in lines if line.startswith(ATOM_RECORDS) and line[17:20].strip() in HEAVY_ATOMS
    )
    return any(line[20:21].strip() and line[17:21].strip() not in FOUR_LETTER_NAMES for line in standard)


def _model_number(line, used, path):
    """Number of the model that follows: the one given if no other has it, else the next free one."""
    following = max(used, default=0) + 1
    given = line[6:14].strip() if line.startswith("MODEL ") else ""
    if not given.isdecimal():
        return following
    if int(given) in used:
        log.warning(
            "%s has several models of the number %s: the later one is called %d", path, given, following
        )
        return following
    return int(given)


def _box(line):
    values = [line[6:15], line[15:24], line[24:33], line[33:40], line[40:47], line[47:54]]
    return box_vectors(*map(float, values)) if all(map(NUMBER.fullmatch, values)) else None


def _linked(line):
    """Chain and label of the two residues of a LINK record, where both are of a polymer."""
    ends = [line[17:27], line[47:57]]
    if all(standard_name(end[:3].strip()) in HEAVY_ATOMS for end in ends):
        return {(end[4].strip(), end[5:].strip()) for end in ends}
    return set()


def _is_damaged_atom(line):
    """Whether a line holds coordinates under another name than ATOM or HETATM, or a piece of the name or one with a tab."""
    if line.startswith(("ATOM\t", "HETATM\t")):
        return True
    if line[34:35] + line[42:43] + line[50:51] == "..." and not line.startswith(("REMARK", "SIGATM")):
        return all(map(NUMBER.fullmatch, (line[30:38], line[38:46], line[46:54])))
    return 0 < len(line) < 6 and any(record.startswith(line) for record in ATOM_RECORDS)


def _check_end(lines, last_atom, atoms, promised, path):
    """Refuse a file that stops in its last atom, or without an END before its sequence is complete."""
    last, before = lines[last_atom - 1].rstrip(), lines[last_atom - 2].rstrip()
    no_newline = last_atom == len(lines)
    if no_newline and before.startswith(ATOM_RECORDS) and len(last) < len(before):
        raise InputError(f"{path} is cut short: it stops in the middle of an atom; copy it again.")
    ended = any(line[:6].strip() in AFTER_ATOMS for line in lines[last_atom:])
    if not ended and any(line.startswith("MODEL ") for line in lines):
        raise InputError(f"{path} is cut short: its last MODEL has no ENDMDL; copy it again.")
    missing = missing_residues(atoms, promised)
    if missing and not ended:
        found, expected = (sum(counts) for counts in zip(*missing.values(), strict=True))
        raise InputError(
            f"{path} has {found} of the {expected} residues that its SEQRES records announce and no END "
            "record: copy it again, or add END if it is complete."
        )


def write_pdb(path, xyz, atoms, b_factor=None):
    """Write one model: ATOM and HETATM lines, TER after each chain, END; the same bytes for the same input.

    Chain ids of more than two letters do not fit: they get free names, which a warning tells.

    Parameters
    ----------
    path : file to write
    xyz : (A, 3) float, Å
    atoms : molecule.Molecule, or anything with its arrays of names
    b_factor : (A,) float, optional
        0 without it.
    """
    chains = _written_chains(atoms.chain)
    b_factor = np.zeros(len(xyz)) if b_factor is None else b_factor
    width = max(map(len, chains))
    lines = []
    for i, place in enumerate(xyz):
        record = "ATOM  " if atoms.kind[i] in ("protein", "nucleic") else "HETATM"
        name, symbol = atoms.name[i], atoms.element[i]
        name = f"{name:4.4s}" if len(name) > 3 or len(symbol) > 1 else f" {name:<3s}"
        owner = f"{atoms.residue_name[i]:>3.{5 - max(width, 1)}s}"  # four letters reach into column 21
        owner += f"{chains[i]:>{5 - len(owner)}s}{_encoded(atoms.residue[i])}"
        numbers = "".join(f"{x:8.3f}"[:8] for x in place) + f"  1.00{b_factor[i]:6.2f}"
        lines.append(f"{record}{(i + 1) % 100_000:5d} {name} {owner}   {numbers}          {symbol:>2.2s}\n")
        if i + 1 == len(xyz) or atoms.chain[i + 1] != atoms.chain[i]:
            lines.append("TER\n")
    Path(path).write_text("".join([*lines, "END\n"]), encoding="latin-1", errors="replace")


def _written_chains(chain):
    """(A,) str: the chain ids that fit in two letters, and for the others the first of A, B, C, ... that are free."""
    ids = list(dict.fromkeys(chain.tolist()))
    long = [each for each in ids if len(each) > 2]
    if not long:
        return chain.tolist()
    letters = ascii_uppercase + ascii_lowercase + digits
    names = [*letters, *map("".join, product(letters, repeat=2))]
    renamed = dict(zip(long, (name for name in names if name not in ids), strict=False))
    told = shorten(", ".join(f"{old} is {new}" for old, new in renamed.items()))
    log.warning("chains whose ids are too long for a PDB file have other names in its results: %s", told)
    return [renamed.get(each, each) for each in chain.tolist()]


def _decoded(text):
    """Residue number of a field of four characters as text, from decimal or hybrid-36; None if neither."""
    if not HYBRID.fullmatch(text):
        return text if re.fullmatch(r"(-?\d+)?", text) else None
    return str(int(text, 36) - (UPPER if text[0].isupper() else LOWER - LETTERED) + 10_000)


def _encoded(residue):
    """Number and insertion code in five characters."""
    number, code = re.fullmatch(r"(-?\d*)(.?)", residue).groups()
    if number and not -1000 < int(number) < 10_000 + 2 * LETTERED:
        raise InputError(
            f"residue {number} does not fit into a PDB file, which numbers from -999 to {9_999 + 2 * LETTERED}: renumber it."
        )
    if len(number) > 4:
        above = int(number) - 10_000
        upper = above < LETTERED
        number = np.base_repr(above + (UPPER if upper else LOWER - LETTERED), 36)
        number = number if upper else number.lower()
    return f"{number:>4s}{code or ' '}"
