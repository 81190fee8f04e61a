"""`recover`: the dense surface that a few dots with normals give back, as a function and as `sparsurf recover`."""

from types import SimpleNamespace

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.cli import options, outputs
from sparsurf.cli.descriptors import described, table_of
from sparsurf.cli.inputs import DENSITY as DENSITIES
from sparsurf.cli.inputs import Limits, as_surface
from sparsurf.patches.index import D_LINK, R_ZERNIKE, build_index
from sparsurf.recovery.fields import interpolate_fields
from sparsurf.recovery.recovering import NEWTON_STEPS, REACH
from sparsurf.recovery.recovering import recover as recovered_dots
from sparsurf.surfaces.components import fields_without_component
from sparsurf.surfaces.read_surface import read_points, read_surface
from sparsurf.surfaces.spacing import DENSITY, area_of, refuse_sparse
from sparsurf.surfaces.surface import Surface
from sparsurf.threads import available_cores

FARTHEST = 10  # --reach; at 20 dots come 15 Å and more off the surface of a peptide
MOST_STEPS = 1000  # --steps
EXAMPLES = """\
FILE holds a few dots with normals, such as minimal.csv, a .minimal file or the dots of any program. The dots come first, then
those that fill the gaps. Other columns of FILE, such as a potential, are interpolated.
From a tenth of the dots the surface comes back 0.02 Å off on average. Of the dots of the whole surface, 99 % are within 0.12 Å of
it, and the worst is 0.47 Å off. From 2.5 % it is 0.11, 0.50 and 1.02 Å.
--around writes descriptors (|c_nm|, as `sparsurf descriptors`) of patches of the dense surface around points instead.
--mesh writes a closed surface of triangles, as fine as --density says. Holes between the dots are closed, wide ones with a
warning. Dots in clusters give back the surface around the clusters and nothing between them: choose farthest-point or
Poisson-disk dots, or give a --reach of 2.

examples:
  sparsurf minimal protein.pdb --percent 10 -o minimal.csv
  sparsurf recover minimal.csv -o dense.npz
  sparsurf recover minimal.csv --density 20 -o dense.ply
  sparsurf recover minimal.csv --mesh -o mesh.ply
  sparsurf recover minimal.csv --around minimal.csv -o descriptors.csv
"""


def recover(surface, *, density=DENSITY):
    """Dense dots of the surface that a few dots with normals describe; nothing else is needed.

    Parameters
    ----------
    surface : Surface of the few dots, the path of a file of them (what `sparsurf minimal` wrote, say), or the pair
        (points, normals)
    density : float
        Dots per Å^2 requested.

    Returns
    -------
    Surface
        The given dots first, unchanged, then those between them; with the fields of the few, interpolated.

    Examples
    --------
    >>> import numpy as np, sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> kept = sparsurf.sample(dots, percent=10)
    >>> dense = sparsurf.recover((dots.points[kept], dots.normals[kept]))
    >>> len(kept), len(dense)
    (2460, 28470)

    Their distance in Å from the nearest dot of the molecule, whose dots lie about 0.4 Å apart:

    >>> from scipy.spatial import cKDTree
    >>> far = cKDTree(dots.points).query(dense.points)[0]
    >>> round(float(far.mean()), 2)
    0.16
    """
    density, few = DENSITIES.check(density, "density"), as_surface(surface)
    points, normals = recovered_dots(few.points, few.normals, density, threads=available_cores())
    return Surface(points, normals, fields=_fields_of(few, points))


def _fields_of(few, points):
    """Fields of a surface of a few dots at `points`, whose first are these dots; numbers of components are none."""
    fields = fields_without_component(few)
    between = interpolate_fields(few.points, fields, points[len(few) :])
    return {name: np.concatenate([fields[name], values]) for name, values in between.items()}


