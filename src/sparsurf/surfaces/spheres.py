"""Spheres from files that hold radii, or elements of a small molecule: .xyzr, .xyzrn, .pqr, .sdf, .mol and .mol2."""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np

from sparsurf import kinds
from sparsurf.errors import FILE, InputError, naming_file
from sparsurf.files import ends_within_a_row, read_text, shorten
from sparsurf.molecules.atoms import AtomsLike
from sparsurf.molecules.formats import suffix
from sparsurf.surfaces.radii import RADII, RADIUS_OF_OTHER_ELEMENTS

log = logging.getLogger("sparsurf")

N_SPHERE_COLUMNS = 4
N_PQR_COLUMNS = 5  # x, y, z, charge and radius at the end of a line
N_PQR_WORDS = 10  # of a line without a chain
ATOM_OF_SDF = re.compile(r"(?: *-?\d+\.\d{4}){3} +[A-Za-z]")
MIN_ATOMS_OF_DRAWING = 5  # four atoms in a plane may be a molecule


class Spheres(NamedTuple):
    """Spheres of a file.

    Attributes
    ----------
    xyz : (A, 3) float64, Å
    radii : (A,) float64, Å
    names : (A,) str; empty without one
    """

    xyz: np.ndarray
    radii: np.ndarray
    names: list[str]


# The texts of x, y and z; the radius in Å, None if it is no number; the name
Row = tuple[Sequence[str], float | None, str]
# Yields the number of a line, from 1, and its row
SphereReader: TypeAlias = Callable[[list[str]], Iterator[tuple[int, Row]]]


def read_spheres(path: Path | str) -> Spheres:
    """Read the spheres of a file, whose suffix determines the format; elements of .sdf, .mol and .mol2 get radii of Bondi."""
    with naming_file(path):
        return _spheres(read_text(path), SPHERE_READERS.get(suffix(path), _xyzr))


def _spheres(text: str, read: SphereReader) -> Spheres:
    """Return the spheres that a reader finds in the lines of a text."""
    rows, names = [], []
    for number, (coordinates, radius, name) in read(text.removesuffix("\n").split("\n")):
        row = [*map(_number, coordinates), radius]
        numbers = [value for value in row if value is not None]
        if len(numbers) < N_SPHERE_COLUMNS:
            raise InputError(
                f"{FILE}: line {number} does not hold x, y, z and the radius of a sphere, Å; repair it."
            )
        if not all(map(math.isfinite, numbers)) or numbers[3] <= 0:
            raise InputError(
                f"{FILE}: line {number} has a sphere at {' '.join(coordinates)} of the radius {numbers[3]:g} Å; coordinates must "
                "be finite, and radii above 0."
            )
        rows.append(numbers)
        names.append(name)
    if not rows:
        raise InputError(f"{FILE} holds no atoms; give a file of atoms with radii or elements.")
    last = text[text.rfind("\n") + 1 :]
    is_row = read is _xyzr or (read is _pqr and last.startswith(("A", "H")))  # and not END
    if is_row and ends_within_a_row(text):
        raise InputError(
            f"{FILE} is cut short: line {text.count(chr(10)) + 1} is not complete; copy it again."
        )
    table = np.array(rows)
    return Spheres(table[:, :3], table[:, 3], names)


def _number(word: str) -> float | None:
    """Return a word as a number, or None."""
    try:
        return float(word)
    except ValueError:
        return None


def _xyzr(lines: list[str]) -> Iterator[tuple[int, Row]]:
    """Yield x, y, z and radius at the beginning of each line, and the name behind a number of a .xyzrn."""
    for number, line in enumerate(lines, 1):
        columns = line.split()
        if columns and not columns[0].startswith("#"):
            radius = _number(columns[3]) if len(columns) > 3 else None
            yield number, (columns[:3], radius, columns[5] if len(columns) > 5 else "")


def _pqr(lines: list[str]) -> Iterator[tuple[int, Row]]:
    """Yield the atoms of a PQR file; atoms without a radius, as some force fields give hydrogens, have no surface."""
    without = 0
    for number, line in enumerate(lines, 1):
        if line.startswith(("ATOM", "HETATM")):
            columns = line.split()
            # From the end of the line, as some programs write a chain and others do not
            radius = _number(columns[-1])
            if radius == 0:
                without += 1
                continue
            # Where columns touch, words are fewer; if one is missing, the number of the residue stands in the place of x.
            is_complete = len(columns) > N_PQR_COLUMNS + 2 and (
                len(columns) >= N_PQR_WORDS or all("." in word for word in columns[-N_PQR_COLUMNS:])
            )
            yield (
                number,
                (
                    columns[-N_PQR_COLUMNS:-2] if is_complete else [],
                    radius,
                    columns[2] if is_complete else "",
                ),
            )
    if without:
        log.warning("%s: atoms of radius 0 have no surface and are left out (%d)", FILE, without)


def _line_of(columns: list[str], lines: list[str]) -> int:
    """Return the index of the first line of a V3000 file with this third and fourth column; 0 without one."""
    return next((k for k, line in enumerate(lines) if line.split()[2:4] == columns), 0)


