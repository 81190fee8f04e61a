"""Read text files of atoms: GRO, XYZ, AMBER's mdcrd and restart files, CHARMM CARD, LAMMPS dumps and data, PDB and mmCIF.

The reader of a format takes the lines of one frame after another, so that memory does not grow with the file, and yields what
parses them, so that a frame that nobody wants costs little. A frame that the end of the file cuts (`CutShort`) is told from a
damaged one: it is left out, and the frames before it are read.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple, NoReturn, TypeAlias

import numpy as np

from sparsurf.errors import FILE, InputError
from sparsurf.files import shorten
from sparsurf.molecules.atom_table import AtomFile, atom_table, box_vectors
from sparsurf.molecules.mmcif import read_mmcif
from sparsurf.molecules.pdb import read_pdb
from sparsurf.molecules.source import REPLICA, Source

ANGSTROM_PER_NM = 10.0
COLUMNS_OF_GRO = 20, 4  # the first of the coordinates, and those of a number besides its decimals
BOX_OF_GRO = re.compile(r"-?\d+\.\d{5}")  # GROMACS writes five decimals
TIME_OF_GRO = re.compile(r"\bt *= *([-+]?\d+\.?\d*(?:[eE][-+]?\d+)?)")
# mdcrd has a title, then ten numbers of eight characters per line; a restart file six of twelve. Each frame, and each box,
# begins a new line.
MDCRD, RESTART = (10, 8), (6, 12)
# Columns of a CARD line: residue, its name, the atom's name, three coordinates, segment, label of the residue
CARD = ((5, 10), (11, 15), (16, 20), (20, 30), (30, 40), (40, 50), (51, 55), (56, 60))
EXTENDED_CARD = ((10, 20), (22, 30), (32, 40), (40, 60), (60, 80), (80, 100), (102, 110), (112, 120))
MAX_ATOMS_OF_CARD = 100_000  # more are always written in the wide columns
RESIDUE_OF_CARD = re.compile(r"-?\d+[A-Za-z]?")
# Keys of the comment of an extended XYZ frame, see https://github.com/libAtoms/extxyz
KEY_OF_XYZ = re.compile(r"""(\w+)=(?:"([^"]*)"|'([^']*)'|([^\s"']+))""")
# Columns of a LAMMPS dump that hold positions, the first that a file has is used, and whether they are shares of the box
LAMMPS_POSITIONS = (("x y z", False), ("xu yu zu", False), ("xs ys zs", True), ("xsu ysu zsu", True))
# Columns before x in the section Atoms of a LAMMPS data file, by the style of its atoms
BEFORE_X = {
    "atomic": 2, "bond": 3, "angle": 3, "molecular": 3, "charge": 3, "full": 4, "dipole": 3, "sphere": 4, "ellipsoid": 4,
}  # fmt: skip
SIDES, VECTORS, TILT = ("xlo xhi", "ylo yhi", "zlo zhi"), ("avec", "bvec", "cvec"), "xy xz yz"
HEADER_OF_DATA = (*SIDES, *VECTORS, TILT)  # ends of lines of such a file that hold its box


class TextFrame(NamedTuple):
    """A frame of a text file."""

    xyz: np.ndarray  # (A, 3), Å
    time_ps: float = np.nan
    box: np.ndarray | None = None  # (3, 3), Å, lattice vectors as rows


TextFrames: TypeAlias = Iterator[Callable[[], TextFrame]]
Columns: TypeAlias = Sequence[tuple[int, int]]


class CutShort(Exception):
    """The end of the file cuts a frame."""


