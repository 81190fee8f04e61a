"""`sparsurf-msms`: the command line of the program MSMS, for programs that call it.

MSMS (Sanner, Olson & Spehner, Biopolymers 38:305, 1996) triangulates the solvent-excluded surface of spheres. The options, the
columns of the files, the exit status and the lines that programs read are those of MSMS 2.6.1.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from sparsurf.arguments import DENSITY_LIMITS, PROBE
from sparsurf.errors import InputError, printable
from sparsurf.version import __version__

if TYPE_CHECKING:
    from sparsurf.surfaces.mesh import Mesh

MSMS_FAILED, NOT_READ, NO_INPUT = 1, 2, 255  # exit status, as of MSMS
DENSITY_OF_AREAS = 20.0  # dots per Å^2
RADIUS_OF_HYDROGENS = 1.2  # Å, that -noh leaves out


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
    "of": Option(1, "filename : name of the files of the surface, without .vert and .face"),
    "af": Option(1, "filename : name of the file of areas, without .area"),
    "no_header": Option(0, ": write no lines of comment at the beginning of the files"),
    "free_vertices": Option(0, ": accepted; spheres that touch no other always have a surface"),
    "all_components": Option(
        0, "", "compute the cavities by `sparsurf surface --cavities keep` or sparsurf.components"
    ),
    "one_cavity": Option(
        0, "", "compute the cavities by `sparsurf surface --cavities keep` or sparsurf.components"
    ),
}


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
        values = command_line[position + 1 : position + 1 + option.n_values]
        if len(values) < option.n_values:
            raise NotUnderstoodError(f"ERROR: -{name} needs a value")
        found[name] = values[0] if values else ""
        position += 1 + option.n_values
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Triangulate the spheres of a file as MSMS does, and return the exit status."""
    command_line = sys.argv[1:] if arguments is None else list(arguments)
    started = time.process_time()
    print(f"MSMS 2.6.1 replaced by sparsurf {__version__}")
    try:
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


def _usage() -> str:
    """Return the list of options."""
    lines = [f"  -{name} {option.meaning}" for name, option in OPTIONS.items() if not option.refusal]
    return "\n".join(["Usage : sparsurf-msms parameters ", *lines])


def _run(given: dict[str, str]) -> None:
    """Compute everything that is requested, and then write it."""
    import numpy as np  # here, as below: a wrong option needs no kernels

    from sparsurf.api.surfaces import mesh, surface
    from sparsurf.api.writing import write_file
    from sparsurf.kernel_cache import require_kernel_cache
    from sparsurf.surfaces.formats import msms as files
    from sparsurf.surfaces.spheres import Spheres, read_spheres

    probe = _number(given, "probe_radius", 1.5, PROBE)
    density = _number(given, "density", 1.0, DENSITY_LIMITS)
    if given.get("surface", "tses") != "tses":
        raise InputError(f"-surface {given['surface']} of MSMS is not available; leave it out, or give tses.")
    require_kernel_cache()
    spheres = read_spheres(given["if"])
    if "noh" in given:
        kept = np.abs(spheres.radii - RADIUS_OF_HYDROGENS) > 1e-6
        if not kept.any():
            raise InputError(f"{given['if']} holds only spheres of the radius 1.2, which -noh leaves out.")
        names = [name for name, keep in zip(spheres.names, kept, strict=True) if keep]
        spheres = Spheres(spheres.xyz[kept], spheres.radii[kept], names)
    n, pair = len(spheres.radii), (spheres.xyz, spheres.radii)
    print(f"INPUT  {given['if']} {n} spheres, radii {spheres.radii.min():6.3f} to {spheres.radii.max():6.3f}")
    print(f"PARAM  Probe_radius {probe:6.3f} density {density:6.3f}")
    writers: list[tuple[str, Callable[[Path], Any]]] = []
    # of the areas of atoms: sparse dots miss atoms of which little is exposed
    dense = DENSITY_OF_AREAS if "af" in given and "no_area" not in given else "auto"
    dots = surface(pair, probe_radius=probe, density=dense, cavities="remove")
    if "no_area" not in given:
        excluded = np.bincount(dots.atom, dots.area, n)
        contact = dots.kind == 0
        scale = ((spheres.radii + probe) / spheres.radii) ** 2
        accessible = np.bincount(dots.atom[contact], dots.area[contact], n) * scale
        by_kind = [dots.area[dots.kind == kind].sum() for kind in (2, 1, 0)]
        print(
            "ANALYTICAL SURFACE AREA :\n    Comp. probe_radius,   reent,    toric,   contact    SES       SAS"
        )
        columns = " ".join(f"{area:9.3f}" for area in (*by_kind, excluded.sum(), accessible.sum()))
        print(f"      0  {probe:9.3f}   {columns}")
        if "af" in given:
            areas = [(excluded, accessible)]
            writers.append(
                (given["af"] + ".area", lambda path: files.write_areas(path, areas, spheres.names))
            )
    made = mesh(dots, density=density)
    _report(made, probe)
    if "of" in given:
        header = None if "no_header" in given else files.Header(given["if"], density, probe)
        vertices = made.vertices
        vert, face = given["of"] + ".vert", given["of"] + ".face"
        writers.append((vert, lambda path: files.write_vertices(path, vertices, n, spheres.names, header)))
        writers.append((face, lambda path: files.write_faces(path, vertices, made.triangles, n, header)))
    for name, writer in writers:
        write_file(name, (Path(name).suffix,), {Path(name).suffix: writer})


def _report(made: Mesh, probe: float) -> None:
    """Print the sizes of a mesh in the lines of MSMS."""
    n, area = len(made.vertices), float(made.vertices.area.sum())
    n_faces = len(made.triangles)
    print("TRIANGULATION...\n    Component 0\n    component#, vertices,  edges,  faces, genus, density")
    genus = 1 - (n - n_faces // 2) // 2
    print(f"    0        {n:7d} {3 * n_faces // 2:7d} {n_faces:7d} {genus:4d} {n / area:9.3f}")
    print("NUMERICAL VOLUMES AND AREA\n    Comp. probe_radius SES_volume SES_area)")
    print(
        f"       0      {probe:4.2f} {made.volume:12.3f} {area:12.3f}\n    Total ses_volume: {made.volume:9.3f}"
    )


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
