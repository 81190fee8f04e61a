"""Read frames of text files: GRO, XYZ, AMBER's mdcrd and restart files, CHARMM CARD, LAMMPS dumps and data, PDB and mmCIF.

A file is read one frame after another, so that memory does not grow with it. A frame that the end of the file cuts is told
from a damaged one: it is left out, and the frames before it are read.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, NoReturn

import numpy as np

from sparsurf.errors import FILE, InputError
from sparsurf.files import shorten
from sparsurf.molecules.atom_table import box_vectors
from sparsurf.molecules.mmcif import read_mmcif
from sparsurf.molecules.pdb import read_pdb
from sparsurf.molecules.source import REPLICA, Source

ANGSTROM_PER_NM = 10.0
FIRST_COLUMN_OF_GRO = 20  # of the coordinates
DECIMALS_OF_GRO = 5  # columns of a number besides its decimals
BOX_OF_GRO = re.compile(r"-?\d+\.\d{5}")  # GROMACS writes five decimals
TIME_OF_GRO = re.compile(r"\bt *= *([-+]?\d+\.?\d*(?:[eE][-+]?\d+)?)")
# mdcrd has a title, then ten numbers of eight characters per line; a restart file six of twelve. Each frame, and each box,
# begins a new line.
MDCRD, RESTART = (10, 8), (6, 12)
# Columns of a CARD line: serial number, residue, its name, the atom's name, three coordinates, segment, label of the residue
CARD = ((0, 5), (5, 10), (11, 15), (16, 20), (20, 30), (30, 40), (40, 50), (51, 55), (56, 60))
EXTENDED_CARD = ((0, 10), (10, 20), (22, 30), (32, 40), (40, 60), (60, 80), (80, 100), (102, 110), (112, 120))
MAX_ATOMS_OF_CARD = 100_000  # more are always written in the wide columns
# Keys of the comment of an extended XYZ frame
KEY_OF_XYZ = re.compile(r"""(\w+)=(?:"([^"]*)"|'([^']*)'|([^\s"']+))""")
# Columns of a LAMMPS dump that hold positions, the first that a file has is used, and whether they are shares of the box
LAMMPS_POSITIONS = (("x y z", False), ("xu yu zu", False), ("xs ys zs", True), ("xsu ysu zsu", True))
# Columns before x in the section Atoms of a LAMMPS data file, by the style of its atoms
BEFORE_X = {
    "atomic": 2, "bond": 3, "angle": 3, "molecular": 3, "charge": 3, "full": 4, "dipole": 3, "sphere": 4, "ellipsoid": 4,
}  # fmt: skip


class TextFrame(NamedTuple):
    """A frame of a text file."""

    xyz: np.ndarray  # (A, 3), Å
    time_ps: float = np.nan
    box: np.ndarray | None = None  # (3, 3), Å, lattice vectors as rows


# What yields the frames of a file: a function that parses the next one, or None for one that the end of the file cuts
TextFrames = Iterator[Callable[[], TextFrame] | None]


class Lines:
    """Lines of a file with their numbers, for messages."""

    def __init__(self, lines: Iterator[str]) -> None:
        self.stream, self.number, self.ahead = lines, 0, list[str]()
        self.unterminated = False  # the last line has no line feed: the end of the file may have cut it

    def next(self) -> str | None:
        """Return the next line without its end; None behind the last one."""
        line = self.ahead.pop() if self.ahead else next(self.stream, None)
        if line is None:
            return None
        self.number += 1
        self.unterminated = not line.endswith("\n")
        return line.removesuffix("\n")

    def back(self, line: str) -> None:
        """Return a line, which is the next one again."""
        self.ahead.append(line if self.unterminated else line + "\n")
        self.unterminated = False
        self.number -= 1

    def next_filled(self) -> str | None:
        """Return the next line that is not empty; None behind the last one."""
        while (line := self.next()) is not None and not line.strip():
            pass
        return line

    def take(self, number: int) -> list[str] | None:
        """Return some lines; None if the file ends before."""
        lines = [line for _ in range(number) if (line := self.next()) is not None]
        return lines if len(lines) == number else None

    def at_end(self) -> bool:
        """Return whether only empty lines follow."""
        line = self.next_filled()
        if line is not None:
            self.back(line)
        return line is None

    def end_cuts(self) -> bool:
        """Return whether the last line is the last one of the file and has no line feed."""
        return self.unterminated and not self.ahead

    def refuse(self, problem: str, number: int | None = None) -> NoReturn:
        """Raise InputError with the number of a line, by default of the last one."""
        raise InputError(f"{FILE}: line {self.number if number is None else number} {problem}.")


