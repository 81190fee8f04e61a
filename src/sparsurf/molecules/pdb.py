"""Read and write PDB files, column by column; every doubtful line is refused.

Columns: wwPDB format 3.3 (https://www.wwpdb.org/documentation/file-format); residue numbers beyond 9999 in
hybrid-36 (http://cci.lbl.gov/hybrid_36). Common readers are too tolerant for this project: they read '1x.812' as 1.0,
merge residues of equal number if chains have no name (so that the order of the atoms differs from the trajectory's),
cut residue names at three letters and stop at the first END.
"""

from __future__ import annotations

import logging
import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache, partial
from itertools import compress, product
from pathlib import Path
from string import ascii_lowercase, ascii_uppercase, digits
from typing import Any

import gemmi
import numpy as np

from sparsurf.errors import FILE, InputError
from sparsurf.files import StrPath, shorten
from sparsurf.molecules.assemblies import assemblies_of_pdb
from sparsurf.molecules.atom_table import AtomFile, AtomTable, atom_table, box_vectors, missing_residues
from sparsurf.molecules.atoms import AtomsLike
from sparsurf.molecules.plddt import origin_of_pdb
from sparsurf.molecules.residues import (
    HEAVY_ATOMS,
    LINKAGES,
    LONG_NAMES,
    NO_ELEMENTS,
    VARIANTS,
    WATERS,
    known_kind,
    split_label,
    standard_name,
)

log = logging.getLogger("sparsurf")

ATOM_RECORDS = ("ATOM  ", "HETATM")
ENDS = ("TER   ", "MODEL ", "ENDMDL", "END   ")
LINE_WIDTH, MIN_WIDTH = 80, 54  # The widths of a whole line of an atom, and of the shortest.
HEADER_RECORDS = frozenset(
    ["HEADER", "TITLE ", "COMPND", "SOURCE", "KEYWDS", "EXPDTA", "AUTHOR", "REVDAT", "JRNL  ", "REMARK"]
)
AFTER_ATOMS = ("END", "ENDMDL", "MASTER", "CONECT")
FOUR_LETTER_NAMES = frozenset(name for name in VARIANTS.keys() | WATERS | LONG_NAMES if len(name) == 4)
# Types of atoms in PDBQT files of AutoDock that are not spelt as their element
AUTODOCK = {"OA": "O", "OS": "O", "NA": "N", "NS": "N", "SA": "S", "HD": "H", "HS": "H"}
# First of the three letters that stand for a residue name of five, which HETNAM gives (as gemmi writes it)
LONG_NAME = "~"
LONGEST_NAME = 8  # A residue name in HETNAM has at most so many letters.
PDB_NUMBER = re.compile(r" *[-+]?(\d+\.?\d*|\.\d+) *")
NOT_OF_A_NUMBER = re.compile(r"[^-+.\d ]")
DECIMAL = re.compile(r"(-?\d+)?")
# An atom in words: record, number, names, three coordinates and more
IN_WORDS = re.compile(r"(ATOM|HETATM)\s+\d+(\s+\S+){2,4}(\s+[-+]?\d+\.\d+){3,}")
# Hexadecimal as VMD writes numbers beyond 9999: 2710 follows 9999
HEXADECIMAL = re.compile(r"[0-9a-f]{4}|[0-9A-F]{4}")
MIN_B_FACTOR, MAX_B_FACTOR = -99.99, 999.99  # The B factors that fit into six characters.
# A serial number beyond 99999, which begins one column earlier or moves what is behind it
LONG_SERIAL = re.compile(r"(?m)^(ATOM  ?|HETATM)\d{6,}(?=.{23}\.\d{3}.{4}\.\d{3}.{4}\.\d{3})")
NUMBER_TOO_LARGE = "****"  # Fortran writes this for a number that its columns do not hold.
MAX_JUMP = 1000  # Residue numbers rise by at most so much where hexadecimal ones begin.
# Hybrid-36: A000 follows 9999, a000 follows ZZZZ.
HYBRID_36 = re.compile(r"[A-Z][0-9A-Z]{3}|[a-z][0-9a-z]{3}")
FIRST_UPPER, FIRST_LOWER, N_PER_CASE = int("A000", 36), int("a000", 36), 26 * 36**3


