"""`sparsurf recover`: the dense surface that a few dots with normals give back."""

from types import SimpleNamespace

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.calls import limits, options, outputs
from sparsurf.calls.patch_calls import described
from sparsurf.patches.index import D_LINK, R_ZERNIKE, build_index
from sparsurf.patches.zernike.polynomials import indices
from sparsurf.recovery.mesh import recovered_mesh
from sparsurf.recovery.recovering import REACH, STEPS, recover
from sparsurf.surfaces.mesh import step_of
from sparsurf.surfaces.reading import read_places, read_surface
from sparsurf.surfaces.spacing import DENSITY, area_of, refuse_sparse
from sparsurf.surfaces.surface import Surface
from sparsurf.threads import available_cores

FARTHEST = 10  # --reach; at 20 dots come 15 Å and more off the surface of a peptide
MOST_STEPS = 1000  # --steps
EXAMPLES = """\
FILE holds a few dots with normals, such as minimal.csv, minimal.ply or the dots of any program; nothing else is needed.
The dots come first, then those that fill the gaps. With --around, descriptors (|c_nm|, as of `sparsurf descriptors`) of the
patches of the dense surface around points come instead of dots; with --mesh, a closed surface of triangles, as fine as
--density says; holes between the dots are closed, wide ones with a warning. Dots in clusters give the surface around the
clusters back, and nothing between them: choose farthest-point or Poisson-disk dots, or give a --reach of 2.

examples:
  sparsurf minimal protein.pdb --percent 10 -o minimal.csv
  sparsurf recover minimal.csv -o dense.npz
  sparsurf recover minimal.csv --density 20 -o dense.ply
  sparsurf recover minimal.csv --mesh -o mesh.ply
  sparsurf recover minimal.csv --around minimal.csv -o descriptors.csv
"""


def arguments(parser):
    """Options of the command."""
    parser.add_argument("file", metavar="FILE", help="dots with normals")
    formats = (*outputs.DOTS_ALONE, ".dms")
    options.add_output(parser, formats, "triangles of the surface, watertight, instead of dots (PLY)")
    parser.add_argument(
        "--density",
        type=limits.DENSITY.parse,
        default=DENSITY,
        help=f"dots per Å^2, at least; up to a third more come (default {DENSITY:g})",
    )
    parser.add_argument(
        "--reach",
        type=limits.Limits(0, FARTHEST).parse,
        default=REACH,
        help=f"how far the surface goes on around a dot, in the spacing of the dots there (default {REACH:g}; 2 "
        "closes holes between uneven dots, more makes dots where no surface is)",
    )
    parser.add_argument(
        "--steps",
        type=limits.Limits(0, MOST_STEPS, whole=True).parse,
        default=STEPS,
        help=f"of Newton at most (default {STEPS})",
    )
    parser.add_argument(
        "--around",
        metavar="POINTS",
        help="CSV with x,y,z in Å, or a file of dots; zeros, and a warning, where no surface is",
    )


def run(wish):
    """Write the dense dots, or descriptors of their patches."""
    if wish.mesh and wish.around:
        raise InputError("--around: descriptors are no mesh; leave out --mesh or --around.")
    outputs.check(wish, outputs.TABLES if wish.around else outputs.DOTS)
    few = read_surface(wish.file)
    around = read_places(wish.around) if wish.around else None
    if wish.mesh:
        how = wish.density, wish.reach, wish.steps, available_cores()
        mesh = recovered_mesh(few.points, few.normals, step_of(wish.density), *how)
        options.say(f"{len(mesh.triangles)} triangles from {len(few)} dots, {mesh.volume:.0f} Å^3")
        outputs.write_mesh(wish, mesh)
        return
    points, normals = recover(
        few.points, few.normals, wish.density, wish.reach, wish.steps, available_cores()
    )
    options.say(f"{len(points)} dots from {len(few)}")
    if around is not None:
        _describe(wish, points, normals, around)
        return
    n = len(points)
    kept = np.concatenate([np.ones(len(few), int), np.zeros(n - len(few), int)])
    dense = Surface(points, normals)
    suffix = wish.format or wish.output.removesuffix(".gz").rpartition(".")[2]
    if suffix.lower() == "dms":  # a format without empty places
        dense = Surface(points, normals, np.full(n, area_of(dense)[0] / n), np.zeros(n), np.zeros(n))
    nobody = SimpleNamespace(residue_name=["DOT"], residue=["1"], name=["DOT"], xyz=points[None, :1])
    outputs.write_dots(SimpleNamespace(**vars(wish) | {"frame": 0}), dense, {"kept": kept}, "kept", nobody)


def _describe(wish, points, normals, around):
    """Write the descriptors of the patches around places (T, 3), Å."""
    refuse_sparse(points, D_LINK, f"--density {wish.density:g}", "give a larger --density")
    z = described(build_index(points, normals, D_LINK), around, R_ZERNIKE, True, "--around")
    names = ["x", "y", "z", *(f"z_{n}_{m}" for n, m in indices())]
    table = pd.DataFrame(np.hstack([around, z]), columns=names)
    outputs.write_table(wish, table, {"points": around, "z": z})
