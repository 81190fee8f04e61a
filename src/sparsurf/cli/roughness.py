"""`roughness`: R_i of every dot, as a function and as `sparsurf roughness`."""

import pandas as pd

from sparsurf.cli import options, outputs
from sparsurf.cli.inputs import LENGTH, as_index
from sparsurf.patches.index import D_LINK, R_PATCH
from sparsurf.patches.roughness import roughness as roughness_of_dots
from sparsurf.threads import available_cores

EXAMPLES = """\
Roughness is the mean cosine between the normals of a patch and their mean: 1 is flat, 0 is rough. In a PLY it is colour and
property.

examples:
  sparsurf roughness protein.pdb -o roughness.ply
  sparsurf roughness dots.csv --r-patch 6 -o roughness.csv
"""


def roughness(surface, *, radius=R_PATCH, d_link=D_LINK):
    """Local roughness R_i of every dot: the mean cosine between the normals of its patch and their mean.

    Parameters
    ----------
    surface : what `surface` or `read_surface` gave, the path of a file of dots, or the pair (points, normals)
        Normals of a file are brought to unit length, those of the pair must have it.
    radius : float
        R_patch in Å.
    d_link : float
        Å; dots closer than this are linked, and a patch is the largest linked island.

    Returns
    -------
    (N,) float64, 1 is flat and 0 is rough

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> R = sparsurf.roughness(dots)
    >>> R.shape, round(float(R.mean()), 3)
    ((24600,), 0.594)

    Without the files of this project, from arrays:

    >>> R = sparsurf.roughness((dots.points, dots.normals))
    """
    radius = LENGTH.check(radius, "radius")
    return roughness_of_dots(as_index(surface, d_link), radius, available_cores())


def arguments(parser):
    """Options of the command."""
    parser.add_argument("file", metavar="FILE", help="structure or dots")
    options.add_output(parser, outputs.NUMBERS)
    options.add_mesh(parser)
    parser.add_argument(
        "--r-patch",
        type=LENGTH.parse,
        default=R_PATCH,
        help=f"radius of a patch in Å (default {R_PATCH:g})",
    )
    options.add_molecule(parser)


def run(asked):
    """Write the dots with their roughness."""
    outputs.check(asked, outputs.NUMBERS)
    outputs.write_each(asked, _each(asked))


def _each(asked):
    for frame, surface, molecule in options.surfaces(asked):
        values = roughness(surface, radius=asked.r_patch, d_link=asked.d_link)
        table = pd.DataFrame({"roughness": values})
        table = table if molecule is None else table.join(molecule.labels(surface.atom))
        words = f"{len(surface):,} dots, mean roughness {values.mean():.3f}"
        yield frame, outputs.Dots(surface, table, "roughness", words=words)