def read_pdb(text: str) -> AtomFile:
    """Read a PDB file, lines ending in '\\n', and refuse a damaged one; MODEL, or END before further atoms, starts a model."""
    if text.lstrip().startswith(("data_", "loop_")):
        raise InputError(f"{FILE} is an mmCIF file by its content: rename it to .cif.")
    text = LONG_SERIAL.sub(lambda match: f"{match[1]:<6s}*****", text)
    lines = text.split("\n")
    is_atom = np.array([line.startswith(ATOM_RECORDS) for line in lines])
    atom_lines, other_lines = list(compress(lines, is_atom)), list(compress(lines, ~is_atom))
    n_atoms_before = np.append(0, np.cumsum(is_atom))
    is_end = [line[:6].ljust(6) in ENDS for line in other_lines]
    columns, in_columns, doubtful = _columns(atom_lines, {*n_atoms_before[:-1][~is_atom][is_end].tolist()})
    cells: list[
        tuple[int, np.ndarray | None]
    ] = []  # the number of models that begin before a cell, and the cell
    sequences: dict[str, list[str]] = defaultdict(list)
    crosslinked: set[tuple[str, str]] = set()
    long_names: dict[str, str] = {}
    models: dict[int, int] = {}  # by number, the first atom
    molecules: list[int] = []  # the first atom of each but the first
    next_model: int | None = 1
    begin = n_announced = 0
    look_at = ~is_atom
    look_at[is_atom] = doubtful
    for place in [*np.flatnonzero(look_at).tolist(), len(lines)]:
        n_before = int(n_atoms_before[place])
        if next_model is not None and n_before > begin:
            models[next_model] = begin
            next_model = None
        if place == len(lines):
            break
        line, number = lines[place], place + 1
        record = line[:6].ljust(6)
        if record in ATOM_RECORDS:
            _refuse_atom(line, number, bool(in_columns[n_before]))
        elif record == "TER   ":
            molecules.append(n_before)
        elif record in ENDS:
            next_model, begin = _model_number(line, models), n_before
        elif record == "SEQRES":
            sequences[line[11:12].strip()] += line[19:70].split()
        elif record == "CRYST1":
            cells.append((len(models), _box(line)))
        elif record == "NUMMDL":
            n_announced = int(line[10:14]) if line[10:14].strip().isdecimal() else 0
        elif record == "LINK  ":
            crosslinked |= _crosslinked(line)
        elif record == "HETNAM" and line[11:12] == LONG_NAME and len(line[71:79].split()) == 1:
            long_names[line[11:14]] = line[71:79].strip()
        elif record not in HEADER_RECORDS and _is_damaged_atom(line):
            raise InputError(f"Line {number} of {FILE} holds an atom but begins with '{record}': repair it.")
    if not atom_lines:
        if any(IN_WORDS.match(line) for line in lines):
            raise InputError(
                f"{FILE} holds its atoms as words between blanks, like a PQR file, and not in the columns of a PDB file: give "
                "the PDB or mmCIF file that it was made from."
            )
        raise InputError(f"{FILE} holds no atoms: give a file with ATOM records.")
    columns["model"] = np.repeat([*models], np.diff([*models.values(), len(atom_lines)]))
    columns["molecule"] = np.searchsorted(molecules, np.arange(len(atom_lines)), "right")
    columns["residue_name"] = [long_names.get(name, name) for name in columns["residue_name"]]
    atoms = atom_table(**columns)
    _check_end(lines, int(np.flatnonzero(is_atom)[-1]) + 1, atoms, sequences)
    if len(models) < n_announced:
        log.warning("%s announces %d models and holds %d: is it cut short?", FILE, n_announced, len(models))
    boxes = _box_of_models(cells, [*models]) if len(cells) > 1 else {}
    box = cells[0][1] if cells else None
    has_box = any(cell is not None for _, cell in cells)
    origin = origin_of_pdb(other_lines, has_box)
    remarks = [line for line in other_lines if line.startswith("REMARK 350")]
    assemblies = partial(assemblies_of_pdb, remarks)
    return AtomFile(atoms, box, sequences, frozenset(crosslinked), origin, boxes, assemblies)


