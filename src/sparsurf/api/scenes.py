"""Dots and triangles as files that PyMOL and ChimeraX show: PDB, PML, CXC and BILD."""

from __future__ import annotations

import base64
import json
import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from sparsurf import registry
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.pdb import encode_label, pdb_b_factor, pdb_position
from sparsurf.surfaces.formats.colours import KIND_COLOURS, Scale
from sparsurf.surfaces.surface import Surface

# Of one file, which shows colours and stores no numbers; .cxc has two files next to it
SCENES = tuple(
    name
    for name in registry.suffixes("dots")
    if name in registry.suffixes("colours") and name not in registry.suffixes("fields")
)
SPHERE_RADIUS = 0.3  # Å, of the spheres
KEPT = (0.84, 0.37, 0.0)  # vermillion of Okabe and Ito, of a subset and of triangles
BEGIN_OF_CHIMERAX_SCRIPT = "# Open it from this folder: chimerax "
PYMOL = """\
{structure}python
from pymol import cgo
scene = []
for r, g, b, x, y, z in (
{rows}
):
    scene += [cgo.COLOR, r, g, b, cgo.SPHERE, x, y, z, {radius}]
cmd.load_cgo(scene, "dots")
python end
bg_color white
orient
"""
# Bytes keep the script of a fine mesh small: colours in 255ths, normals in 127ths, positions in thousandths of an Å
PYMOL_VERTEX = np.dtype("3u1, 3i1, 3<i4")
PYMOL_MESH = (
    """\
{structure}python
import base64
import struct
from pymol import cgo
table = base64.b64decode("""
    + '"""'
    + """
{vertices}"""
    + '"""'
    + """)
vertices = []
for r, g, b, u, v, w, x, y, z in struct.iter_unpack("<3B3b3i", table):
    colour_and_normal = [r / 255, g / 255, b / 255, u / 127, v / 127, w / 127]
    vertices.append(colour_and_normal + [x / 1000, y / 1000, z / 1000])
table = base64.b64decode("""
    + '"""'
    + """
{corners}"""
    + '"""'
    + """)
scene = [cgo.BEGIN, cgo.TRIANGLES]
for corner in struct.iter_unpack("<i", table):
    r, g, b, u, v, w, x, y, z = vertices[corner[0]]
    scene += [cgo.COLOR, r, g, b, cgo.NORMAL, u, v, w, cgo.VERTEX, x, y, z]
cmd.load_cgo(scene + [cgo.END], "mesh")
python end
bg_color white
orient
"""
)
PYMOL_STRUCTURE = """\
python
cmd.read_pdbstr(
{lines}
, "structure")
python end
hide everything, structure
show cartoon, structure
"""


def write_scene(
    path: str | Path,
    surface: Surface,
    molecule: Molecule | None = None,
    frame: int = 0,
    scale: Scale | None = None,
    one_colour: bool = False,
    triangles: np.ndarray | None = None,
) -> None:
    """Write dots, or triangles (F, 3) between them, with the molecule as a cartoon where it is known.

    The suffix is .pdb (each dot a HETATM of its own residue DOT), .bild (spheres for ChimeraX), or .pml (a script for PyMOL
    that holds everything). The values of the `scale` are B factors, or colours with their key; without it, colours show the
    kinds of dots, and triangles have `one_colour`.
    """
    path = Path(path)
    if one_colour or (scale is None and triangles is not None):
        colours, key = np.tile(KEPT, (len(surface), 1)), None
    else:
        colours, key = (scale.colours if scale else KIND_COLOURS[surface.kind]) / 255, scale
    if path.suffix.lower() == ".pdb":
        _write_dots_as_pdb(path, surface.points, scale.values if scale else np.zeros(len(surface)))
    elif path.suffix.lower() == ".bild":
        write_bild(path, surface.points, colours, triangles, key)
    else:
        _write_pml(path, surface, colours, molecule, frame, triangles, key)


def chimerax_script(script: str, dots: str, molecule: str | None, scale: Scale | None = None) -> str:
    """Return the script of a name that opens two files next to it: the dots, and the molecule as a cartoon if it is known."""
    lines = [f"{BEGIN_OF_CHIMERAX_SCRIPT}{_quoted(script)}"]
    if molecule is not None:
        lines += [f"open {_quoted(molecule)}", "hide atoms", "cartoon"]
    key = [_chimerax_key(scale)] if scale and len(scale.places) > 1 else []  # which needs two colours
    return "\n".join([*lines, f"open {_quoted(dots)}", *key, "set bgColor white", "view", ""])


