"""DMS files, which UCSF's program DMS writes with its option -n."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from sparsurf.errors import FILE, InputError
from sparsurf.files import decode_text, shorten
from sparsurf.surfaces.surface import CONCAVE, CONTACT, SADDLE, Surface, SurfaceFormat, surface_of_columns

DMS_KINDS = {"SC": CONTACT, "SS": SADDLE, "SR": CONCAVE}
DOT_TYPE = re.compile(r"\s(SC|SS|SR)\d*(?=\s)")
DOT_TYPE_OF_KIND = np.array(["SC0", "SS0", "SR0"])


def _sniff(head: bytes) -> bool:
    """Return whether a line holds an atom or a dot."""
    text = head.decode("latin-1")
    return bool(DOT_TYPE.search(text) or re.search(r"\d A\s*$", text, re.M))


def read_dms(content: bytes) -> Surface:
    """Read a DMS file from both sides of the type of each dot, since the columns before it shift; `atom` counts its atoms."""
    rows, kinds, atoms, lines, atom = [], [], [], [], -1
    text = decode_text(content)
    n_lines = text.count("\n") + 1
    for number, line in enumerate(text.split("\n"), 1):
        types = list(DOT_TYPE.finditer(line))
        if not types:
            is_atom = line.rstrip().endswith(" A")
            if not is_atom and _floats(line.split()[-4:]) and len(line.split()) > 7:
                raise InputError(f"{FILE}: line {number} is a dot of no type SC, SS or SR; repair it.")
            # a line without a line feed may be cut, which is told below
            is_remark = not line.strip() or line.startswith("#")
            if not is_atom and not is_remark and number < n_lines:
                quoted = shorten(repr(line.strip()))
                raise InputError(f"{FILE}: line {number} is neither an atom nor a dot: {quoted}; repair it.")
            atom += is_atom
            continue
        rows.append(_dot_of_line(line, types[-1], number))
        kinds.append(DMS_KINDS[types[-1].group(1)])
        atoms.append(atom)
        lines.append(number)
    if line.strip() and not types and not line.rstrip().endswith(" A"):  # text after the last line break
        raise InputError(f"{FILE} is cut short: line {number} is not a complete dot or atom; copy it again.")
    table = np.array(rows, dtype=float).reshape(-1, 7)
    points, area, normals = table[:, :3], table[:, 3], table[:, 4:]
    return surface_of_columns(
        {"points": points, "normals": normals, "area": area, "kind": kinds, "atom": atoms}, lines
    )


def _dot_of_line(line: str, dot_type: re.Match[str], number: int) -> list[float]:
    """Return position, area and normal of the dot in a line: seven numbers."""
    head, tail = line[: dot_type.start()], line[dot_type.end() :].split()
    if len(tail) == 1:
        raise InputError(f"{FILE} has no normals: run dms again with the option -n.")
    row = _floats(head.split()[-3:] + tail)
    if row is None:  # long numbers touch each other, so split by columns
        x = head[-27:-18] if head[-27:-26] == "-" else head[-26:-18]
        row = _floats([x, head[-18:-9], head[-9:], *tail])
    if row is None or len(row) != 7:
        quoted = shorten(repr(line.strip()))
        raise InputError(f"{FILE}: line {number} is not a dot with its area and normal: {quoted}; repair it.")
    return row


def _floats(texts: Iterable[str]) -> list[float] | None:
    """Convert words to numbers; return None if one is not a number."""
    try:
        return [float(word) for word in texts]
    except ValueError:
        return None


def write_dms(
    path: Path | str,
    surface: Surface,
    residue_names: Sequence[str] | np.ndarray,
    residue_labels: Sequence[str] | np.ndarray,
    atom_names: Sequence[str] | np.ndarray,
    xyz: np.ndarray,
) -> None:
    """Write a DMS file with normals: each atom, of labels (A,), such as 12A, and positions (A, 3), Å, then its dots."""
    if surface.atom.min() < 0 or surface.kind.min() < 0 or surface.atom.max() >= len(xyz):
        raise InputError("surface: a DMS file needs the atom and the kind of every dot.")
    # Labels with a letter shift the columns by one, as in DMS's own files. So do long numbers, to keep them separate.
    farthest = max(np.abs(xyz).max(), np.abs(surface.points).max(initial=0))
    shifted = any(str(label)[-1:].isalpha() for label in residue_labels) or farthest >= 99.9
    width = 9 if shifted else 8
    by_atom = np.argsort(surface.atom, kind="stable")
    first = np.searchsorted(surface.atom[by_atom], np.arange(len(xyz) + 1))
    points, normals = surface.points.tolist(), surface.normals.tolist()
    areas, kinds = np.nan_to_num(surface.area).tolist(), surface.kind.tolist()
    lines = []
    for i, (residue, label, atom) in enumerate(zip(residue_names, residue_labels, atom_names, strict=True)):
        head = f"{residue:<3s}{label:>5s}{atom:>5s}"
        x, y, z = xyz[i]
        lines.append(f"{head}{x:{width}.3f}{y:9.3f}{z:9.3f} A\n")
        for n in by_atom[first[i] : first[i + 1]].tolist():
            (x, y, z), (u, v, w), area = points[n], normals[n], areas[n]
            position = f"{x:{width}.3f}{y:9.3f}{z:9.3f}"
            dot_type = DOT_TYPE_OF_KIND[kinds[n]]
            lines.append(f"{head}{position} {dot_type} {area:6.3f}{u:7.3f}{v:7.3f}{w:7.3f}\n")
    with open(path, "wb") as stream:
        stream.write("".join(lines).encode("ascii", "replace"))


FORMAT = SurfaceFormat(_sniff, read_dms)