def _box_of_models(
    cells: list[tuple[int, np.ndarray | None]], models: list[int]
) -> dict[int, np.ndarray | None]:
    """Return the lattice vectors of each model, whose cell is the last one before its atoms, or else the first of the file.

    A cell behind the last model shows that each one stands behind its model.
    """
    behind = cells[-1][0] == len(models)
    boxes = {}
    for k, model in enumerate(models):
        preceding = [cell for n_before, cell in cells if n_before <= k + behind]
        boxes[model] = preceding[-1] if preceding else cells[0][1]
    return boxes


def _columns(lines: list[str], ends: set[int]) -> tuple[dict[str, Any], np.ndarray, np.ndarray]:
    """Return columns of the table from the lines of atoms, which lines are in the columns of a PDB file, and which to look at.

    `ends` are the numbers of lines before ends of chains, behind which residue numbers begin anew.
    """
    letters = np.array([line.ljust(LINE_WIDTH) for line in lines], f"U{LINE_WIDTH}").view("U1")
    letters = letters.reshape(len(lines), LINE_WIDTH)

    def text(first: int, last: int) -> np.ndarray:
        return np.ascontiguousarray(letters[:, first:last]).view(f"U{last - first}")[:, 0]

    def words(first: int, last: int) -> np.ndarray:
        return np.char.strip(text(first, last))

    hetero, element = text(0, 6) == "HETATM", [*map(_element, text(76, 78).tolist(), text(78, 79).tolist())]
    name = words(12, 16)
    # some programs leave the name of an ion blank
    name = np.where((name == "") & hetero, element, name)
    field, chain = words(22, 26), text(21, 22)
    begins = np.isin(np.arange(len(lines)), [0, *ends])
    begins[1:] |= (field[1:] != field[:-1]) | (chain[1:] != chain[:-1])
    numbers, read_number = [], NumberReader()
    for k in np.flatnonzero(begins).tolist():
        read_number = NumberReader() if k in ends else read_number
        numbers.append(read_number(str(field[k]), str(chain[k])))
    run = np.cumsum(begins) - 1
    number = np.array([text or "" for text in numbers], object)[run]
    no_number = np.array([text is None for text in numbers], bool)[run]
    too_large = field == NUMBER_TOO_LARGE
    xyz = np.column_stack([_numbers(text(first, first + 8)) for first in (30, 38, 46)])
    in_columns = (name != "") & (~no_number | too_large) & (words(27, 30) == "")
    if sum(map("".join(lines).count, ATOM_RECORDS)) > len(lines):  # two lines that lost their newline
        in_columns &= [not any(record in line[54:] for record in ATOM_RECORDS) for line in lines]
    short = np.array([len(line) < MIN_WIDTH for line in lines], bool)
    split = 20 if _has_wide_chains(text) else 21
    numbered = np.char.isdecimal(words(76, 80)).all()  # the entry and the number of the line, as before 1996
    columns = {
        "hetero": hetero, "name": name.tolist(), "altloc": words(16, 17).tolist(), "residue_name": words(17, split).tolist(),
        "chain": words(split, 22).tolist(), "residue": (number + words(26, 27).astype(object)).tolist(),
        "x": xyz[:, 0], "y": xyz[:, 1], "z": xyz[:, 2], "occupancy": np.nan_to_num(_numbers(text(54, 60)), nan=1.0),
        "b_factor": _numbers(text(60, 66)), "element": element,
        "segid": [""] * len(lines) if numbered else [*map(_segid, text(66, 76).tolist())],
    }  # fmt: skip
    return columns, in_columns, ~in_columns | too_large | short | np.isnan(xyz).any(axis=1)


def _numbers(texts: np.ndarray) -> np.ndarray:
    """Return texts (A,) as numbers, nan where they are none."""
    listed = texts.tolist()
    try:
        if not NOT_OF_A_NUMBER.search("".join(listed)):
            return np.array([*map(float, listed)])
    except ValueError:  # such as '1-2', or a blank
        pass
    return np.array([float(text) if PDB_NUMBER.fullmatch(text) else np.nan for text in listed])