def _sdf(lines: list[str]) -> Iterator[tuple[int, Row]]:
    """Yield the atoms of the only molecule of an SDF or MOL file, V2000 or V3000."""
    ends = [k for k, line in enumerate(lines) if line.startswith("$$$$")]
    if ends and any(line.strip() for line in lines[ends[0] + 1 :]):
        raise InputError(f"{FILE} holds several molecules; give a file of one.")
    if len(lines) < 4:
        raise InputError(f"{FILE} is no SDF file: it has no line with the number of atoms; repair it.")
    if "V3000" in lines[3]:
        begin, end = _line_of(["BEGIN", "ATOM"], lines), _line_of(["END", "ATOM"], lines)
        atoms = [
            (k + 1, line.split()[4:7], line.split()[3])
            for k, line in enumerate(lines[begin + 1 : end], begin + 1)
        ]
    else:
        n = int(lines[3][:3]) if lines[3][:3].strip().isdigit() else -1
        if not 0 <= n <= len(lines) - 4:
            raise InputError(f"{FILE}: line 4 does not hold the number of atoms of the molecule; repair it.")
        beyond = next((k for k, line in enumerate(lines[4 + n :], 4 + n) if ATOM_OF_SDF.match(line)), None)
        if beyond is not None:
            raise InputError(
                f"{FILE}: line {beyond + 1} is an atom beyond the {n} that line 4 announces; correct their number."
            )
        atoms = [
            (k + 1, [line[:10], line[10:20], line[20:30]], line[31:34].strip())
            for k, line in enumerate(lines[4 : 4 + n], 4)
        ]
    if len(atoms) >= MIN_ATOMS_OF_DRAWING and not any(_number(coordinates[2]) for _, coordinates, _ in atoms):
        raise InputError(f"{FILE} is a drawing: z of all atoms is 0; give a file with positions in space.")
    for number, coordinates, symbol in atoms:
        yield number, (coordinates, _radius(symbol, number), symbol)


def _mol2(lines: list[str]) -> Iterator[tuple[int, Row]]:
    """Yield the atoms of the only molecule of a MOL2 file."""
    if sum(line.startswith("@<TRIPOS>MOLECULE") for line in lines) > 1:
        raise InputError(f"{FILE} holds several molecules; give a file of one.")
    section, begin, n_atoms, n_announced = "", 0, 0, None
    for number, line in enumerate(lines, 1):
        columns = line.split()
        if line.startswith("@<TRIPOS>"):
            section, begin = line.strip(), number
        elif section == "@<TRIPOS>MOLECULE" and number == begin + 2:
            n_announced = _number(columns[0]) if columns else None
        elif section == "@<TRIPOS>ATOM" and columns:
            if len(columns) < 6:
                raise InputError(
                    f"{FILE}: line {number} is not an atom with position and type: {shorten(repr(line))}."
                )
            n_atoms += 1
            yield number, (columns[2:5], _radius(columns[5].split(".")[0], number), columns[1])
    if n_announced is not None and n_atoms != n_announced:
        raise InputError(
            f"{FILE} has {n_atoms} atoms and announces {n_announced:.0f}: it is cut short or was edited; copy it again."
        )


def _radius(symbol: str, number: int) -> float:
    """Return the radius of an element, Å."""
    if not symbol.isalpha():
        raise InputError(
            f"{FILE}: line {number} has the element {symbol!r}, which does not exist; repair it."
        )
    return RADII["bondi"].get(symbol.upper(), RADIUS_OF_OTHER_ELEMENTS["bondi"])


SPHERE_READERS: dict[str, SphereReader] = {
    ".xyzr": _xyzr,
    ".xyzrn": _xyzr,
    ".pqr": _pqr,
    ".sdf": _sdf,
    ".mol": _sdf,
    ".mol2": _mol2,
}
SPHERE_FORMATS = kinds.suffixes("spheres", is_read=True)


def write_spheres(
    path: Path | str,
    xyz: np.ndarray,
    radii: np.ndarray,
    names: Sequence[str] | None = None,
    header: Sequence[str] = (),
) -> None:
    """Write spheres at (A, 3) with radii (A,), Å, as .xyzr; as .xyzrn if there are names (A,). The header is one of comments."""
    with open(path, "w", encoding="ascii", errors="replace") as stream:
        stream.writelines(f"# {line}\n" for line in header)
        for k, ((x, y, z), radius) in enumerate(zip(xyz.tolist(), radii.tolist(), strict=True)):
            name = f" 1 {names[k]}" if names is not None else ""
            stream.write(f"{x:.3f} {y:.3f} {z:.3f} {_decimals(radius)}{name}\n")


def _decimals(radius: float) -> str:
    """Return a radius, Å, with three decimals, or all that it has."""
    return text if float(text := f"{radius:.3f}") == radius else repr(radius)


def write_pqr(
    path: Path | str, xyz: np.ndarray, radii: np.ndarray, atoms: AtomsLike, header: Sequence[str] = ()
) -> None:
    """Write atoms at (A, 3) with radii (A,), Å, as .pqr with the charge 0."""
    lines = [f"REMARK {line}\n" for line in header]
    for k, ((x, y, z), radius) in enumerate(zip(xyz.tolist(), radii.tolist(), strict=True)):
        record = "ATOM" if atoms.kind[k] in ("protein", "nucleic") else "HETATM"
        labels = f"{k + 1} {atoms.name[k]} {atoms.residue_name[k]} {atoms.chain[k]} {atoms.residue[k]}"
        lines.append(
            f"{record} {' '.join(labels.split())} {x:.3f} {y:.3f} {z:.3f} 0.000 {_decimals(radius)}\n"
        )
    Path(path).write_text("".join([*lines, "END\n"]), encoding="ascii", errors="replace")