def count_of(lines: Lines, line: str | None, advice: str) -> int:
    """Return the number of atoms that a line holds."""
    if line is None or not line.strip().isdecimal():
        lines.refuse(f"is not the number of atoms, {shorten(repr((line or '').strip()))}: {advice}")
    return int(line)


def numbers_of(text: str) -> list[float]:
    """Return the numbers of a string, of which a minus may join two; none if a word is not a number."""
    try:
        return [float(word) for word in re.sub(r"(?<=[\d.])-", " -", text).split()]
    except ValueError:
        return []


def fixed_columns(text: str, width: int) -> list[float]:
    """Return the numbers of a line of columns of one width; none if a column holds no number."""
    text = text.rstrip()
    columns = [text[k : k + width] for k in range(0, len(text), width)]
    try:
        return [float(word) for word in columns]
    except ValueError:
        return []


def ends_within_a_number(line: str) -> bool:
    """Return whether the last two numbers of a line differ in their decimals, as where the end of a file cuts the last one."""
    decimals = [len(number.partition(".")[2]) for number in line.split()[-2:]]
    return len(set(decimals)) > 1


# ---- GRO


def frames_of_gro(lines: Lines, _n_atoms: int) -> TextFrames:
    """Yield the frames of a GRO file: title, number of atoms, atoms in columns, box."""
    first = True
    while (title := lines.next()) is not None:
        if not title.strip() and lines.at_end():
            return
        n_atoms = count_of(lines, lines.next(), "give a GRO file")
        begin = lines.number
        rows = lines.take(n_atoms)
        if rows is None and first:
            n_found = lines.number - begin
            raise InputError(f"{FILE} is cut short: it has {n_found} of {n_atoms} atoms; copy it again.")
        box = lines.next()
        if first:
            check_box_of_gro(lines, box)
        if rows is None or box is None or not numbers_of_box(box):
            yield None
            return
        first = False
        yield lambda rows=rows, box=box, title=title, begin=begin: TextFrame(  # type: ignore[misc]
            positions_of_gro(lines, rows, begin), time_of_gro(title), box_of_gro(numbers_of_box(box))
        )


def numbers_of_box(text: str) -> list[float]:
    """Return the numbers in the last line of a frame of a GRO file, which touch in a wide box; none if they are not 3 or 9."""
    numbers = numbers_of(text) or [float(word) for word in BOX_OF_GRO.findall(text)]
    return numbers if len(numbers) in (3, 9) else []


def check_box_of_gro(lines: Lines, box: str | None) -> None:
    """Raise InputError if a line is not the box of a GRO file."""
    if box is None or not numbers_of_box(box):
        number = lines.number + (box is None)
        raise InputError(f"{FILE}: line {number} is not a box of 3 or 9 numbers: add it, or zeros.")


def positions_of_gro(lines: Lines, rows: Sequence[str], begin: int) -> np.ndarray:
    """Return positions (A, 3), Å, from the lines of atoms that follow the line `begin`.

    The columns are as wide as the distance between two decimal points.
    """
    xyz = np.empty((len(rows), 3))
    for k, row in enumerate(rows):
        text = row[FIRST_COLUMN_OF_GRO:]
        width = text.find(".", text.find(".") + 1) - text.find(".")
        try:
            xyz[k] = [float(text[column : column + width]) for column in (0, width, 2 * width)]
        except ValueError:
            numbers = numbers_of(text)
            if width <= DECIMALS_OF_GRO - 1 or len(numbers) not in (3, 6):
                lines.refuse("has no three coordinates: repair the line", begin + k + 1)
            xyz[k] = numbers[:3]
    return xyz * ANGSTROM_PER_NM


def time_of_gro(title: str) -> float:
    """Return the time in the title of a frame, ps; nan if it has none."""
    found = TIME_OF_GRO.findall(title)
    return float(found[-1]) if found else np.nan


def box_of_gro(numbers: list[float]) -> np.ndarray | None:
    """Return lattice vectors (3, 3), Å, from the three diagonal elements, and the six others where they are given."""
    box = np.diag(numbers[:3])
    if len(numbers) == 9:
        box[[0, 0, 1, 1, 2, 2], [1, 2, 0, 2, 0, 1]] = numbers[3:]
    return box * ANGSTROM_PER_NM if box.any() else None