def _refuse_atom(line: str, line_number: int, in_columns: bool) -> None:
    """Raise InputError if an ATOM or HETATM record is damaged; a residue such as a water may have a number that is too large."""
    if len(line) < MIN_WIDTH:
        raise InputError(
            f"Line {line_number} of {FILE} is cut short: copy the file again or repair the line."
        )
    if not all(map(PDB_NUMBER.fullmatch, (line[30:38], line[38:46], line[46:54]))):
        raise InputError(
            f"Line {line_number} of {FILE} has no readable coordinates ('{line[30:54].strip()}'): repair the line."
        )
    if line[22:26] == NUMBER_TOO_LARGE and known_kind(line[17:20].strip()) in LINKAGES:
        raise InputError(
            f"Line {line_number} of {FILE} has a residue whose number is {NUMBER_TOO_LARGE}: write the structure with numbers "
            "up to 9999 in each chain, or as mmCIF."
        )
    if not in_columns:
        raise InputError(
            f"Line {line_number} of {FILE} is not in the columns of a PDB file: repair the line."
        )


@cache
def _segid(columns: str) -> str:
    """Return the word in columns 73 to 76; empty if it is a part of what begins before, such as a charge, or a decimal number."""
    word = columns[6:].strip()
    inside = bool(columns[5:6].strip() and columns[6:7].strip())
    return "" if inside or " " in word or re.fullmatch(r"[-+]?\d*\.\d*", word) else word


@cache
def _element(columns: str, behind: str) -> str:
    """Return the element in columns 77 and 78, in upper case; empty if it is none. PDBQT has the type of the atom one further."""
    if columns[:1] in ("", " ") and behind.isalpha():
        kind = columns.strip() + behind
        return AUTODOCK.get(kind, kind.upper() if gemmi.Element(kind).name != "X" else "")
    symbol = columns.strip().upper()
    return symbol if symbol in NO_ELEMENTS or (symbol.isalpha() and gemmi.Element(symbol).name != "X") else ""


def _has_wide_chains(text: Callable[[int, int], np.ndarray]) -> bool:
    """Return whether column 21 belongs to a chain id of two letters; else it belongs to a residue name of four.

    A chain has residues of several names, and a letter that ends a name of four stands behind one of three only. `text`
    returns what stands between two columns of each atom's line.
    """
    has_letter = np.char.strip(text(20, 21)) != ""
    if (has_letter & (text(17, 18) == LONG_NAME)).any():
        return True
    standard = np.isin(np.char.strip(text(17, 20)), [*HEAVY_ATOMS])
    odd = standard & has_letter & ~np.isin(np.char.strip(text(17, 21)), [*FOUR_LETTER_NAMES])
    chains = Counter(
        chain for chain, _ in {*zip(text(20, 22)[odd].tolist(), text(17, 20)[odd].tolist(), strict=True)}
    )
    return bool(chains) and (not (standard & ~has_letter).any() or max(chains.values()) > 1)


def _model_number(line: str, used: Iterable[int]) -> int:
    """Return the number of the next model: the one of the record if no other has it, else the next free one."""
    next_free = max(used, default=0) + 1
    number = line[6:14].strip() if line.startswith("MODEL ") else ""
    if not number.isdecimal():
        return next_free
    if int(number) in used:
        message = "%s has several models of the number %s: the later one is called %d"
        log.warning(message, FILE, number, next_free)
        return next_free
    return int(number)


def _box(line: str) -> np.ndarray | None:
    """Return the lattice vectors of a CRYST1 record."""
    values = [line[6:15], line[15:24], line[24:33], line[33:40], line[40:47], line[47:54]]
    return box_vectors(*map(float, values)) if all(map(PDB_NUMBER.fullmatch, values)) else None


def _crosslinked(line: str) -> set[tuple[str, str]]:
    """Return chain and label of the two residues of a LINK record, if both belong to a polymer."""
    ends = [line[17:27], line[47:57]]
    if all(standard_name(end[:3].strip()) in HEAVY_ATOMS for end in ends):
        return {(end[4].strip(), end[5:].strip()) for end in ends}
    return set()


def _is_damaged_atom(line: str) -> bool:
    """Return whether a line is an atom with a damaged record name: another name, a part of it, or one with a tab."""
    if line.startswith(("ATOM\t", "HETATM\t")):
        return True
    if line[34:35] + line[42:43] + line[50:51] == "..." and not line.startswith(("REMARK", "SIGATM")):
        return all(map(PDB_NUMBER.fullmatch, (line[30:38], line[38:46], line[46:54])))
    return 0 < len(line) < 6 and any(record.startswith(line) for record in ATOM_RECORDS)