def _chimerax_key(scale: Scale) -> str:
    """Return the command of ChimeraX that draws the key of a scale."""
    labels = scale.bands or [(f"{value:.4g}", rgb) for value, rgb in scale.stops()]
    pairs = " ".join(f'"#{bytes(rgb).hex()}:{label}"' for label, rgb in labels)
    return f"key {pairs} colorTreatment {'distinct' if scale.bands else 'blended'}"


def is_opened_by(script: Path, file: Path) -> bool:
    """Return whether a file is one of those that an existing script of `chimerax_script` opens."""
    if not script.is_file():
        return False
    first, *lines = script.read_text(encoding="utf-8", errors="replace").split("\n")
    return first.startswith(BEGIN_OF_CHIMERAX_SCRIPT) and f"open {_quoted(file.name)}" in lines


def _quoted(name: str) -> str:
    """Return the name of a file as an argument of a ChimeraX command."""
    return name if re.fullmatch(r"[\w.+-]+", name) else json.dumps(name, ensure_ascii=False)


def write_bild(
    path: str | Path,
    points: np.ndarray,
    colours: np.ndarray | None = None,
    triangles: np.ndarray | None = None,
    scale: Scale | None = None,
) -> None:
    """Write spheres at points (N, 3), Å, or triangles (F, 3) between them; colours (N, 3) in 0..1, by default one."""
    colours = np.tile(KEPT, (len(points), 1)) if colours is None else colours
    if triangles is not None:
        colours = colours[triangles].mean(axis=1)
        shapes = [
            ".polygon " + " ".join(f"{x:.3f}" for x in corners.ravel()) for corners in points[triangles]
        ]
    else:
        shapes = [".sphere {:.3f} {:.3f} {:.3f} {:g}".format(*point, SPHERE_RADIUS) for point in points]
    lines, last = [] if scale is None else [f".{scale.comment}"], None
    for shape, colour in zip(shapes, colours, strict=True):
        colour_line = ".color {:.2f} {:.2f} {:g}".format(*colour.round(2))
        lines += [colour_line] if colour_line != last else []
        lines.append(shape)
        last = colour_line
    Path(path).write_text("\n".join([*lines, ""]), encoding="ascii")


def _write_dots_as_pdb(path: Path, points: np.ndarray, numbers: np.ndarray) -> None:
    """Write each dot as a HETATM in its own residue, with a number as B factor (0 with an occupancy of 0 if unknown)."""
    occupancy = np.isfinite(numbers).astype(float)
    b = pdb_b_factor(np.where(occupancy, numbers, 0))
    lines = [
        f"HETATM{(k + 1) % 100_000:5d}  X   DOT X{encode_label(str(k + 1))}   "
        f"{pdb_position(point)}{occupancy[k]:6.2f}{b[k]:6.2f}           X\n"
        for k, point in enumerate(points)
    ]
    path.write_text("".join([*lines, "END\n"]), encoding="ascii")


def _write_pml(
    path: Path,
    surface: Surface,
    colours: np.ndarray,
    molecule: Molecule | None,
    frame: int,
    triangles: np.ndarray | None,
    scale: Scale | None,
) -> None:
    """Write a script that draws the dots or triangles, and the molecule, without another file."""
    structure: Any = ""
    if molecule is not None:
        with tempfile.TemporaryDirectory() as folder:
            molecule.write_pdb(Path(folder, "structure.pdb"), frame)
            pdb = Path(folder, "structure.pdb").read_text(encoding="latin-1")
        structure = PYMOL_STRUCTURE.format(lines="\n".join(map(ascii, pdb.splitlines(keepends=True))))
    if triangles is not None:
        table = np.empty(len(surface), PYMOL_VERTEX)
        table["f0"], table["f1"] = np.rint(255 * colours), np.rint(127 * surface.normals)
        table["f2"] = np.rint(1000 * surface.points)
        vertices, corners = (
            base64.encodebytes(rows.tobytes()).decode() for rows in (table, triangles.astype("<i4"))
        )
        script = PYMOL_MESH.format(structure=structure, vertices=vertices, corners=corners)
    else:
        rows = _rows(np.hstack([colours, surface.points]))
        script = PYMOL.format(structure=structure, rows=rows, radius=SPHERE_RADIUS)
    if scale is not None and len(scale.places) > 1:
        values, shades = zip(*scale.stops(), strict=True)
        # of floats: whole numbers end PyMOL 2.5 at once
        script += f'cmd.ramp_new("{scale.name}", "none", {[*values]}, {(np.array(shades) / 255).round(3).tolist()})\n'
    path.write_text(script, encoding="utf-8")


def _rows(values: np.ndarray) -> str:
    """Return rows of numbers as tuples of Python, one in a line."""
    return "\n".join(f"({', '.join(f'{x:.3f}' for x in row)})," for row in values.tolist())
