"""`sparsurf-msms`: the command line of the program MSMS, for programs that call it.

MSMS (Sanner, Olson & Spehner, Biopolymers 38:305, 1996) triangulates the solvent-excluded surface of spheres. The options, the
columns of the files, the exit status and the lines that programs read are those of MSMS 2.6.1.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

from sparsurf.arguments import DENSITY_LIMITS, PROBE
from sparsurf.errors import InputError, printable
from sparsurf.garbage_collection import collect_rarely, end_process
from sparsurf.version import __version__

if TYPE_CHECKING:
    import numpy as np

    from sparsurf.surfaces.dot_placement import Rolled
    from sparsurf.surfaces.mesh import Mesh
    from sparsurf.surfaces.rolling_probe import EnclosedCentres

MSMS_FAILED, NOT_READ, NO_INPUT = 1, 2, 255  # exit status, as of MSMS
RADIUS_OF_HYDROGENS = 1.2  # Å, that -noh leaves out
MAX_ATOMS_OF_PROBE = 3
DENSITY_OF_AREAS = 20.0  # dots per Å^2: sparse dots miss atoms of which little is exposed
FINE_STEP = 0.35  # Å, of a mesh whose vertices tell areas of atoms
OUTPUTS = ("of", ".vert"), ("of", ".face"), ("af", ".area")  # options, and the suffixes of their files


class Option(NamedTuple):
    """An option of MSMS: the number of its values, its line of help, and why it is refused, if it is."""

    n_values: int
    meaning: str
    refusal: str = ""


SOCKETS = "it reads spheres from files only"
OPTIONS = {
    "probe_radius": Option(1, "float : radius of the probe, Å [1.5]"),
    "density": Option(1, "float : vertices per Å^2 [1.0]"),
    "hdensity": Option(1, "float : accepted; the density is the same on all parts of the surface"),
    "surface": Option(1, "<tses> : the triangulated surface, the only one here [tses]"),
    "no_area": Option(0, ": do not compute the areas of atoms"),
    "socketName": Option(1, "", SOCKETS),
    "socketPort": Option(1, "", SOCKETS),
    "xdr": Option(0, "", SOCKETS),
    "sinetd": Option(0, "", SOCKETS),
    "noh": Option(0, ": ignore spheres of the radius 1.2"),
    "no_rest_on_pbr": Option(0, ": accepted; the triangulation never starts again"),
    "no_rest": Option(0, ": accepted; the triangulation never starts again"),
    "if": Option(
        1,
        "filename : spheres, with x, y, z and radius in each line (.xyzr), and a number and a name (.xyzrn)",
    ),
    "of": Option(
        1,
        "filename : name of the files of the surface, without .vert and .face; they replace such files of MSMS, and never the "
        "input or another file",
    ),
    "af": Option(
        1, "filename : name of the file of areas, without .area; as for -of, it replaces only such a file"
    ),
    "no_header": Option(0, ": write no lines of comment at the beginning of the files"),
    "free_vertices": Option(0, ": accepted; spheres that touch no other always have a surface"),
    "all_components": Option(0, ": also the wall of every cavity, in files of its own: NAME_1.vert, ..."),
    "one_cavity": Option(
        1,
        "n a1 ... an : the surface that a probe on these atoms, numbered from 0, belongs to; n is 1 to 3",
    ),
}


class Component(NamedTuple):
    """A component of a surface: its mesh, which is written, and its exact volume and areas."""

    mesh: Mesh
    volume: float  # Å^3, negative of a cavity; of the mesh where four or more atoms touch one probe
    areas: np.ndarray  # (3,) Å^2, of contact pieces, saddles and concave pieces
    accessible: np.ndarray  # (A,) Å^2, of each atom


class NotUnderstoodError(Exception):
    """The command line has an option that does not exist, or without its value."""


def parse(command_line: Sequence[str]) -> dict[str, str]:
    """Return the values of the options by name; a shortened name stands for the first that begins with it, as for MSMS."""
    found: dict[str, str] = {}
    position = 0
    while position < len(command_line):
        word = command_line[position]
        short = word.lstrip("-")
        names = [name for name in OPTIONS if short and name.startswith(short)]
        if not word.startswith("-") or not names:
            raise NotUnderstoodError(f"ERROR: {word} unknown argument")
        name = short if short in OPTIONS else names[0]
        option = OPTIONS[name]
        if option.refusal:
            raise InputError(f"-{name} of MSMS is not available: {option.refusal}.")
        n_values = option.n_values
        values = command_line[position + 1 : position + 1 + n_values]
        if name == "one_cavity" and values and values[0].isdecimal():
            n_values += int(values[0])
            values = command_line[position + 1 : position + 1 + n_values]
        if len(values) < n_values:
            raise NotUnderstoodError(f"ERROR: -{name} needs {'a value' if n_values == 1 else 'its values'}")
        found[name] = " ".join(values)
        position += 1 + n_values
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Triangulate the spheres of a file as MSMS does, and return the exit status."""
    if arguments is None:  # the process belongs to the command
        arguments = sys.argv[1:]
        collect_rarely()
    command_line = list(arguments)
    started = time.process_time()
    try:
        print(f"MSMS 2.6.1 replaced by sparsurf {__version__}")
        given = parse(command_line)
        if "if" not in given:
            print("MSMS: No input stream specified")
            return NO_INPUT
        if not os.path.isfile(given["if"]):
            print(f"input file {given['if']} couldn't be open ... Bye")
            return NOT_READ
        _run(given)
    except NotUnderstoodError as error:
        print(_usage())
        print(error, file=sys.stderr)
        return MSMS_FAILED
    except (InputError, OSError) as error:
        print(f"sparsurf-msms: {printable(str(error))}", file=sys.stderr)
        return MSMS_FAILED
    except MemoryError:
        print(
            "sparsurf-msms: the surface needs more memory than there is; give a smaller -density.",
            file=sys.stderr,
        )
        return MSMS_FAILED
    print(f"MSMS terminated normally\nTotal Time user: {time.process_time() - started:.2f}")
    return 0