def _check_end(
    lines: list[str],
    last_atom: int,
    atoms: AtomTable,
    sequences: dict[str, list[str]],
) -> None:
    """Raise InputError if a file stops within its last atom, or without an END before its sequence is complete."""
    last, before = lines[last_atom - 1].rstrip(), lines[last_atom - 2].rstrip()
    no_newline = last_atom == len(lines)
    if no_newline and before.startswith(ATOM_RECORDS) and len(last) < len(before):
        raise InputError(f"{FILE} is cut short: it stops in the middle of an atom; copy it again.")
    ended = any(line[:6].strip() in AFTER_ATOMS for line in lines[last_atom:])
    if not ended and any(line.startswith("MODEL ") for line in lines):
        numbers, counts = np.unique(atoms.model, return_counts=True)
        if len(numbers) > 1 and (atoms.model == atoms.model[-1]).sum() < counts.max():
            raise InputError(f"{FILE} is cut short: its last MODEL has no ENDMDL; copy it again.")
        log.warning("%s: its last MODEL has no ENDMDL; is the file cut short?", FILE)
    missing = missing_residues(atoms, sequences)
    if missing and not ended:
        present, expected = (sum(counts) for counts in zip(*missing.values(), strict=True))
        raise InputError(
            f"{FILE} has {present} of the {expected} residues that its SEQRES records announce and no END "
            "record: copy it again, or add END if it is complete."
        )


def write_pdb(
    path: StrPath,
    xyz: np.ndarray,
    atoms: AtomsLike,
    b_factor: np.ndarray | None = None,
    remarks: Sequence[str] = (),
) -> None:
    """Write one model, xyz (A, 3) in Å: ATOM and HETATM lines, TER after each chain, END; the same bytes for the same input.

    Chain ids of more than two letters do not fit: they are renamed, with a warning. Residue names that do not fit get
    three letters, and the names stand in HETNAM records.
    """
    chains = _short_chain_ids(atoms.chain)
    b_factor = np.zeros(len(xyz)) if b_factor is None else b_factor
    width = max(map(len, chains))
    # four letters reach into column 21
    short_names = _short_residue_names(atoms.residue_name, 5 - max(width, 1))
    lines = [f"REMARK   6 {line}\n" for line in remarks]
    lines += [f"HETNAM     {short:60s}{name[:LONGEST_NAME]}\n" for name, short in short_names.items()]
    for i, position in enumerate(xyz):
        record = "ATOM  " if atoms.kind[i] in ("protein", "nucleic") else "HETATM"
        name, symbol = atoms.name[i], atoms.element[i]
        name = f"{name:4.4s}" if len(name) > 3 or len(symbol) > 1 else f" {name:<3s}"
        residue_name = short_names.get(atoms.residue_name[i], atoms.residue_name[i])
        residue = f"{residue_name:>3s}"
        residue += f"{chains[i]:>{5 - len(residue)}s}{encode_label(atoms.residue[i])}"
        numbers = f"{pdb_position(position)}  1.00{b_factor[i]:6.2f}"
        lines.append(f"{record}{(i + 1) % 100_000:5d} {name} {residue}   {numbers}          {symbol:>2.2s}\n")
        if i + 1 == len(xyz) or atoms.chain[i + 1] != atoms.chain[i]:
            lines.append("TER\n")
    Path(path).write_text("".join([*lines, "END\n"]), encoding="latin-1", errors="replace")


def pdb_position(position: np.ndarray) -> str:
    """Return a position (3,), Å, in the 24 columns of a PDB file; a large number has two decimals in place of three."""
    columns = [f"{x:8.3f}"[:8] for x in position]
    if any(column[-3] != "." and column[-4] != "." for column in columns):
        x, y, z = position
        raise InputError(
            f"the position ({x:.3f}, {y:.3f}, {z:.3f}) Å does not fit into a PDB file, which holds -9999.99 to 99999.99 Å: move "
            "the atoms to the origin, or write another format."
        )
    return "".join(columns)


