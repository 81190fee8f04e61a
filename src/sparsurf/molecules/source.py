"""What a user gives in place of a molecule or dots: a file, recognised once by its content.

A `Source` is made where a path enters the library, and takes the place of the path from there on: functions ask it for its
format, and messages name the file by it. The extension of a name counts only where the content does not tell the format.
"""

from __future__ import annotations

import codecs
import io
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from sparsurf.errors import InputError
from sparsurf.files import (
    StrPath,
    beginning,
    content_of,
    decode_text,
    existing_file,
    packing_of,
    refuse_packed,
)
from sparsurf.molecules.formats import (
    FILE_OF_DOTS,
    FORMAT_OF_SUFFIX,
    MOLECULE_FORMATS,
    MoleculeFormat,
    suffix,
)

HEAD_BYTES = 2**14  # The start of a file, which holds the title and the first atom in every text format.
# Records with which a PDB file begins
PDB_RECORDS = frozenset(
    ["ATOM", "HETATM", "HEADER", "OBSLTE", "TITLE", "SPLIT", "CAVEAT", "COMPND", "SOURCE", "KEYWDS", "EXPDTA", "NUMMDL",
     "AUTHOR", "REMARK", "JRNL", "DBREF", "SEQRES", "HELIX", "SHEET", "CRYST1", "ORIGX1", "SCALE1", "MODEL", "USER", "PARENT"]
)  # fmt: skip
PDB_TITLES = frozenset(["TITLE", "COMPND", "SOURCE", "AUTHOR", "REMARK", "MODEL", "USER", "PARENT", "SPLIT"])
# How a checkpoint of GROMACS begins, and the name of the first block of TNG within its first bytes
CHECKPOINT, TNG, TNG_BYTES = (171_817).to_bytes(4, "big"), b"GENERAL INFO", 100
# Blocks with which a GROMOS96 file begins, behind its title
BLOCK_OF_GROMOS = re.compile(r"^(POSITION|POSITIONRED|TIMESTEP)[ \t]*$", re.MULTILINE)
LINES_OF_SPHERES = 10  # So many lines tell spheres from other tables.
WORD_OF_A_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
LINE_OF_A_COUNT = re.compile(r"\s*\d+\s*")
COUNT_OF_CARD = re.compile(r"\s*\d+(\s+EXT)?\s*", re.IGNORECASE)
COUNT_OF_RESTART = re.compile(r"\s*\d+(\s+[-+]?\d+\.\d*([eE][-+]?\d+)?)*\s*")
ATOM_OF_GRO = re.compile(r"[ \d]{4}\d.{10}.{5}\s*-?\d+\.\d+\s*-?\d+\.\d+\s*-?\d+\.\d+")
ATOM_OF_XYZ = re.compile(r"\s*\S+(\s+[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?){3,}")
LINE_OF_NUMBERS = re.compile(r"[-+\d. eE]*\.[-+\d. eE]*")
# Replica exchange of AMBER writes a line with its state before each frame of an mdcrd file
REPLICA = re.compile(r"(H?REMD|RXSGLD)\s")
ATOMS_OF_LAMMPS = re.compile(r"^[ \t]*\d+[ \t]+atoms[ \t]*$", re.MULTILINE)


@dataclass(frozen=True, eq=False)
class Source(os.PathLike[str]):
    """A file that exists, under the name that the user gave it, with the format that its content has."""

    name: str
    format: MoleculeFormat
    recognised: bool  # by its content, and not by the extension of its name alone
    packing: Any  # the module that reads its compression, or None

    def __str__(self) -> str:
        return self.name

    def __fspath__(self) -> str:
        return self.name

    def text(self) -> str:
        """Return the text of the file."""
        return decode_text(content_of(Path(self.name)))

    @contextmanager
    def lines(self) -> Iterator[IO[str]]:
        """Open the file to read its lines one after another, each ending in a line feed."""
        with open(self.name, "rb") as stored:
            unpacked: Any = self.packing.open(stored) if self.packing else stored
            if unpacked.peek(len(codecs.BOM_UTF8)).startswith(codecs.BOM_UTF8):
                unpacked.read(len(codecs.BOM_UTF8))
            # a title may be in any encoding, and numbers are the same in all
            with io.TextIOWrapper(unpacked, encoding="latin-1", newline=None) as lines:
                yield lines


def open_source(path: StrPath | Source) -> Source:
    """Return the file at a path with its format; raise InputError if there is no such file, or if no program here reads it."""
    if isinstance(path, Source):
        return path
    try:
        existing_file(path)
    except InputError:
        if _is_folder_of_desmond(path):
            raise InputError(f"{path} {MOLECULE_FORMATS['desmond'].refusal}.") from None
        raise
    name = os.fspath(path)
    with open(name, "rb") as stored:
        head, size = stored.read(HEAD_BYTES), os.fstat(stored.fileno()).st_size
    refuse_packed(name, head)
    packing = packing_of(head)[1]
    if packing:
        head = beginning(name, HEAD_BYTES)
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise InputError(f"{name} is stored as UTF-16: store it as UTF-8.")
    recognised = MOLECULE_FORMATS.get(_recognise(head) or ("namd" if _is_of_namd(head, size) else ""))
    found = recognised or MOLECULE_FORMATS[FORMAT_OF_SUFFIX.get(suffix(name), FILE_OF_DOTS)]
    if found.refusal:
        raise InputError(f"{name} {found.refusal}.")
    return Source(name, found, recognised is not None, packing)