def run() -> NoReturn:
    """Triangulate in a process of its own, which then ends at once."""
    end_process(main())


def _usage() -> str:
    """Return the list of options."""
    lines = [f"  -{name} {option.meaning}" for name, option in OPTIONS.items() if not option.refusal]
    return "\n".join(["Usage : sparsurf-msms parameters ", *lines])


def _run(given: dict[str, str]) -> None:
    """Compute everything that is requested, and then write it."""
    import numpy as np  # here, as below: a wrong option needs no kernels

    from sparsurf.api.writing import write_file
    from sparsurf.kernel_cache import require_kernel_cache
    from sparsurf.surfaces.components import (
        all_other_centres,
        analytical_faces,
        centres_of_cavities,
    )
    from sparsurf.surfaces.dot_placement import roll_checked
    from sparsurf.surfaces.formats import msms as files
    from sparsurf.surfaces.spheres import Spheres, read_spheres

    _refuse_replacing(given, [given[name] + suffix for name, suffix in OUTPUTS if name in given])
    probe = _number(given, "probe_radius", 1.5, PROBE)
    density = _number(given, "density", 1.0, DENSITY_LIMITS)
    if given.get("surface", "tses") != "tses":
        raise InputError(f"-surface {given['surface']} of MSMS is not available; leave it out, or give tses.")
    require_kernel_cache()
    spheres = read_spheres(given["if"], skip_other_lines=True)
    if "noh" in given:
        kept = np.abs(spheres.radii - RADIUS_OF_HYDROGENS) > 1e-6
        if not kept.any():
            raise InputError(f"{given['if']} holds only spheres of the radius 1.2, which -noh leaves out.")
        names = [name for name, keep in zip(spheres.names, kept, strict=True) if keep]
        spheres = Spheres(spheres.xyz[kept], spheres.radii[kept], names)
    n, pair = len(spheres.radii), (spheres.xyz, spheres.radii)
    print(f"INPUT  {given['if']} {n} spheres, radii {spheres.radii.min():6.3f} to {spheres.radii.max():6.3f}")
    print(f"PARAM  Probe_radius {probe:6.3f} density {density:6.3f}")
    rolled = roll_checked(*pair, probe, in_order=True)
    outside = True
    cavities: list[EnclosedCentres] = []
    if "all_components" in given or "one_cavity" in given:
        cavities = sorted(centres_of_cavities(rolled.rolling), key=lambda cavity: -int(cavity.probes.sum()))
        if "one_cavity" in given:
            cavities = _cavity_at(given["one_cavity"], cavities, rolled, n)
            outside = not cavities
    left_out: list[EnclosedCentres | None] = [None] if outside else []  # the outside leaves cavities out
    left_out += [all_other_centres(cavity) for cavity in cavities]
    components = [_component(rolled, centres, n, density) for centres in left_out]
    writers: list[tuple[str, Callable[[Path], Any]]] = []
    if "no_area" not in given:
        _print_areas(components, probe)
        if "af" in given:
            excluded = [_excluded_areas(pair, probe, rolled, centres) for centres in left_out]
            areas = [
                (area, component.accessible) for area, component in zip(excluded, components, strict=True)
            ]
            writers.append(
                (given["af"] + ".area", lambda path: files.write_areas(path, areas, spheres.names))
            )
    _print_meshes(components, probe)
    header = None if "no_header" in given else files.Header(given["if"], density, probe)
    for number, (made, *_) in enumerate(components):
        if "of" in given:
            name = given["of"] + (f"_{number}" if number else "")
            vertices, triangles = made.vertices, made.triangles
            faces = analytical_faces(vertices, *pair, probe)
            writers.append((f"{name}.vert", partial(
                files.write_vertices, surface=vertices, faces=faces, n_spheres=n, names=spheres.names, header=header,
            )))  # fmt: skip
            writers.append((f"{name}.face", partial(
                files.write_faces, surface=vertices, faces=faces, triangles=triangles, n_spheres=n, header=header,
            )))  # fmt: skip
    _refuse_replacing(given, [name for name, _ in writers])
    for name, writer in writers:
        write_file(name, {Path(name).suffix: writer})