def arguments(parser):
    """Options of the command."""
    parser.add_argument("file", metavar="FILE", help="dots with normals")
    options.add_output(parser, outputs.DOTS)
    options.add_mesh(parser, mesh=True)
    parser.add_argument(
        "--density",
        type=DENSITIES.parse,
        default=DENSITY,
        help=f"dots per Å^2, at least; up to a third more come (default {DENSITY:g})",
    )
    parser.add_argument(
        "--reach",
        type=Limits(0, FARTHEST).parse,
        default=REACH,
        help=f"how far the surface goes on around a dot, in the spacing of the dots there (default {REACH:g}; 2 "
        "closes holes between uneven dots, more makes dots where no surface is)",
    )
    parser.add_argument(
        "--steps",
        type=Limits(0, MOST_STEPS, whole=True).parse,
        default=NEWTON_STEPS,
        help=f"of Newton at most (default {NEWTON_STEPS})",
    )
    parser.add_argument(
        "--around",
        metavar="POINTS",
        help="CSV with x,y,z in Å, or a file of dots; zeros, and a warning, where no surface is",
    )


def run(asked):
    """Write the dense dots, their triangles, or descriptors of their patches."""
    if asked.mesh and asked.around is not None:
        raise InputError("--around: descriptors are no mesh; leave out --mesh or --around.")
    if asked.plain and (asked.mesh or asked.around is not None):
        other = "--mesh" if asked.mesh else "--around"
        raise InputError(f"--plain is about dots, which {other} does not write; leave out one of the two.")
    outputs.check(
        asked, outputs.TABLES if asked.around is not None else outputs.MESHES if asked.mesh else outputs.DOTS
    )
    few = read_surface(asked.file)
    around = None if asked.around is None else read_points(asked.around)
    if asked.mesh:
        found = _mesh(asked, few)
        outputs.write_dots(asked.output, asked.format, found, binary=asked.binary)
        outputs.wrote(asked, asked.output, f"{found.words} from {len(few):,} dots")
        return
    how = asked.density, asked.reach, asked.steps, available_cores()
    points, normals = recovered_dots(few.points, few.normals, *how)
    if around is not None:
        _describe(asked, points, normals, around)
        return
    outputs.write_dots(
        asked.output, asked.format, _dense(points, normals, few, _to_dms(asked)), asked.plain, asked.binary
    )
    outputs.wrote(asked, asked.output, f"{len(points):,} dots from {len(few):,}")


def _mesh(asked, few):
    from sparsurf.recovery.mesh import recovered_mesh  # here: dots need none of its kernels
    from sparsurf.surfaces.mesh import grid_step_for_density

    how = asked.density, asked.reach, asked.steps, available_cores()
    return outputs.mesh_dots(
        recovered_mesh(few.points, few.normals, grid_step_for_density(asked.density), *how)
    )


def _to_dms(asked):
    return (asked.format or asked.output.lower().removesuffix(".gz").rpartition(".")[2]).lower() == "dms"


def _dense(points, normals, few, to_dms):
    """Dots whose first ones were kept; in a DMS file they belong to one atom of nobody, each with an equal area."""
    n, n_kept = len(points), len(few)
    dense = Surface(points, normals, fields=_fields_of(few, points))
    if to_dms:  # a format without empty places
        dense = Surface(points, normals, np.full(n, area_of(dense)[0] / n), np.zeros(n), np.zeros(n))
    nobody = SimpleNamespace(residue_name=["DOT"], residue=["1"], name=["DOT"], xyz=points[None, :1])
    kept = pd.DataFrame({"kept": (np.arange(n) < n_kept).astype(int)})
    return outputs.Dots(dense, kept, "kept", nobody)


def _describe(asked, points, normals, around):
    """Write the descriptors of the patches around places (T, 3), Å."""
    refuse_sparse(points, D_LINK, f"--density {asked.density:g}", "give a larger --density")
    z = described(build_index(points, normals, D_LINK), around, R_ZERNIKE, True, "--around")
    table = pd.DataFrame(around, columns=["x", "y", "z"]).join(table_of(z))
    outputs.write_table(asked.output, asked.format, table, {"points": around, "z": z})
    outputs.wrote(asked, asked.output, f"{len(z):,} patches")