class Lines:
    """Lines of a file with their numbers, for messages; the next one is known."""

    def __init__(self, lines: Iterator[str]) -> None:
        self.lines, self.number, self.ahead, self.unterminated = lines, 0, next(lines, None), False

    def next(self) -> str:
        """Return the next line without its end; raise CutShort behind the last one."""
        if self.ahead is None:
            raise CutShort
        line, self.ahead, self.number = self.ahead, next(self.lines, None), self.number + 1
        self.unterminated = not line.endswith("\n")
        return line.removesuffix("\n")

    def take(self, number: int) -> list[str]:
        """Return some lines."""
        return [self.next() for _ in range(number)]

    def at_end(self) -> bool:
        """Skip empty lines, and return whether nothing follows."""
        while self.ahead is not None and not self.ahead.strip():
            self.next()
        return self.ahead is None

    def end_cuts(self, row: str) -> bool:
        """Return whether the end of the file cuts its last line: it has no line feed, and its last number fewer decimals."""
        decimals = {len(number.partition(".")[2]) for number in row.split()[-2:]}
        return self.unterminated and self.ahead is None and len(decimals) > 1

    def count(self, text: str, advice: str) -> int:
        """Return the number of atoms that a line holds."""
        if not text.strip().isdecimal() or not int(text):
            self.refuse(f"is not the number of atoms, {shorten(repr(text.strip()))}: {advice}")
        return int(text)

    def refuse(self, problem: str, number: int | None = None) -> NoReturn:
        """Raise InputError with the number of a line, by default of the last one."""
        raise InputError(f"{FILE}: line {self.number if number is None else number} {problem}.")

    def numbers(self, rows: Sequence[str], begin: int, parse: Callable[[str], list[float]]) -> np.ndarray:
        """Return the numbers that `parse` finds in each of the rows that follow the line `begin`, (A, n)."""
        values = []
        for k, row in enumerate(rows, begin + 1):
            try:
                values.append(parse(row))
            except (ValueError, IndexError):
                self.refuse("has no three coordinates: repair the line", k)
        return np.array(values, float)

    def order_of(self, rows: Sequence[str], begin: int, column: int) -> np.ndarray:
        """Return the order of rows (A,) by the ids of their atoms, which must differ."""
        number = self.numbers(rows, begin, words_at([column]))[:, 0]
        order = np.argsort(number, kind="stable")
        repeated = np.flatnonzero(np.diff(number[order]) == 0)
        if len(repeated):
            problem = f"has the id {number[order][repeated[0]]:g} of another atom of its frame: write the frames again"
            self.refuse(problem, begin + int(order[repeated[0] + 1]) + 1)
        return order


def words_at(columns: Sequence[int]) -> Callable[[str], list[float]]:
    """Return what finds the numbers at some places among the words of a line."""
    return lambda row: [float(parts[column]) for parts in [row.split()] for column in columns]


def numbers_of(text: str, width: int = 0) -> list[float]:
    """Return the numbers of a string, in columns of a width or as words that a minus may join; none if one is no number."""
    text = text.rstrip()
    columns = [text[k : k + width] for k in range(0, len(text), width)] if width else []
    try:
        return [float(word) for word in columns or re.sub(r"(?<=[\d.])-", " -", text).split()]
    except ValueError:
        return []


# ---- GRO


def frames_of_gro(lines: Lines, _n_atoms: int = 0) -> TextFrames:
    """Yield the frames of a GRO file: title, number of atoms, atoms in columns, box."""
    while lines.ahead is not None:
        title, first = lines.next(), lines.number == 1
        if not title.strip() and lines.at_end():
            return
        n_atoms = lines.count(lines.next() if lines.ahead else "", "give a GRO file")
        begin, rows = lines.number, lines.take(n_atoms)
        box = lines.next() if lines.ahead else ""
        numbers = numbers_of(box) or [*map(float, BOX_OF_GRO.findall(box))]  # of a wide box, they touch
        if len(numbers) not in (3, 9):
            if not first:
                raise CutShort
            lines.refuse("is not a box of 3 or 9 numbers: add it, or zeros", begin + n_atoms + 1)
        yield partial(_frame_of_gro, lines, rows, begin, title, numbers)