# ---- XYZ


def frames_of_xyz(lines: Lines, _n_atoms: int) -> TextFrames:
    """Yield the frames of an XYZ file: number of atoms, comment, an atom in each line; also of extended XYZ."""
    while (line := lines.next_filled()) is not None:
        n_atoms = count_of(lines, line, "an XYZ file begins each frame with it")
        comment, begin = lines.next(), lines.number
        rows = lines.take(n_atoms)
        if comment is None or rows is None:
            yield None
            return
        if lines.end_cuts() and ends_within_a_number(rows[-1]):
            yield None
            return
        yield lambda rows=rows, comment=comment, begin=begin: _frame_of_xyz(lines, rows, comment, begin)  # type: ignore[misc]


def _frame_of_xyz(lines: Lines, rows: Sequence[str], comment: str, begin: int) -> TextFrame:
    """Return a frame of an XYZ file, whose comment stands in the line `begin`."""
    keys = _keys_of_xyz(comment)
    first, number = 1, None
    if "properties" in keys:
        columns = _columns_of_xyz(keys["properties"])
        if columns.get("pos", (0, 0))[1] != 3:
            lines.refuse(
                f"names the columns {keys['properties']}, and no pos:R:3: write positions of this name", begin
            )
        first, number = columns["pos"][0], columns.get("id", (None, 0))[0]
    xyz = _words(lines, rows, range(first, first + 3), begin)
    if number is not None:
        xyz = xyz[_order_of_ids(lines, rows, number, begin)]
    return TextFrame(xyz, box=_lattice_of_xyz(lines, keys, begin))


def _keys_of_xyz(comment: str) -> dict[str, str]:
    """Return the keys of the comment of an extended XYZ frame, in lower case, and their values as text.

    `Properties` names the columns, `Lattice` the cell, `pbc` the directions that are periodic; see
    https://github.com/libAtoms/extxyz.
    """
    return {
        match[1].lower(): match[2] or match[3] or match[4] or "" for match in KEY_OF_XYZ.finditer(comment)
    }


def _columns_of_xyz(properties: str) -> dict[str, tuple[int, int]]:
    """Return the first column and the number of columns of each property, from name:type:number:name:..."""
    parts, columns, first = properties.split(":"), dict[str, tuple[int, int]](), 0
    for name, size in zip(parts[::3], parts[2::3], strict=False):
        columns[name.lower()] = first, int(size) if size.isdecimal() else 0
        first += columns[name.lower()][1]
    return columns


def _lattice_of_xyz(lines: Lines, keys: dict[str, str], begin: int) -> np.ndarray | None:
    """Return the lattice vectors (3, 3), Å, of a frame of extended XYZ; None without one, or if no direction is periodic."""
    if "lattice" not in keys or not set("Tt1") & set(keys.get("pbc", "T")):
        return None
    numbers = numbers_of(keys["lattice"])
    if len(numbers) != 9:
        lines.refuse(f"has a Lattice of {len(numbers)} numbers: write the nine of three vectors", begin)
    return np.array(numbers).reshape(3, 3)


def _words(lines: Lines, rows: Sequence[str], columns: Sequence[int], begin: int) -> np.ndarray:
    """Return numbers (A, 3) in some columns of words of the lines that follow the line `begin`."""
    values = np.empty((len(rows), len(columns)))
    for k, row in enumerate(rows):
        texts = row.split()
        try:
            values[k] = [float(texts[column]) for column in columns]
        except (ValueError, IndexError):
            lines.refuse("has no three coordinates: repair the line", begin + k + 1)
    return values


def _order_of_ids(lines: Lines, rows: Sequence[str], column: int, begin: int) -> np.ndarray:
    """Return the order of the lines by the ids of their atoms (A,), which must differ; the lines follow the line `begin`."""
    number = _words(lines, rows, [column], begin)[:, 0]
    order = np.argsort(number, kind="stable")
    repeated = np.flatnonzero(np.diff(number[order]) == 0)
    if len(repeated):
        lines.refuse(
            f"has the id {number[order][repeated[0]]:g} of another atom of its frame: write the frames again",
            begin + int(order[repeated[0] + 1]) + 1,
        )
    return order


# ---- AMBER


