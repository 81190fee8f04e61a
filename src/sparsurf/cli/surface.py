"""`sparsurf surface`: the dots of a molecule."""

import argparse
from collections.abc import Iterator

import pandas as pd

from sparsurf.api import writing
from sparsurf.api.inputs import is_structure
from sparsurf.api.surfaces import components, mesh
from sparsurf.cli import options, outputs
from sparsurf.errors import InputError
from sparsurf.files import pluralise
from sparsurf.molecules.formats import STRUCTURES
from sparsurf.patches.index import D_LINK
from sparsurf.surfaces.components import summarize_components
from sparsurf.surfaces.dot_table import COMPONENT_FIELD
from sparsurf.surfaces.spacing import DENSITY as PUBLISHED_DENSITY

DOT_OPTIONS = {  # that do not apply to a mesh
    "fields": None,
    "table": None,
    "charges": "table",
    "d_link": D_LINK,
    "no_faces": False,
}
EXAMPLES = """\
The columns of a CSV are x,y,z,nx,ny,nz, area (Å^2), kind (0 contact, 1 saddle, 2 concave), component (0 is the largest), chain,
residue, residue_name, atom_name and atom (its index among the atoms taken, from 0). A PLY has triangles between the dots.
--mesh writes a finer closed surface instead of dots. Its corners lie on the surface, and every edge belongs to two triangles.
A cavity is a component inside the molecule, which no probe leaves.

examples:
  sparsurf surface protein.pdb -o dots.ply
  sparsurf surface protein.pdb --mesh -o mesh.ply
  sparsurf surface protein.pdb --cavities remove -o outside.ply
  sparsurf surface protein.pdb --fields hydropathy,potential -o dots.csv
  sparsurf surface protein.pdb --residues 209-214 --density 10 -o dense.csv
  sparsurf surface protein.pdb --trajectory run.xtc --frame 20 -o dots.dms
  sparsurf surface models.pdb --model all -o dots_{frame}.ply
  sparsurf surface protein.pdb -o - --format npz > dots.npz
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("file", metavar="FILE", help="structure")
    options.add_output(parser, writing.DOTS)
    options.add_mesh(parser, mesh=True)
    options.add_fields(parser)
    options.add_molecule(parser)


def run(args: argparse.Namespace) -> None:
    """Write the dots or triangles."""
    if not is_structure(args.file):
        raise InputError(
            f"{args.file} is not a structure, by its suffix: give one of {', '.join(STRUCTURES)}; --trajectory adds frames."
        )
    for name, default in DOT_OPTIONS.items() if args.mesh else ():
        if getattr(args, name) != default:
            option = name.replace("_", "-")
            raise InputError(
                f"--{option}: it is about dots, and --mesh writes triangles; leave out one of the two."
            )
    outputs.check(args, writing.MESHES if args.mesh else writing.DOTS)
    outputs.write_frames(args, _meshes(args) if args.mesh else _dots(args))


def _dots(args: argparse.Namespace) -> Iterator[tuple[int, writing.Dots]]:
    """Yield the dots of each frame."""
    for frame, bare, molecule in options.surfaces(args):
        assert molecule is not None  # FILE is a structure
        dots = options.with_fields(args, bare, molecule, frame)
        component, parts = components(molecule, dots, frame=frame, probe_radius=args.probe, radii=args.radii)
        table = pd.DataFrame({"area": dots.area, "kind": dots.kind, COMPONENT_FIELD: component})
        table = table.join(molecule.labels(dots.atom))
        words = f"{len(dots):,} dots, {dots.area.sum():,.0f} Å^2, {_words(parts)}"
        yield frame, writing.Dots(dots, table, None, molecule, frame, words=words)


def _words(parts: pd.DataFrame) -> str:
    """Return the message on the components of a surface."""
    summary = summarize_components(parts)
    words = f"{summary['volume']:,.0f} Å^3, {pluralise(int(summary['components']), 'component')}"
    if not summary["cavities"]:
        return words
    noun = "cavity" if summary["cavities"] == 1 else "cavities"
    return f"{words}, of which {summary['cavities']} {noun} with {summary['cavity_dots']:,} dots"


def _meshes(args: argparse.Namespace) -> Iterator[tuple[int, writing.Dots]]:
    """Yield the triangles of each frame."""
    molecule = options.read_atoms(args)
    for frame in options.frames_of(args, molecule):
        triangles = mesh(
            molecule,
            frame=frame,
            probe_radius=args.probe,
            density=args.density or PUBLISHED_DENSITY,
            radii=args.radii,
            cavities=args.cavities,
        )
        yield frame, writing.mesh_dots(triangles)