def pdb_b_factor(values: np.ndarray) -> np.ndarray:
    """Return numbers as the nearest ones that fit into the B factors of a PDB file, 0 for NaN."""
    return np.clip(np.nan_to_num(values), MIN_B_FACTOR, MAX_B_FACTOR)


def _short_residue_names(residue_name: np.ndarray, width: int) -> dict[str, str]:
    """Return three letters for each residue name that is too long: '~' and the last two, or the first that are free."""
    names = dict.fromkeys(map(str, residue_name))
    short: dict[str, str] = {}
    for name in names:
        if len(name) > width:
            free = (LONG_NAME + "".join(pair) for pair in product(ascii_uppercase + digits, repeat=2))
            used = {*names, *short.values()}
            short[name] = next(code for code in (LONG_NAME + name[-2:], *free) if code not in used)
    return short


def _short_chain_ids(chain: np.ndarray) -> list[str]:
    """Return the chain id of each atom, with the first free one of A, B, C, ... in place of ids above two letters."""
    ids = list(dict.fromkeys(chain.tolist()))
    long = [chain_id for chain_id in ids if len(chain_id) > 2]
    if not long:
        return chain.tolist()
    renamed = dict(zip(long, (name for name in identifiers() if name not in ids), strict=False))
    names_used = shorten(", ".join(f"{old} is {new}" for old, new in renamed.items()))
    log.warning(
        "chains whose ids are too long for a PDB file have other names in its results: %s", names_used
    )
    return [renamed.get(chain_id, chain_id) for chain_id in chain.tolist()]


def identifiers() -> Iterator[str]:
    """Yield chain identifiers: A to Z, a to z, 0 to 9, then two letters."""
    letters = ascii_uppercase + ascii_lowercase + digits
    yield from letters
    yield from map("".join, product(letters, repeat=2))


class NumberReader:
    """Read the residue numbers of the lines of a chain in their order, which tells decimal from hexadecimal ones."""

    def __init__(self) -> None:
        self.chain, self.text, self.before, self.number, self.hexadecimal = "", "", 0, "", False

    def __call__(self, text: str, chain: str) -> str | None:
        """Return the number of a field of four characters; None if it is none."""
        if (text, chain) == (self.text, self.chain):
            return self.number
        if chain != self.chain:
            self.before, self.hexadecimal = 0, False
        number = str(int(text, 16)) if self._is_hexadecimal(text) else _decode_number(text)
        if number is not None:
            self.text, self.chain, self.number = text, chain, number
            self.before = int(number or 0)
        return number

    def _is_hexadecimal(self, text: str) -> bool:
        """Return whether a field continues numbers beyond 9999 as VMD does; see also `HYBRID_36`."""
        if self.before < 9999 - MAX_JUMP or not HEXADECIMAL.fullmatch(text):
            return False
        step = int(text, 16) - self.before
        if not self.hexadecimal:
            certain = text[0].isdigit() and not text.isdigit() and int(text, 16) > 9999
            self.hexadecimal = (self.before == 9999 and step == 1) or (certain and 0 < step < MAX_JUMP)
        self.hexadecimal &= step >= 0
        return self.hexadecimal


def _decode_number(text: str) -> str | None:
    """Return the residue number of a field of four characters, decimal or hybrid-36; None if it is neither."""
    if not HYBRID_36.fullmatch(text):
        return text if DECIMAL.fullmatch(text) else None
    return str(int(text, 36) - (FIRST_UPPER if text[0].isupper() else FIRST_LOWER - N_PER_CASE) + 10_000)


def encode_label(label: str) -> str:
    """Return residue number and insertion code in the five characters of a PDB file."""
    number, code = split_label(label)
    if number and not -1000 < int(number) < 10_000 + 2 * N_PER_CASE:
        raise InputError(
            f"residue {number} does not fit into a PDB file, which numbers from -999 to {9_999 + 2 * N_PER_CASE}: renumber it."
        )
    if len(number) > 4:
        above = int(number) - 10_000
        upper = above < N_PER_CASE
        number = np.base_repr(above + (FIRST_UPPER if upper else FIRST_LOWER - N_PER_CASE), 36)
        number = number if upper else number.lower()
    return f"{number:>4s}{code or ' '}"