def _frame_of_gro(lines: Lines, rows: list[str], begin: int, title: str, numbers: list[float]) -> TextFrame:
    """Return a frame of a GRO file, nm; its columns are as wide as the distance between two decimal points."""

    def parse(row: str) -> list[float]:
        text = row[COLUMNS_OF_GRO[0] :]
        width = text.find(".", text.find(".") + 1) - text.find(".")
        try:
            return [float(text[column : column + width]) for column in (0, width, 2 * width)]
        except ValueError:
            found = numbers_of(text)
            if width <= COLUMNS_OF_GRO[1] or len(found) not in (3, 6):
                raise
            return found[:3]

    xyz, box = ANGSTROM_PER_NM * lines.numbers(rows, begin, parse), ANGSTROM_PER_NM * np.diag(numbers[:3])
    if len(numbers) == 9:
        box[[0, 0, 1, 1, 2, 2], [1, 2, 0, 2, 0, 1]] = ANGSTROM_PER_NM * np.array(numbers[3:])
    times = TIME_OF_GRO.findall(title)
    return TextFrame(xyz, float(times[-1]) if times else np.nan, box if box.any() else None)


def read_gro(source: Source) -> AtomFile:
    """Read the atoms of the first frame of a GRO file; raise InputError, with the line, where it violates the columns."""
    frame, (_, rows, begin, *_) = _first_frame(source, frames_of_gro)
    numbers = [row[:5].strip() for row in rows]
    wrong = next((k for k, number in enumerate(numbers) if not number.removeprefix("-").isdecimal()), None)
    if wrong is not None:
        raise InputError(
            f"{FILE}: line {begin + wrong + 1} is not in the columns of a GRO file: repair the line."
        )
    names = {
        "residue_name": [row[5:10].strip() for row in rows],
        "name": [row[10:15].strip() for row in rows],
    }
    labels = names | {"residue": [str(int(number)) for number in numbers]}
    return AtomFile(atom_table(**labels, **dict(zip("xyz", frame.xyz.T, strict=True))), frame.box)


def _first_frame(source: Source, frames: Callable[[Lines], TextFrames]) -> tuple[TextFrame, tuple[Any, ...]]:
    """Return the first frame of a file that also names its atoms, and what it was parsed from."""
    with source.lines() as stream:
        try:
            parse: Any = next(frames(Lines(stream)))
        except (CutShort, StopIteration):
            raise InputError(f"{FILE} is cut short within its first frame: copy it again.") from None
        return parse(), parse.args


# ---- XYZ


def frames_of_xyz(lines: Lines, _n_atoms: int) -> TextFrames:
    """Yield the frames of an XYZ file: number of atoms, comment, an atom in each line; also of extended XYZ."""
    while not lines.at_end():
        n_atoms = lines.count(lines.next(), "an XYZ file begins each frame with it")
        comment, begin = lines.next(), lines.number
        rows = lines.take(n_atoms)
        if lines.end_cuts(rows[-1]):
            raise CutShort
        yield partial(_frame_of_xyz, lines, rows, comment, begin)


def _frame_of_xyz(lines: Lines, rows: Sequence[str], comment: str, begin: int) -> TextFrame:
    """Return a frame of an XYZ file; `Properties` in its comment names the columns, `Lattice` the cell, `pbc` its directions."""
    keys = {
        match[1].lower(): match[2] or match[3] or match[4] or "" for match in KEY_OF_XYZ.finditer(comment)
    }
    first, id_column = 1, None
    if "properties" in keys:  # name:type:number:name:...
        parts, columns, column = keys["properties"].split(":"), dict[str, tuple[int, int]](), 0
        for name, size in zip(parts[::3], parts[2::3], strict=False):
            columns[name.lower()] = column, int(size) if size.isdecimal() else 0
            column += columns[name.lower()][1]
        first, n_numbers = columns.get("pos", (0, 0))
        if n_numbers != 3:
            problem = f"names the columns {keys['properties']}, and no pos:R:3: write positions of this name"
            lines.refuse(problem, begin)
        id_column = columns.get("id", (None, 0))[0]
    box = None
    if "lattice" in keys and set("Tt1") & set(keys.get("pbc", "T")):
        numbers = numbers_of(keys["lattice"])
        if len(numbers) != 9:
            lines.refuse(f"has a Lattice of {len(numbers)} numbers: write the nine of three vectors", begin)
        box = np.array(numbers).reshape(3, 3)
    xyz = lines.numbers(rows, begin, words_at(range(first, first + 3)))
    return TextFrame(xyz if id_column is None else xyz[lines.order_of(rows, begin, id_column)], box=box)


