"""DMS files: what UCSF's program DMS writes with its option -n."""

import re

import numpy as np

from sparsurf import InputError
from sparsurf.surfaces.formats.format import Format
from sparsurf.surfaces.surface import CONCAVE, CONTACT, SADDLE, surface_of_columns
from sparsurf.texts import text_of

KINDS = {"SC": CONTACT, "SS": SADDLE, "SR": CONCAVE}
DOT_TYPE = re.compile(r"\s(SC|SS|SR)\d*(?=\s)")
TYPES = np.array(["SC0", "SS0", "SR0"])


def _sniff(head):
    """Whether a line holds an atom or a dot."""
    text = head.decode("latin-1")
    return bool(DOT_TYPE.search(text) or re.search(r"\d A\s*$", text, re.M))


def read_dms(content, path):
    """Surface of a DMS file, read from the type of the dot both ways, since the columns before it shift.

    `atom` counts the atoms of the file.
    """
    rows, kinds, atoms, atom = [], [], [], -1
    for number, line in enumerate(text_of(content, path).split("\n"), 1):
        found = list(DOT_TYPE.finditer(line))
        if not found:
            atom += line.rstrip().endswith(" A")
            continue
        head, rest = line[: found[-1].start()], line[found[-1].end() :].split()
        if len(rest) == 1:
            raise InputError(f"{path} has no normals: run dms again with the option -n.")
        row = _floats(head.split()[-3:] + rest)
        if row is None:  # long numbers touch each other: by columns then
            x = head[-27:-18] if head[-27:-26] == "-" else head[-26:-18]
            row = _floats([x, head[-18:-9], head[-9:], *rest])
        if row is None or len(row) != 7:
            raise InputError(f"{path}, line {number}: not a dot with its area and normal: {line.strip()!r}.")
        rows.append(row)
        kinds.append(KINDS[found[-1].group(1)])
        atoms.append(atom)
    table = np.array(rows, dtype=float).reshape(-1, 7)
    points, area, normals = table[:, :3], table[:, 3], table[:, 4:]
    columns = {"points": points, "normals": normals, "area": area, "kind": kinds, "atom": atoms}
    return surface_of_columns(columns, path)


def _floats(words):
    """The numbers, or None where one is none."""
    try:
        return [float(word) for word in words]
    except ValueError:
        return None


def write_dms(path, surface, residue_names, residue_labels, atom_names, xyz):
    """Write a DMS file with normals, each atom followed by its dots.

    Parameters
    ----------
    path : file to write
    surface : Surface of known atoms and kinds
    residue_names, residue_labels, atom_names : (A,) str; a label is a number, with a chain letter or not
    xyz : (A, 3), Å

    Raises
    ------
    InputError : dots without atom or kind
    """
    if surface.atom.min() < 0 or surface.kind.min() < 0 or surface.atom.max() >= len(xyz):
        raise InputError("surface: a DMS file needs the atom and the kind of every dot.")
    # Labels with a letter shift the columns by one, as in DMS's own files; so do long numbers, not to touch.
    shifted = any(str(label)[-1:].isalpha() for label in residue_labels) or np.abs(xyz).max() >= 99.9
    width = 9 if shifted else 8
    by_atom = np.argsort(surface.atom, kind="stable")
    first = np.searchsorted(surface.atom[by_atom], np.arange(len(xyz) + 1))
    lines = []
    for i, labels in enumerate(zip(residue_names, residue_labels, atom_names, strict=True)):
        residue, label, atom = labels
        head = f"{residue:<3s}{label:>5s}{atom:>5s}"
        x, y, z = xyz[i]
        lines.append(f"{head}{x:{width}.3f}{y:9.3f}{z:9.3f} A\n")
        for n in by_atom[first[i] : first[i + 1]]:
            (x, y, z), (u, v, w), area = surface.points[n], surface.normals[n], np.nan_to_num(surface.area[n])
            place = f"{x:{width}.3f}{y:9.3f}{z:9.3f}"
            lines.append(f"{head}{place} {TYPES[surface.kind[n]]} {area:6.3f}{u:7.3f}{v:7.3f}{w:7.3f}\n")
    with open(path, "wb") as stream:
        stream.write("".join(lines).encode("ascii", "replace"))


FORMAT = Format("DMS", (".dms",), _sniff, read_dms, write_dms)