def _refuse_replacing(given: dict[str, str], files: Sequence[str]) -> None:
    """Raise InputError if a file that would be written is the input, or exists and is not a file of MSMS."""
    from sparsurf.api.replacing import is_of_msms, refuse_replacing

    for file in files:
        refuse_replacing(file, (given["if"],), {Path(file): is_of_msms})


def _cavity_at(
    request: str, cavities: Sequence[EnclosedCentres], rolled: Rolled, n: int
) -> list[EnclosedCentres]:
    """Return the largest cavity in which a fixed probe touches all of some atoms; none if only the outside has such a probe."""
    number, *atoms = request.split()
    if not (number.isdecimal() and 1 <= int(number) <= MAX_ATOMS_OF_PROBE):
        raise InputError(f"-one_cavity begins with {number!r}; it must be the number of atoms, 1 to 3.")
    wrong = next((word for word in atoms if not (word.isdecimal() and int(word) < n)), None)
    if wrong is not None:
        raise InputError(f"-one_cavity names atom {wrong!r}; the atoms are numbered from 0 to {n - 1}.")
    triple = rolled.atom[rolled.rolling.triple]
    touches = (triple[:, :, None] == [int(word) for word in atoms]).any(axis=1).all(axis=1)
    if not touches.any():
        raise InputError(f"-one_cavity: no probe touches the atoms {', '.join(atoms)}; name others.")
    return [cavity for cavity in cavities if (touches & cavity.probes).any()][:1]