def what_is_no_structure(source: Source, formats: str) -> str:
    """Return the sentence that refuses a file in place of a structure of some formats."""
    try:
        lines = [line.split() for line in source.text().splitlines() if line.strip()][:LINES_OF_SPHERES]
    except InputError:  # no text
        lines = []
    if lines and all(len(line) == 4 and all(map(WORD_OF_A_NUMBER.fullmatch, line)) for line in lines):
        return (
            f"{source} holds four numbers in each line, as files of spheres do (x, y, z and radius in Å), which are known by "
            "their name: rename it so that it ends in .xyzr."
        )
    return f"{source} is not a structure by its content: give {formats}."


def _is_folder_of_desmond(path: StrPath) -> bool:
    """Return whether a folder holds a trajectory of Desmond, which is a folder of frames."""
    return isinstance(path, str | os.PathLike) and os.path.isfile(os.path.join(path, "clickme.dtr"))


def _is_of_namd(head: bytes, size: int) -> bool:
    """Return whether a file is as long as its first number says: the atoms of NAMD's binary coordinates, 24 bytes each."""
    numbers = int.from_bytes(head[:4], "little"), int.from_bytes(head[:4], "big")
    return size > 4 and size in (4 + 24 * number for number in numbers)


def _recognise(head: bytes) -> str:
    """Return the name of the format of molecules that a file begins as; empty for any other content."""
    if head.startswith(b"CDF\x05"):
        return "cdf5"
    if head.startswith((b"CDF\x01", b"CDF\x02")):
        return "ncrst" if b"AMBERRESTART" in head else "netcdf"
    if head.startswith(b"\x89HDF\r\n\x1a\n"):
        if b"h5md" in head:
            return "h5md"
        return "netcdf4" if b"DIMENSION_SCALE" in head or b"_NCProperties" in head else "hdf5"
    if head[:4] in (b"\0\0\x07\xcb", b"\0\0\x07\xe7"):
        return "xtc"
    if head.startswith(b"\0\0\x07\xc9"):
        return "trr"
    if head[4:8] == b"CORD" or head[8:12] == b"CORD":
        return "dcd"
    if b"VERSION " in head[:24] and b"\0" in head[:4]:
        return "tpr"
    if head.startswith(CHECKPOINT):
        return "cpt"
    if TNG in head[:TNG_BYTES]:
        return "tng"
    if head.startswith((b"DESM", b"DESK")) or b"s_m_m2io_version" in head[:200]:
        return "desmond"
    if b"\0" in head:
        return ""
    text = head.removeprefix(codecs.BOM_UTF8).decode("latin-1")
    return _recognise_text(text.replace("\r\n", "\n").replace("\r", "\n"))


def _recognise_text(text: str) -> str:
    """Return the name of the format that a text begins as; empty for any other."""
    lines = text.split("\n")  # not `splitlines`, for which the second byte of Å in UTF-8 ends a line
    first = ""
    for line in lines:  # the first one that is neither empty nor a comment of mmCIF
        first = line.lstrip()
        if first and not first.startswith("#"):
            break
    if first.lower().startswith(("data_", "loop_")):
        return "mmcif"
    if text.startswith("PSF"):
        return "psf"
    if first.strip() == "TITLE" and BLOCK_OF_GROMOS.search(text):
        return "g96"
    if first.startswith(("%VERSION", "%FLAG")):
        return "parm7"
    if first.startswith("ITEM:"):
        return "lammps dump"
    if ATOMS_OF_LAMMPS.search(text) and ("xlo xhi" in text or "avec" in text):
        return "lammps data"
    if lines and lines[0].startswith("*"):
        count = next((line for line in lines if not line.startswith("*")), "")
        if COUNT_OF_CARD.fullmatch(count):
            return "card"
    record = first[:6].strip()
    if record in PDB_RECORDS and (
        record not in PDB_TITLES or (lines[1:] and lines[1][:6].strip() in PDB_RECORDS)
    ):
        return "pdb"
    # the title of another format may begin as a record of PDB does
    return _recognise_columns(lines) or ("pdb" if record in PDB_TITLES else "")


def _recognise_columns(lines: list[str]) -> str:
    """Return the name of the format of lines of numbers in columns; empty if they have none of the known ones."""
    if len(lines) < 3:
        return ""
    _, second, third = lines[:3]
    second = third if REPLICA.match(second) else second
    dots = [place for place, letter in enumerate(third) if letter == "."]
    if LINE_OF_A_COUNT.fullmatch(second) and ATOM_OF_GRO.match(third):
        return "gro"
    if COUNT_OF_RESTART.fullmatch(second) and LINE_OF_NUMBERS.fullmatch(third) and dots[:2] in ([4], [4, 16]):
        return "inpcrd"
    if LINE_OF_A_COUNT.fullmatch(lines[0]) and ATOM_OF_XYZ.match(third):
        return "xyz"
    dots = [place for place, letter in enumerate(second) if letter == "."]
    in_columns = len(dots) > 1 and all(place % 8 == 4 for place in dots)
    return "mdcrd" if in_columns and LINE_OF_NUMBERS.fullmatch(second) else ""
