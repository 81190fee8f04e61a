"""Read and write files of spheres: with radii (.xyzr, .xyzrn, .pqr), or of a small molecule with elements (.sdf, .mol, .mol2)."""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np

from sparsurf import registry
from sparsurf.errors import FILE, InputError, naming_file
from sparsurf.files import ends_within_a_row, pluralise, read_text, shorten
from sparsurf.molecules.atoms import AtomsLike
from sparsurf.molecules.formats import suffix
from sparsurf.molecules.plausibility import MIN_ATOMS_TO_JUDGE, refuse_crowded
from sparsurf.molecules.pqr import read_pqr
from sparsurf.molecules.residues import element_of, element_of_symbol
from sparsurf.surfaces.radii import radii_of_elements

log = logging.getLogger("sparsurf")

MIN_RADIUS = 0.5  # Å; the largest radius of a molecule is greater, and no radius in nm is
MAX_BOND = 1.9  # Å, usual distance of an atom from the nearest one; lengths in Bohr or pm exceed it
ATOM_OF_SDF = re.compile(r"(?: *-?\d+\.\d{4}){3} +[A-Za-z]")
MIN_ATOMS_OF_DRAWING = 5  # four atoms in a plane may be a molecule
V30 = "M  V30 "
# Symbols and types that are no atoms: dummy atoms, lone pairs, extra points
DUMMY_ATOMS = frozenset(["DU", "LP", "EP", "XX"])
TWO_LETTER_TYPES = ("CL", "BR")  # types of force fields that name their element in full


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


class AtomLine(NamedTuple):
    """An atom of a small molecule."""

    number: int  # of the line, from 1
    coordinates: list[str]
    name: str
    kind: str  # its element, or its type


def read_spheres(path: Path | str, *, skip_other_lines: bool = False) -> Spheres:
    """Read the spheres of a file, whose suffix determines the format; elements of .sdf, .mol and .mol2 get radii of Bondi.

    Raise InputError where a line is no sphere, or where lengths cannot be Å. `skip_other_lines` leaves out the lines of a
    .xyzr or .xyzrn without four numbers, and spheres of the radius 0, as MSMS does, with a warning.
    """
    with naming_file(path):
        text, read = read_text(path), SPHERE_READERS.get(suffix(path), _xyzr)
        return _spheres(_without_other_lines(text) if skip_other_lines and read is _xyzr else text, read)


def _without_other_lines(text: str) -> str:
    """Empty the lines without a sphere, except comments; the others keep their numbers.

    A row of too few numbers at the end, without a line feed, stays: the file may be cut short there.
    """
    lines = text.split("\n")
    skipped = []
    for k, line in enumerate(lines):
        texts = line.split()[:4]
        if not texts or texts[0].startswith("#"):
            continue
        is_number = [_is_number(word) for word in texts]
        may_be_cut = k == len(lines) - 1 and all(is_number)
        if (all(is_number) and float(texts[3]) != 0) if len(texts) == 4 else may_be_cut:
            continue
        skipped.append((k, line.strip()))
        lines[k] = ""
    if skipped:
        log.warning(
            "%s: skipped %s without a sphere (x, y, z and a radius above 0); the first is line %d: %s",
            FILE, pluralise(len(skipped), "line"), skipped[0][0] + 1, shorten(skipped[0][1]),
        )  # fmt: skip
    return "\n".join(lines)


def _spheres(text: str, read: SphereReader) -> Spheres:
    """Return the spheres that a reader finds in a text."""
    spheres = read(text.removesuffix("\n"))
    if not len(spheres.radii):
        raise InputError(f"{FILE} holds no atoms with radii or elements; give a file of such atoms.")
    if read is _xyzr and ends_within_a_row(text):
        raise InputError(
            f"{FILE} is cut short: line {text.count(chr(10)) + 1} is not complete; copy it again."
        )
    n = len(spheres.radii)
    gap = refuse_crowded(spheres.xyz, n_to_judge=MIN_ATOMS_TO_JUDGE if read is _xyzr else 2)
    if gap > MAX_BOND and n >= MIN_ATOMS_TO_JUDGE and read is not _xyzr:
        message = "%s: half of its %d atoms lie %.1f Å or more from all others, farther than bonds; are lengths in Å?"
        log.warning(message, FILE, n, gap)
    if spheres.radii.max() < MIN_RADIUS:
        raise InputError(f"{FILE}: its largest radius is {spheres.radii.max():g} Å; give lengths in Å.")
    return spheres


def _is_number(word: str) -> bool:
    """Return whether a word is a number; nan is one, which the readers refuse."""
    try:
        float(word)
    except ValueError:
        return False
    return True


def _number(word: str) -> float:
    """Return a word as a number, nan if it is none."""
    try:
        return float(word)
    except ValueError:
        return math.nan


