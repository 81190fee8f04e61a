"""`sparsurf recover`: the dense surface that is reconstructed from a few dots with normals."""

from __future__ import annotations

import argparse
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd

import sparsurf
from sparsurf.api import writing
from sparsurf.api.page_metadata import heard
from sparsurf.api.replacing import beside_mesh
from sparsurf.arguments import INTERPOLANT, MODELS
from sparsurf.cli import options, outputs
from sparsurf.cli.descriptors import descriptor_table
from sparsurf.errors import InputError
from sparsurf.files import ends_in
from sparsurf.surfaces.read_surface import read_points

EXAMPLES = """\
FILE contains a few dots with normals, such as minimal.csv, or the dots of any program. The result contains these dots first and
then the new dots between them. Other columns of FILE, such as a potential, are interpolated.
Every dot of a molecular surface lies on a sphere of known radius, and the atoms follow from few dots with their normals. Where
dots lie on the inferred atoms, the surface is the one that a probe rolls over them, and elsewhere it is interpolated;
--reconstruction interpolant never infers atoms: with it, 0.6 evenly spread dots per Å^2 give a mean error of about 0.02 Å, 99 %
of the surface deviates by less than 0.11 Å, and the largest deviation is about 0.5 Å. FILE may name the probe radius, the
atomic radii and the reconstruction; otherwise the dots tell them.
--at writes, instead of dots, the descriptors (|c_nm|, as in `sparsurf descriptors`) of the patches of the dense surface around
the given points.
A .html file is a page, and a .png file a picture.
--mesh writes a closed surface of triangles, with --density vertices per Å^2 or the fineness of a --step. For a NAME.vert, they
stand in a NAME.face next to it, which replaces only triangles of a NAME.vert. The mesh closes holes between
the dots, and warns of wide holes. If the dots lie in clusters, the surface is reconstructed around the clusters only: choose
dots by farthest-point or Poisson-disk sampling, or give a --reach of 2.

examples:
  sparsurf minimal protein.pdb --percent 10 -o minimal.csv
  sparsurf recover minimal.csv -o dense.npz
  sparsurf recover minimal.csv --density 20 -o dense.ply
  sparsurf recover minimal.csv --mesh -o mesh.ply
  sparsurf recover minimal.csv --at minimal.csv -o descriptors.csv
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    options.add_file(parser, "dots with normals")
    options.add_output(parser, writing.SUFFIXES_OF_DOTS)
    parser.add_argument(
        "--mesh", action="store_true", help="write a closed mesh of triangles instead of dots"
    )
    options.add_colours(parser)
    options.add_limits(parser)
    help_text = "dots per Å^2; up to a third more where the surface is interpolated (default 5.35); with --mesh, vertices"
    options.add(parser, "density", meaning=help_text)
    options.add_size_of_mesh(parser)
    options.add(parser, "reach")
    options.add(parser, "steps")
    options.add_reconstruction(
        parser,
        "auto (default) uses the inferred atoms if they explain the dots, interpolant never does, and spheres "
        "refuses dots that do not lie on spheres",
    )
    parser.add_argument(  # of earlier versions
        "--model", action=options.ModelOrNumber, choices=MODELS, default=None, help=argparse.SUPPRESS
    )
    parser.add_argument(
        "--at",
        metavar="POINTS",
        help="CSV with x,y,z in Å, or a file of dots, at which descriptors are computed (zeros where there is no surface)",
    )


def run(args: argparse.Namespace) -> None:
    """Write the dense dots, their triangles, or descriptors of their patches."""
    if args.mesh and args.steps is not None:
        raise InputError("--steps applies to dots, and --mesh writes triangles; leave out one of the two.")
    if args.mesh and args.at is not None:
        raise InputError(
            "--at writes descriptors, and --mesh writes triangles; leave out one of the two options."
        )
    options.refuse_size_of_mesh(args)
    formats = (
        writing.TABLE_FORMATS
        if args.at is not None
        else writing.OUTPUTS_OF_MESH
        if args.mesh
        else writing.OUTPUTS_OF_DOTS
    )
    outputs.check(args, formats, beside_mesh(args.output) if args.mesh else None)
    with heard(args.file) as args.heard:
        few = sparsurf.read_surface(args.file)
    options.say(f"surface reconstructed from {len(few):,} dots")
    points_at = None if args.at is None else read_points(args.at)
    ways = options.given(args, "reach", "reconstruction", "density")
    if args.mesh:
        made = sparsurf.mesh(few, **ways, **options.given(args, "n_vertices", "step"))
        triangles = writing.mesh_dots(made)
        message = f"{triangles.message} from {len(few):,} dots"
        about = options.about(args)
        outputs.write_output(args, replace(triangles, coloured=args.colours, message=message, about=about))
        return
    dense = sparsurf.recover(few, **ways, **options.given(args, "steps"))
    if points_at is not None:
        z = sparsurf.descriptors(dense, points_at)
        table = pd.DataFrame(points_at, columns=["x", "y", "z"]).join(descriptor_table(z))
        writing.write_table(args.output, table, {"points": points_at, "z": z})
        outputs.report(args, f"{len(z):,} patches")
        return
    assert dense.recovered is not None
    message, share = f"{len(dense):,} dots from {len(few):,}", dense.recovered.on_spheres
    if args.reconstruction != INTERPOLANT:
        on_spheres = f"{100 * share:.0f} % of these" if share else "none of these"
        message += f"; {on_spheres} lie on spheres of inferred atoms"
    dots = replace(writing.recovered_dots(dense), shown="kept", message=message, about=options.about(args))
    if ends_in(args.output, ".dms"):  # a format without empty columns: the dots belong to one dummy atom
        atom = SimpleNamespace(residue_name=["DOT"], residue=["1"], name=["DOT"], xyz=dense.points[None, :1])
        n = len(dense)
        bare = sparsurf.Surface(dense.points, dense.normals, dense.area, np.zeros(n), np.zeros(n))
        dots = replace(dots, surface=bare, molecule=atom)
    outputs.write_output(args, dots)