# ---- AMBER


def frames_of_mdcrd(lines: Lines, n_atoms: int) -> TextFrames:
    """Yield the frames of an mdcrd file: coordinates, and a box of three lengths if the first frame has one."""
    lines.next()  # the title
    per_line, width = MDCRD
    n_lines = -(-3 * n_atoms // per_line)
    boxed: bool | None = None
    while not lines.at_end():
        if REPLICA.match(lines.ahead or ""):
            lines.next()
        begin, rows, box = lines.number, lines.take(n_lines), ""
        if boxed is None:
            boxed = n_lines > 1 and len(numbers_of(lines.ahead or "")) == 3
        if boxed:
            box = lines.next()
        cut_at_end = lines.unterminated and lines.ahead is None and not box and len(rows[-1].rstrip()) % width
        if (boxed and len(numbers_of(box)) != 3) or cut_at_end or lines.end_cuts(box):
            raise CutShort
        vectors = None
        if box:
            a, b, c = numbers_of(box)
            vectors = box_vectors(a, b, c, 90.0, 90.0, 90.0)
        yield partial(_frame_of_columns, lines, rows, width, n_atoms, begin, vectors)


def frames_of_restart(lines: Lines, _n_atoms: int) -> TextFrames:
    """Yield the one frame of a restart file: number of atoms, coordinates, velocities and box where it has them."""
    lines.next()  # the title
    n_atoms = lines.count((lines.next().split() or [""])[0], "give an AMBER restart file")
    per_line, width = RESTART
    n_lines, begin = -(-n_atoms * 3 // per_line), lines.number
    rows = lines.take(n_lines)
    if lines.end_cuts(rows[-1]):
        raise CutShort
    following = []
    while not lines.at_end():
        following.append(lines.next())
    following = following[n_lines:] if len(following) >= n_lines else following  # the velocities
    numbers = [number for line in following for number in numbers_of(line, width)]
    boxed = len(numbers) in (3, 6) and n_atoms > 2
    box = box_vectors(*[*numbers, 90.0, 90.0, 90.0][:6]) if boxed else None
    yield partial(_frame_of_columns, lines, rows, width, n_atoms, begin, box)


def _frame_of_columns(
    lines: Lines, rows: Sequence[str], width: int, n_atoms: int, begin: int, box: np.ndarray | None
) -> TextFrame:
    """Return a frame from lines of columns of one width, which follow the line `begin`."""
    values: list[float] = []
    for k, row in enumerate(rows, begin + 1):
        found = numbers_of(row, width) or numbers_of(row)
        if not found:
            lines.refuse("holds no coordinates: repair the line", k)
        values += found
    if len(values) != 3 * n_atoms:
        raise InputError(
            f"{FILE} has {len(values)} coordinates in the frame from line {begin + 1} on, and {n_atoms} atoms need "
            f"{3 * n_atoms}: give the topology that the trajectory was written with."
        )
    return TextFrame(np.array(values).reshape(-1, 3), box=box)


# ---- CHARMM


def frames_of_card(lines: Lines, _n_atoms: int = 0) -> TextFrames:
    """Yield the one frame of a CARD file: a title behind asterisks, number of atoms, atoms in columns."""
    line = lines.next()
    while line.startswith("*"):
        line = lines.next()
    header = line.upper().split()
    n_atoms = lines.count(header[0] if header else "", "give a CARD file of CHARMM")
    columns = EXTENDED_CARD if "EXT" in header or n_atoms >= MAX_ATOMS_OF_CARD else CARD
    begin, rows = lines.number, lines.take(n_atoms)
    if not lines.at_end():
        problem = f"follows the {n_atoms} atoms that the file announces: correct their number"
        lines.refuse(problem, lines.number + 1)
    yield partial(_frame_of_card, lines, rows, begin, columns)


def _frame_of_card(lines: Lines, rows: list[str], begin: int, columns: Columns) -> TextFrame:
    """Return the frame of a CARD file."""
    places = columns[3:6]
    return TextFrame(lines.numbers(rows, begin, lambda row: [float(row[a:b]) for a, b in places]))


def read_card(source: Source) -> AtomFile:
    """Read the atoms of a CARD file; raise InputError, with the line, where it violates the columns."""
    frame, (_, rows, begin, columns) = _first_frame(source, frames_of_card)
    fields = [[row[first:last].strip() for first, last in columns] for row in rows]
    number, residue_name, name, *_, segid, label = map(list, zip(*fields, strict=True))
    labels = [of_segment or of_file for of_segment, of_file in zip(label, number, strict=True)]
    wrong = next((k for k, text in enumerate(labels) if not RESIDUE_OF_CARD.fullmatch(text)), None)
    if wrong is not None:
        raise InputError(f"{FILE}: line {begin + wrong + 1} has no number of a residue: repair the line.")
    unit = np.cumsum([before != after for before, after in zip(number[:1] + number, number, strict=False)])
    names = {"name": name, "residue_name": residue_name, "chain": segid, "segid": segid, "residue": labels}
    return AtomFile(atom_table(**names, unit=unit, **dict(zip("xyz", frame.xyz.T, strict=True))))


# ---- LAMMPS


def frames_of_dump(lines: Lines, _n_atoms: int) -> TextFrames:
    """Yield the frames of a LAMMPS dump, sections that begin with ITEM, with the atoms in the order of their ids."""
    sections: dict[str, tuple[list[str], list[str]]] = {}
    while not lines.at_end():
        mark, _, name = lines.next().partition(":")
        if mark != "ITEM":
            lines.refuse("stands where an ITEM is expected: repair the line")
        section, *columns = name.split() or [""]
        if section != "ATOMS":
            sections[section] = columns, lines.take(3 if section == "BOX" else 1)
            continue
        announced = sections.get("NUMBER", ([], [""]))[1][0]
        n_atoms, begin = lines.count(announced, "repair its section NUMBER OF ATOMS"), lines.number
        rows = lines.take(n_atoms)
        last = [row.split() for row in rows[-2:]]
        at_end = lines.unterminated and lines.ahead is None
        if lines.end_cuts(rows[-1]) or (at_end and len(last[-1]) < len(last[0])):
            raise CutShort
        box = sections.get("BOX", ([], []))
        yield partial(_frame_of_dump, lines, rows, columns, "abc" in box[0], box[1], begin)


def _frame_of_dump(
    lines: Lines, rows: Sequence[str], columns: list[str], general: bool, bounds: Sequence[str], begin: int
) -> TextFrame:
    """Return a frame of a LAMMPS dump with these columns; each bound of a general box is a lattice vector and an origin."""
    found = [position for position in LAMMPS_POSITIONS if {*position[0].split()} <= {*columns}]
    if not found:
        problem = f"names the columns {', '.join(columns)}, and no x, y and z: write them with `dump ... id type x y z`"
        lines.refuse(problem, begin)
    names, scaled = found[0]
    numbers = [numbers_of(line) for line in bounds]
    if len(numbers) != 3 or any(len(row) not in ((4,) if general else (2, 3)) for row in numbers):
        lines.refuse("is not preceded by the three lines of a box: repair the section BOX BOUNDS")
    if general:
        box, origin = np.split(np.array(numbers), [3], axis=1)
    else:  # the bounds are those of the box around the tilted one
        (xlo, xhi, *xy), (ylo, yhi, *xz), (zlo, zhi, *yz) = numbers
        a, b, c = (*xy, *xz, *yz) or (0.0, 0.0, 0.0)
        xlo, xhi = xlo - min(0, a, b, a + b), xhi - max(0, a, b, a + b)
        ylo, yhi = ylo - min(0, c), yhi - max(0, c)
        origin = np.array([xlo, ylo, zlo])
        box = np.array([[xhi - xlo, 0, 0], [a, yhi - ylo, 0], [b, c, zhi - zlo]])
    xyz = lines.numbers(rows, begin, words_at([columns.index(name) for name in names.split()]))
    xyz = origin.ravel() + xyz @ box if scaled else xyz
    order = lines.order_of(rows, begin, columns.index("id")) if "id" in columns else slice(None)
    return TextFrame(xyz[order], box=box)


def frames_of_data(lines: Lines, _n_atoms: int) -> TextFrames:
    """Yield the one frame of a LAMMPS data file, with the atoms in the order of their ids, in the images that it counts."""
    n_atoms, header, parts = 0, dict[str, list[float]](), list[str]()
    while lines.ahead is not None and parts[:1] != ["Atoms"]:
        text, _, comment = lines.next().partition("#")
        parts = text.split()
        if parts[1:] == ["atoms"] and parts[0].isdecimal():
            n_atoms = int(parts[0])
        line = " ".join(parts)
        marks = [mark for mark in HEADER_OF_DATA if line.endswith(f" {mark}")]
        header |= {mark: numbers_of(line.removesuffix(mark)) for mark in marks}
    if parts[:1] != ["Atoms"] or not n_atoms:
        raise InputError(f"{FILE} has no section Atoms: give a LAMMPS data file with atoms.")
    style = comment.strip()
    if style and style not in BEFORE_X:
        styles = ", ".join(BEFORE_X)
        lines.refuse(f"announces atoms of the style {style}: write them in one of the styles {styles}")
    lines.next()  # an empty line
    begin = lines.number
    rows = [row.partition("#")[0] for row in lines.take(n_atoms)]
    # without a style, the coordinates are the last three numbers that are no counts of images
    texts = rows[0].split()
    whole = all(re.fullmatch(r"-?\d+", word) for word in texts[-3:])
    first = BEFORE_X.get(style, len(texts) - 3 - 3 * (whole and len(texts) > 7))
    xyz, box = lines.numbers(rows, begin, words_at(range(first, first + 3))), _box_of_data(header)
    if box is not None and whole and len(texts) >= first + 6:
        xyz = xyz + lines.numbers(rows, begin, words_at(range(len(texts) - 3, len(texts)))) @ box
    frame = TextFrame(xyz[lines.order_of(rows, begin, 0)], box=box)
    yield lambda: frame


def _box_of_data(header: dict[str, list[float]]) -> np.ndarray | None:
    """Return the lattice vectors (3, 3), Å, of the header of a LAMMPS data file; None without a box."""
    if all(len(header.get(mark, [])) == 3 for mark in VECTORS):
        return np.array([header[mark] for mark in VECTORS])
    if any(len(header.get(mark, [])) != 2 for mark in SIDES):
        return None
    a, b, c = (header[mark][1] - header[mark][0] for mark in SIDES)
    xy, xz, yz = header.get(TILT) or [0.0] * 3
    return np.array([[a, 0, 0], [xy, b, 0], [xz, yz, c]])


# ---- structures


def frames_of_structure(source: Source) -> TextFrames:
    """Yield the models of a structure as frames."""
    file = (read_mmcif if source.format.name == "mmcif" else read_pdb)(source.text())
    for model in dict.fromkeys(file.atoms.model.tolist()):
        yield partial(TextFrame, file.atoms.xyz[file.atoms.model == model], np.nan, file.box_of(model))


TEXT_READERS: dict[str, Callable[[Lines, int], TextFrames]] = {
    "gro": frames_of_gro, "xyz": frames_of_xyz, "mdcrd": frames_of_mdcrd, "inpcrd": frames_of_restart, "card": frames_of_card,
    "lammps dump": frames_of_dump, "lammps data": frames_of_data,
}  # fmt: skip


def frames_of_text(source: Source, n_atoms: int) -> Iterator[Callable[[], TextFrame] | None]:
    """Yield functions that parse the frames of a text file one after another, and None for a cut frame at its end.

    `n_atoms` is the number of atoms of the topology, which an mdcrd file does not hold.
    """
    if source.format.models:
        yield from frames_of_structure(source)
        return
    with source.lines() as stream:
        try:
            yield from TEXT_READERS[source.format.name](Lines(stream), n_atoms)
        except CutShort:
            yield None