def _xyzr(text: str) -> Spheres:
    """Read x, y, z and radius at the beginning of each line, and the name behind a number of a .xyzrn."""
    rows, names = [], []
    for number, line in enumerate(text.split("\n"), 1):
        texts = line.split()
        if not texts or texts[0].startswith("#"):
            continue
        try:
            x, y, z, radius = map(float, texts[:4])
        except ValueError:
            raise InputError(
                f"{FILE}: line {number} does not hold x, y, z and the radius of a sphere, Å; repair it."
            ) from None
        if not all(map(math.isfinite, (x, y, z, radius))) or radius <= 0:
            raise InputError(
                f"{FILE}: line {number} has a sphere at {' '.join(texts[:3])} of the radius {radius:g} Å; coordinates must "
                "be finite, and radii above 0."
            )
        rows.append((x, y, z, radius))
        names.append(texts[5] if len(texts) > 5 else "")
    table = np.array(rows).reshape(-1, 4)
    return Spheres(table[:, :3], table[:, 3], names)


def _pqr(text: str) -> Spheres:
    """Read the atoms of a PQR file; atoms without a radius, as some force fields give hydrogens, have no surface."""
    atoms = read_pqr(text)
    kept = atoms.radius > 0
    if not kept.all():
        log.warning("%s: atoms of radius 0 have no surface and are left out (%d)", FILE, (~kept).sum())
    names = [name for name, keep in zip(atoms.names, kept.tolist(), strict=True) if keep]
    return Spheres(atoms.xyz[kept], atoms.radius[kept], names)


def _of_elements(atoms: Sequence[AtomLine], elements: Sequence[str]) -> Spheres:
    """Return the spheres of a small molecule, with radii of Bondi; dummy atoms and lone pairs, of no element, are left out."""
    rows, kept = [], []
    for atom, element in zip(atoms, elements, strict=True):
        if not element:
            continue
        xyz = [_number(word) for word in atom.coordinates]
        if len(xyz) != 3 or not all(map(math.isfinite, xyz)):
            raise InputError(
                f"{FILE}: line {atom.number} does not hold x, y and z of an atom, Å, but "
                f"{shorten(' '.join(atom.coordinates).strip() or 'nothing')}; repair it."
            )
        rows.append(xyz)
        kept.append((atom.name, element))
    if len(kept) < len(atoms):
        message = "%s: left out %s, such as dummy atoms or lone pairs, which have no surface"
        log.warning(message, FILE, pluralise(len(atoms) - len(kept), "particle"))
    radii = radii_of_elements(np.array([element for _, element in kept]), "bondi")
    return Spheres(np.array(rows).reshape(-1, 3), radii, [name for name, _ in kept])


def _symbol(atom: AtomLine) -> str:
    """Return the element of an atom whose kind is a symbol; empty for what is no atom."""
    element = element_of_symbol(atom.kind)
    if not element and atom.kind.upper() not in DUMMY_ATOMS:
        raise InputError(
            f"{FILE}: line {atom.number} has the element {atom.kind!r}, which does not exist; repair it, or replace an atom of "
            "a query by an element."
        )
    return element


def _sdf(text: str) -> Spheres:
    """Read the atoms of the only molecule of an SDF or MOL file, V2000 or V3000."""
    lines = text.split("\n")
    ends = [k for k, line in enumerate(lines) if line.startswith("$$$$")]
    if ends and any(line.strip() for line in lines[ends[0] + 1 :]):
        raise InputError(f"{FILE} holds several molecules; give a file of one.")
    if len(lines) < 4:
        raise InputError(f"{FILE} is no SDF file: it has no line with the number of atoms; repair it.")
    atoms = _v3000(lines) if "V3000" in lines[3] else _v2000(lines)
    drawn = len(atoms) >= MIN_ATOMS_OF_DRAWING and not any(_number(atom.coordinates[2]) for atom in atoms)
    if drawn and lines[1][20:22] != "3D":
        raise InputError(f"{FILE} is a drawing: z of all atoms is 0; give a file with positions in space.")
    return _of_elements(atoms, [_symbol(atom) for atom in atoms])


def _v2000(lines: list[str]) -> list[AtomLine]:
    """Return the atoms of an SDF file of the version V2000, in columns."""
    n = int(lines[3][:3]) if lines[3][:3].strip().isdigit() else -1
    if not 0 <= n <= len(lines) - 4:
        raise InputError(f"{FILE}: line 4 does not hold the number of atoms of the molecule; repair it.")
    beyond = next((k for k, line in enumerate(lines[4 + n :], 4 + n) if ATOM_OF_SDF.match(line)), None)
    if beyond is not None:
        raise InputError(
            f"{FILE}: line {beyond + 1} is an atom beyond the {n} that line 4 announces; correct their number."
        )
    return [
        AtomLine(k + 1, [line[:10], line[10:20], line[20:30]], line[31:34].strip(), line[31:34].strip())
        for k, line in enumerate(lines[4 : 4 + n], 4)
    ]


