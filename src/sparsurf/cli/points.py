"""`sparsurf points`: a few points with normals on the surface of a structure, or of every structure of a folder."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

from sparsurf import kinds
from sparsurf.api.inputs import is_file_of_spheres
from sparsurf.api.parts import store_beside
from sparsurf.api.points import JOBS, N_POINTS, TABLE_FORMAT, points, points_of, write_table_of_points
from sparsurf.api.writing import PAGE_FORMATS, SCRIPTS, SUFFIXES_OF_DOTS, write, write_file
from sparsurf.arguments import DENSITY_LIMITS, NUMBER_OF_DOTS
from sparsurf.cli import options, outputs
from sparsurf.dot_fields.maps import MAPS
from sparsurf.errors import InputError
from sparsurf.files import pluralise
from sparsurf.molecules.formats import title
from sparsurf.surfaces.chosen_points import NamedPoints

FORMATS = tuple(dict.fromkeys([*kinds.suffixes("points"), *SUFFIXES_OF_DOTS, *SCRIPTS, *PAGE_FORMATS]))
EXAMPLES = """\
FILE is a structure, a folder of structures, or several structures. The points of all structures of a folder or of several
files are written into one Parquet table. Its columns are name (of the structure), x, y, z (Å), nx, ny, nz (the normal), area
(Å^2, of the surface that the point represents), kind (0 contact, 1 saddle, 2 concave), chain, residue, residue_name,
atom_name, atom (its index, from 0) and the fields; numbers are float32. The points lie exactly on the surface, as far from one
another as possible, and have its analytic normals. There are
no points in closed cavities, unless --cavities keep is given. Options of atoms choose those of one structure; a folder is read
as it is. The same structure gives the same bytes on every machine. An npz contains points and normals, (n, 3)
each, and the other columns by name. Structures of a folder that cannot be read are left out; a warning at the end and `failures`
in the metadata of the table state the reasons. A call for a folder that was stopped continues from the structures that were
finished, and writes the same bytes.

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
    help_text = "structure, folder of structures, or several structures"
    parser.add_argument("files", nargs="+", metavar="FILE", help=help_text)
    options.add_output(parser, FORMATS)
    size = parser.add_mutually_exclusive_group()
    size.add_argument(
        "-n",
        "--n-dots",
        type=options.number_within(NUMBER_OF_DOTS),
        help=f"number of points on each structure (default {N_POINTS})",
    )
    size.add_argument(
        "--density",
        type=options.number_within(DENSITY_LIMITS),
        help="number of points per Å^2, instead of --n-dots",
    )
    options.add_seed(parser, "seed that chooses the first point, from which all others follow")
    help_text = "values at the points: roughness (of the dense surface), %(choices)s, or maps"
    help_text += f" ({' '.join(MAPS)}), with commas between"
    choices = options.SeveralNames("field")
    parser.add_argument("--fields", choices=choices, metavar="NAMES", help=help_text)
    options.add_groups(parser)
    options.add_molecule(parser)
    options.add_placement(parser, " remove")
    parser.add_argument(
        "--jobs",
        type=options.number_within(JOBS),
        default=1,
        help="number of processes for a folder (default 1)",
    )


def run(args: argparse.Namespace) -> None:
    """Write the points."""
    is_folder = len(args.files) > 1 or Path(args.files[0]).is_dir()
    formats = (TABLE_FORMAT,) if is_folder else FORMATS
    args.file = args.files[-1]
    outputs.check(args, formats)
    if not is_folder and not is_file_of_spheres(args.file) and not options.reads_atoms(args):
        raise InputError(f"{args.file} is neither a structure by its content nor a folder.")
    settings = {"density": args.density, "seed": args.seed, **options.placement_options(args, "remove")}
    settings["fields"] = options.names_of_requested_fields(args)
    if is_folder or is_file_of_spheres(args.file):
        args.file = args.file if len(args.files) == 1 else "the list of files"
        options.refuse_structure_options(args, "structures" if is_folder else "spheres")
    if is_folder:
        of_all = args.files if len(args.files) > 1 else args.files[0]
        results = points_of(of_all, args.n_dots, jobs=args.jobs, **settings)
        written: list[int] = []
        with store_beside(os.path.realpath(args.output), "structures") as store:
            tables = results.stored(store, args.output)
            failures = results.failures
            write_file(
                args.output,
                formats,
                {TABLE_FORMAT: lambda path: write_table_of_points(path, tables, written, failures)},
            )
        message = f"{sum(written):,} points on {pluralise(len(written), 'structure')}"
        verb = "was" if results.n_before == 1 else "were"
        message += f", of which {results.n_before} {verb} finished before" if results.n_before else ""
        left_out = pluralise(len(results.failures), "structure")
        outputs.report(args, message + (f"; {left_out} left out" if results.failures else ""))
        return
    source: Any = args.file
    if not is_file_of_spheres(args.file):
        source = options.read_atoms(args)
        settings |= {"frame": args.frame or 0, "groups": args.groups}
    options.say(f"points on {source.n_atoms:,} atoms" if hasattr(source, "n_atoms") else "points on spheres")
    few = points(source, args.n_dots, **settings)
    write(NamedPoints.of_points(title(args.file), few), args.output)
    outputs.report(args, f"{len(few.points):,} points on the surface")
