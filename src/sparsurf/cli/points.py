"""`sparsurf points`: a few points with normals on the surface of a structure, or of every structure of a folder."""

from __future__ import annotations

import argparse

import sparsurf
from sparsurf import registry
from sparsurf.api.field_values import check_fields
from sparsurf.api.writing import OUTPUTS_OF_DOTS
from sparsurf.cli import folders, options, outputs
from sparsurf.dot_fields.maps import MAPS
from sparsurf.molecules.formats import title
from sparsurf.surfaces.chosen_points import NamedPoints

FORMATS = tuple(dict.fromkeys([*registry.suffixes("points"), *OUTPUTS_OF_DOTS]))
EXAMPLES = f"""\
The columns are x, y, z (Å), nx, ny, nz (the normal), area (Å^2, of the surface that the point represents), kind (0 contact,
1 saddle, 2 concave), chain, residue, residue_name, atom_name, atom (its index, from 0) and the fields; numbers are float32. The
points lie exactly on the surface, as far from one another as possible, and have its analytic normals. There are no points in
closed cavities, unless --cavities keep is given. The same structure gives the same bytes on every machine. An npz contains
points and normals, (n, 3) each, and the other columns by name.

{folders.FOLDERS_IN_HELP}
In a Parquet file, `failures` in the metadata states the reasons.

With --groups, the points lie on the surface of the first group alone, and the field burial is their depth (Å) below the surface
of all groups together, 0 where they stay on it: a label of the interface.

examples:
  sparsurf points structures/ -n 1024 -o points.parquet
  sparsurf points protein.pdb run.pdb -o points.parquet
  sparsurf points structures/ --fields roughness,hydropathy -o points.parquet
  sparsurf points protein.pdb -n 512 -o points.npz
  sparsurf points protein.pdb --density 0.5 -o points.ply
  sparsurf points fab_antigen.pdb --groups H,L+G --fields burial -o points.ply
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    folders.add_files(parser, "structure")
    options.add_output(parser, FORMATS)
    size = parser.add_mutually_exclusive_group()
    options.add(size, "n_dots", "-n", meaning="number of points on each structure (default 1024)")
    options.add(size, "density", meaning="number of points per Å^2, instead of --n-dots")
    options.add(parser, "seed", has_default=True)
    help_text = "values at the points: roughness (of the dense surface), %(choices)s, or maps"
    help_text += f" ({' '.join(MAPS)}), with commas between"
    choices = options.SeveralNames("field")
    parser.add_argument("--fields", choices=choices, metavar="NAMES", help=help_text)
    options.add_groups(parser)
    options.add_molecule(parser)
    options.add_placement(parser, " remove")


def run(args: argparse.Namespace) -> None:
    """Write the points."""
    if folders.written(
        args, FORMATS, _computed, check_fields(options.names_of_requested_fields(args), "points")
    ):
        return
    few = _computed(args)
    sparsurf.write(NamedPoints.of_points(title(args.file), few), args.output)
    outputs.report(args, f"{len(few.points):,} points on the surface")


def _computed(args: argparse.Namespace) -> sparsurf.Points:
    """Return the points on FILE."""
    settings = options.given(args, "n_dots", "density", "seed", "groups") | options.placement_options(
        args, "remove"
    )
    settings["fields"] = options.names_of_requested_fields(args)
    source, of_molecule = options.read_spheres_or_atoms(args, "points on")
    if not of_molecule:
        options.say("points on spheres")
    return sparsurf.points(source, **settings, **of_molecule)