def _v3000(lines: list[str]) -> list[AtomLine]:
    """Return the atoms of an SDF file of the version V3000, in words; a line that ends in a hyphen goes on in the next."""
    rows = _continued([line.removeprefix(V30) for line in lines], "-")
    begin, end = (
        next((k for k, (_, texts) in enumerate(rows) if texts == [mark, "ATOM"]), -1)
        for mark in ("BEGIN", "END")
    )
    if not 0 <= begin < end:
        raise InputError(f"{FILE} has no lines BEGIN ATOM and END ATOM: it is cut short; copy it again.")
    counts = next((texts[1:2] for _, texts in rows[:begin] if texts[:1] == ["COUNTS"]), [])
    if counts and counts != [str(end - begin - 1)]:
        raise InputError(
            f"{FILE} has {end - begin - 1} atoms and announces {counts[0]}: it is cut short or was edited; copy it again."
        )
    atoms = []
    for number, texts in rows[begin + 1 : end]:
        if len(texts) < 5:
            raise InputError(
                f"{FILE}: line {number} is not an atom with element and position: {shorten(repr(' '.join(texts)))}."
            )
        atoms.append(AtomLine(number, texts[2:5], texts[1], texts[1]))
    return atoms


def _continued(lines: Sequence[str], mark: str) -> list[tuple[int, list[str]]]:
    """Return the number of the first line and the words of each row, which a mark at the end of a line continues."""
    rows: list[tuple[int, list[str]]] = []
    before = ""
    begin = 1
    for number, line in enumerate(lines, 1):
        begin = begin if before else number
        text = line.rstrip()
        before += text.removesuffix(mark)
        if not text.endswith(mark):
            rows.append((begin, before.split()))
            before = ""
    return rows


def _mol2(text: str) -> Spheres:
    """Read the atoms of the only molecule of a MOL2 file; a line that ends in a backslash goes on in the next."""
    lines = text.split("\n")
    if sum(line.startswith("@<TRIPOS>MOLECULE") for line in lines) > 1:
        raise InputError(f"{FILE} holds several molecules; give a file of one.")
    section, begin, n_announced = "", 0, math.nan
    atoms: list[AtomLine] = []
    for number, texts in _continued(lines, "\\"):
        if texts and texts[0].startswith("@<TRIPOS>"):
            section, begin = texts[0], number
        elif section == "@<TRIPOS>MOLECULE" and number == begin + 2:
            n_announced = _number(texts[0]) if texts else math.nan
        elif section == "@<TRIPOS>ATOM" and texts and not texts[0].startswith("#"):
            if len(texts) < 6:
                raise InputError(
                    f"{FILE}: line {number} is not an atom with position and type: {shorten(repr(' '.join(texts)))}."
                )
            atoms.append(AtomLine(number, texts[2:5], texts[1], texts[5]))
    if not math.isnan(n_announced) and len(atoms) != n_announced:
        raise InputError(
            f"{FILE} has {len(atoms)} atoms and announces {n_announced:.0f}: it is cut short or was edited; copy it again."
        )
    if all(_is_sybyl(atom) for atom in atoms):
        return _of_elements(
            atoms, [_symbol(atom._replace(kind=atom.kind.partition(".")[0])) for atom in atoms]
        )
    log.info("%s: its atom types are those of a force field; elements are taken from the names", FILE)
    return _of_elements(atoms, [_element_of_type(atom) for atom in atoms])


def _is_sybyl(atom: AtomLine) -> bool:
    """Return whether the type of an atom may be one of SYBYL: an element that its name does not contradict, or no atom.

    The aromatic carbon of a force field, ca or CA, is no calcium.
    """
    symbol, dot, _ = atom.kind.partition(".")
    element = element_of_symbol(symbol)
    if dot or len(element) < 2:
        return bool(element) or symbol.upper() in DUMMY_ATOMS
    of_name = _element_of_name(atom.name)
    is_named = re.sub("[^A-Z]", "", atom.name.upper()).startswith(element)
    return not symbol.islower() and (is_named or of_name in ("", element))


def _element_of_name(name: str) -> str:
    """Return the element that the name of an atom begins with, of a small molecule; empty without one."""
    return element_of_symbol(element_of("", name, "", polymer=False, alone=False))


def _element_of_type(atom: AtomLine) -> str:
    """Return the element of an atom with a type of a force field: that of its name, which begins its type as well."""
    symbol, dot, _ = atom.kind.partition(".")
    letters = re.sub("[^A-Z]", "", symbol.upper())
    element = element_of_symbol(symbol) if dot else _element_of_name(atom.name)
    if symbol.upper() in DUMMY_ATOMS:
        return ""
    if not element or not letters.startswith(element) or (letters in TWO_LETTER_TYPES and letters != element):
        raise InputError(
            f"{FILE}: line {atom.number} has the atom {atom.name!r} of the type {atom.kind!r}, which is not a type of SYBYL, and "
            "its name does not tell the element; write types such as C.3, N.am and Cl."
        )
    return element


# Reads the spheres of a text
SphereReader: TypeAlias = Callable[[str], Spheres]
SPHERE_READERS: dict[str, SphereReader] = {
    ".xyzr": _xyzr,
    ".xyzrn": _xyzr,
    ".pqr": _pqr,
    ".sdf": _sdf,
    ".mol": _sdf,
    ".mol2": _mol2,
}
SPHERE_FORMATS = registry.suffixes("spheres", is_read=True)


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
    path: Path | str, xyz: np.ndarray, radii: np.ndarray, atoms: AtomsLike, header: Sequence[str]
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