def _component(rolled: Rolled, left_out: EnclosedCentres | None, n: int, density: float) -> Component:
    """Triangulate and measure the surface of n atoms below the centres of a rolled probe, but for those left out."""
    import numpy as np

    from sparsurf.surfaces.components import enclosed_centres
    from sparsurf.surfaces.mesh import MeshSize
    from sparsurf.surfaces.pieces import pieces_of, shapes_of
    from sparsurf.surfaces.surface import CONTACT
    from sparsurf.surfaces.triangulation import mesh_of_pieces, without_centres

    rolled = without_centres(rolled, enclosed_centres(rolled.rolling) if left_out is None else left_out)
    pieces = pieces_of(rolled)
    shapes = shapes_of(rolled, pieces)
    made = mesh_of_pieces(
        pieces, rolled, MeshSize(density=density), float(shapes.area.sum()), int(shapes.chi.sum())
    )
    of_kinds = shapes_of(rolled, pieces, pieces.face_kind.astype(np.int64)).area
    contact = pieces.face_kind == CONTACT
    atom, reach = pieces.face_owner[contact], rolled.rolling.atoms.reach
    accessible = np.bincount(rolled.atom[atom], pieces.solid[contact] * reach[atom] ** 2, n)
    volume = made.volume if pieces.n_open else float(shapes.volume.sum())
    return Component(made, volume, np.append(of_kinds, np.zeros(3 - len(of_kinds))), accessible)


def _excluded_areas(
    pair: tuple[np.ndarray, np.ndarray], probe: float, rolled: Rolled, left_out: EnclosedCentres | None
) -> np.ndarray:
    """Return the area of the excluded surface of each atom, (A,) Å^2: of the outside by dots, of a cavity by a fine mesh."""
    import numpy as np

    from sparsurf.api.surfaces import surface
    from sparsurf.surfaces.mesh import MeshSize
    from sparsurf.surfaces.triangulation import mesh_of_rolled

    if left_out is None:
        dots = surface(pair, probe_radius=probe, density=DENSITY_OF_AREAS, cavities="remove")
    else:
        dots = mesh_of_rolled(rolled, MeshSize(step=FINE_STEP), left_out).vertices
    return np.bincount(dots.atom, dots.area, len(pair[1]))


def _print_areas(components: Sequence[Component], probe: float) -> None:
    """Print the areas of components in the lines of MSMS."""
    print("ANALYTICAL SURFACE AREA :\n    Comp. probe_radius,   reent,    toric,   contact    SES       SAS")
    for number, (_, _, areas, accessible) in enumerate(components):
        columns = " ".join(f"{area:9.3f}" for area in (*areas[::-1], areas.sum(), accessible.sum()))
        print(f"{number:7d}  {probe:9.3f}   {columns}")


def _print_meshes(components: Sequence[Component], probe: float) -> None:
    """Print the sizes of meshes in the lines of MSMS, and the exact volumes."""
    print("TRIANGULATION...")
    for number, (made, *_) in enumerate(components):
        n, n_faces = len(made.vertices), len(made.triangles)
        genus = 1 - (n - n_faces // 2) // 2
        print(f"    Component {number}\n    component#, vertices,  edges,  faces, genus, density")
        density = n / float(made.vertices.area.sum())
        print(f"    {number:<8d} {n:7d} {3 * n_faces // 2:7d} {n_faces:7d} {genus:4d} {density:9.3f}")
    print("NUMERICAL VOLUMES AND AREA\n    Comp. probe_radius SES_volume SES_area)")
    for number, (made, volume, *_) in enumerate(components):
        area = float(made.vertices.area.sum())
        print(f"{number:8d}      {probe:4.2f} {volume:12.3f} {area:12.3f}")
    print(f"    Total ses_volume: {sum(component.volume for component in components):9.3f}")


def _number(given: dict[str, str], name: str, default: float, limits: Any) -> float:
    """Return the number of an option within its limits."""
    word = given.get(name, str(default))
    try:
        value = float(word)
    except ValueError:
        raise InputError(f"-{name} is {word!r}; it must be a number.") from None
    return limits.check(value, f"-{name}")


if __name__ == "__main__":
    sys.exit(main())