def frames_of_mdcrd(lines: Lines, n_atoms: int) -> TextFrames:
    """Yield the frames of an mdcrd file: coordinates, and a box of three lengths if the first frame has one."""
    lines.next()  # the title
    per_line, width = MDCRD
    n_lines = -(-3 * n_atoms // per_line)
    boxed: bool | None = None
    while not lines.at_end():
        _skip_replica(lines)
        begin = lines.number
        rows = lines.take(n_lines)
        if rows is None:
            yield None
            return
        if boxed is None:
            line = lines.next()
            boxed = line is not None and n_lines > 1 and len(numbers_of(line)) == 3
            if line is not None:
                lines.back(line)
        box = lines.next() if boxed else None
        cut = boxed and (box is None or len(numbers_of(box)) != 3)
        last = rows[-1].rstrip()
        if cut or (lines.end_cuts() and (ends_within_a_number(box) if box else len(last) % width)):
            yield None
            return
        yield lambda rows=rows, begin=begin, box=box: TextFrame(  # type: ignore[misc]
            _of_columns(lines, rows, width, n_atoms, begin), box=_box_of_lengths(box)
        )


def _skip_replica(lines: Lines) -> None:
    """Skip the line of replica exchange before a frame."""
    line = lines.next()
    if line is not None and not REPLICA.match(line):
        lines.back(line)


def _box_of_lengths(line: str | None) -> np.ndarray | None:
    """Return lattice vectors at right angles from the line of a box; None without one."""
    if line is None:
        return None
    a, b, c = numbers_of(line)
    return box_vectors(a, b, c, 90.0, 90.0, 90.0)


def _of_columns(lines: Lines, rows: Sequence[str], width: int, n_atoms: int, begin: int) -> np.ndarray:
    """Return positions (A, 3) from lines of columns of one width, which follow the line `begin`."""
    values: list[float] = []
    for k, row in enumerate(rows):
        found = fixed_columns(row, width) or numbers_of(row)
        if not found:
            lines.refuse("holds no coordinates: repair the line", begin + k + 1)
        values += found
    if len(values) != 3 * n_atoms:
        raise InputError(
            f"{FILE} has {len(values)} coordinates in the frame from line {begin + 1} on, and {n_atoms} atoms need "
            f"{3 * n_atoms}: give the topology that the trajectory was written with."
        )
    return np.array(values).reshape(-1, 3)


def frames_of_restart(lines: Lines, _n_atoms: int) -> TextFrames:
    """Yield the one frame of a restart file: number of atoms, coordinates, velocities and box where it has them."""
    lines.next()  # the title
    header = (lines.next() or "").split()
    n_atoms = count_of(lines, header[0] if header else None, "give an AMBER restart file")
    per_line, width = RESTART
    n_lines, begin = -(-n_atoms * 3 // per_line), lines.number
    rows = lines.take(n_lines)
    if rows is None or (lines.end_cuts() and ends_within_a_number(rows[-1])):
        yield None
        return
    following = [line for line in iter(lines.next_filled, None) if line is not None]
    following = following[n_lines:] if len(following) >= n_lines else following  # the velocities
    numbers = [number for line in following for number in fixed_columns(line, width)]
    boxed = len(numbers) in (3, 6) and n_atoms > 2
    box = box_vectors(*[*numbers, 90.0, 90.0, 90.0][:6]) if boxed else None
    yield lambda: TextFrame(_of_columns(lines, rows, width, n_atoms, begin), box=box)


# ---- CHARMM


def frames_of_card(lines: Lines, _n_atoms: int) -> TextFrames:
    """Yield the one frame of a CARD file: a title behind asterisks, number of atoms, atoms in columns."""
    rows, columns, begin = lines_of_card(lines)
    if rows is None:
        yield None
        return
    yield lambda: TextFrame(positions_of_card(lines, rows, columns, begin))


def lines_of_card(lines: Lines) -> tuple[list[str] | None, tuple[tuple[int, int], ...], int]:
    """Return the lines of the atoms of a CARD file, None if it is cut short, their columns, and the line before them."""
    line = lines.next()
    while line is not None and line.startswith("*"):
        line = lines.next()
    header = (line or "").split()
    n_atoms = count_of(lines, header[0] if header else None, "give a CARD file of CHARMM")
    wide = "EXT" in [word.upper() for word in header] or n_atoms >= MAX_ATOMS_OF_CARD
    begin = lines.number
    rows = lines.take(n_atoms)
    if rows is not None and not lines.at_end():
        lines.next()
        lines.refuse(f"follows the {n_atoms} atoms that the file announces: correct their number")
    return rows, EXTENDED_CARD if wide else CARD, begin


def positions_of_card(
    lines: Lines, rows: Sequence[str], columns: tuple[tuple[int, int], ...], begin: int
) -> np.ndarray:
    """Return positions (A, 3), Å, of the lines of a CARD file, which follow the line `begin`."""
    xyz = np.empty((len(rows), 3))
    for k, row in enumerate(rows):
        try:
            xyz[k] = [float(row[first:last]) for first, last in columns[4:7]]
        except ValueError:
            lines.refuse("has no three coordinates in its columns: repair the line", begin + k + 1)
    return xyz


# ---- LAMMPS


def frames_of_lammps_dump(lines: Lines, _n_atoms: int) -> TextFrames:
    """Yield the frames of a LAMMPS dump, sections that begin with ITEM, with the atoms in the order of their ids."""
    header: dict[str, list[str]] = {}
    while (line := lines.next_filled()) is not None:
        if not line.startswith("ITEM:"):
            lines.refuse("stands where an ITEM is expected: repair the line")
        name = line.removeprefix("ITEM:").strip()
        if not name.startswith("ATOMS"):
            size = {"BOX": 3}.get(name.split(" ")[0], 1)
            content = lines.take(size)
            if content is None:
                yield None
                return
            key = "BOX" if name.startswith("BOX") else name
            header |= {key: content, "BOX BOUNDS": [name]} if key == "BOX" else {key: content}
            continue
        n_atoms = count_of(
            lines, header.get("NUMBER OF ATOMS", [""])[0], "repair its section NUMBER OF ATOMS"
        )
        begin = lines.number
        rows = lines.take(n_atoms)
        if rows is None or (lines.end_cuts() and _is_short(rows)):
            yield None
            return
        yield (
            lambda rows=rows, name=name, header=dict(header), begin=begin: _frame_of_dump(  # type: ignore[misc]
                lines, rows, name.split()[1:], header, begin
            )
        )


def _is_short(rows: Sequence[str]) -> bool:
    """Return whether the last line has fewer words than the one before, or ends within a number."""
    texts = [row.split() for row in rows[-2:]]
    return len(texts[-1]) < len(texts[0]) or ends_within_a_number(rows[-1])


def _frame_of_dump(
    lines: Lines, rows: Sequence[str], columns: list[str], header: dict[str, list[str]], begin: int
) -> TextFrame:
    """Return a frame of a LAMMPS dump, whose atoms have these columns."""
    found = next(
        ((names.split(), scaled) for names, scaled in LAMMPS_POSITIONS if {*names.split()} <= {*columns}),
        None,
    )
    if found is None:
        lines.refuse(
            f"names the columns {', '.join(columns)}, and no x, y and z: write them with `dump ... id type x y z`",
            begin,
        )
    names, scaled = found
    origin, box = _box_of_dump(lines, header)
    xyz = _words(lines, rows, [columns.index(name) for name in names], begin)
    if scaled:
        xyz = origin + xyz @ box
    if "id" in columns:
        xyz = xyz[_order_of_ids(lines, rows, columns.index("id"), begin)]
    return TextFrame(xyz, box=box)


def _box_of_dump(lines: Lines, header: dict[str, list[str]]) -> tuple[np.ndarray, np.ndarray]:
    """Return the origin (3,) and the lattice vectors (3, 3), Å, of a frame of a LAMMPS dump."""
    bounds = [numbers_of(line) for line in header.get("BOX", [])]
    general = "abc" in header.get("BOX BOUNDS", [""])[0].split()
    if len(bounds) != 3 or any(len(row) not in ((4,) if general else (2, 3)) for row in bounds):
        lines.refuse("is not preceded by the three lines of a box: repair the section BOX BOUNDS")
    if general:  # each line holds a lattice vector and a coordinate of the origin
        vectors = np.array(bounds)
        return vectors[:, 3], vectors[:, :3]
    if len(bounds[0]) == 2:
        low, high = np.array(bounds).T
        return low, np.diag(high - low)
    # the bounds are those of the box around the tilted one
    (xlo, xhi, xy), (ylo, yhi, xz), (zlo, zhi, yz) = bounds
    xlo, xhi = xlo - min(0, xy, xz, xy + xz), xhi - max(0, xy, xz, xy + xz)
    ylo, yhi = ylo - min(0, yz), yhi - max(0, yz)
    return np.array([xlo, ylo, zlo]), np.array([[xhi - xlo, 0, 0], [xy, yhi - ylo, 0], [xz, yz, zhi - zlo]])


def frames_of_lammps_data(lines: Lines, _n_atoms: int) -> TextFrames:
    """Yield the one frame of a LAMMPS data file, with the atoms in the order of their ids, in the images that it counts."""
    n_atoms, style = 0, ""
    header: list[str] = []
    while (line := lines.next()) is not None:
        texts = line.partition("#")[0].split()
        if texts[1:] == ["atoms"] and texts[0].isdecimal():
            n_atoms = int(texts[0])
        if texts[:1] == ["Atoms"]:
            style = line.partition("#")[2].strip()
            break
        header.append(" ".join(texts))
    if line is None or not n_atoms:
        raise InputError(f"{FILE} has no section Atoms: give a LAMMPS data file with atoms.")
    if style and style not in BEFORE_X:
        lines.refuse(
            f"announces atoms of the style {style}: write them in one of the styles {', '.join(BEFORE_X)}"
        )
    lines.next()  # an empty line
    begin = lines.number
    rows = lines.take(n_atoms)
    if rows is None:
        yield None
        return
    rows = [row.partition("#")[0] for row in rows]
    # without a style, the coordinates are the last three numbers that are no counts of images
    n_words = len(rows[0].split())
    whole = all(re.fullmatch(r"-?\d+", word) for word in rows[0].split()[-3:])
    first = BEFORE_X.get(style, n_words - 3 - 3 * (whole and n_words > 7))
    xyz = _words(lines, rows, range(first, first + 3), begin)
    box = _box_of_data(header)
    if box is not None and whole and n_words >= first + 6:
        xyz = xyz + _words(lines, rows, range(n_words - 3, n_words), begin) @ box
    order = _order_of_ids(lines, rows, 0, begin)
    yield lambda: TextFrame(xyz[order], box=box)


def _box_of_data(header: list[str]) -> np.ndarray | None:
    """Return the lattice vectors (3, 3), Å, of the header of a LAMMPS data file; None without a box."""
    found: dict[str, list[float]] = {}
    for line in header:
        for mark in ("xlo xhi", "ylo yhi", "zlo zhi", "xy xz yz", "avec", "bvec", "cvec"):
            if line.endswith(" " + mark):
                found[mark] = numbers_of(line.removesuffix(mark))
    if all(len(found.get(mark, [])) == 3 for mark in ("avec", "bvec", "cvec")):
        return np.array([found["avec"], found["bvec"], found["cvec"]])
    sides = [found.get(f"{axis}lo {axis}hi", []) for axis in "xyz"]
    if any(len(side) != 2 for side in sides):
        return None
    (a, b, c), (xy, xz, yz) = (high - low for low, high in sides), found.get("xy xz yz", [0.0, 0.0, 0.0])
    return np.array([[a, 0, 0], [xy, b, 0], [xz, yz, c]])


# ---- structures


def _frames_of_structure(source: Source) -> TextFrames:
    """Yield the models of a structure as frames."""
    file = (read_mmcif if source.format.name == "mmcif" else read_pdb)(source.text())
    for model in dict.fromkeys(file.atoms.model.tolist()):
        xyz = file.atoms.xyz[file.atoms.model == model]
        yield lambda xyz=xyz, model=model: TextFrame(xyz, box=file.box_of(model))  # type: ignore[misc]


TEXT_READERS: dict[str, Callable[[Lines, int], TextFrames]] = {
    "gro": frames_of_gro,
    "xyz": frames_of_xyz,
    "mdcrd": frames_of_mdcrd,
    "inpcrd": frames_of_restart,
    "card": frames_of_card,
    "lammps dump": frames_of_lammps_dump,
    "lammps data": frames_of_lammps_data,
}


def frames_of_text(source: Source, n_atoms: int) -> TextFrames:
    """Yield functions that parse the frames of a text file one after another, and None for a cut frame at its end.

    `n_atoms` is the number of atoms of the topology, which an mdcrd file does not hold.
    """
    if source.format.models:
        yield from _frames_of_structure(source)
        return
    with source.lines() as stream:
        yield from TEXT_READERS[source.format.name](Lines(stream), n_atoms)
