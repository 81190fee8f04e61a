"""`sparsurf roughness`: R_i of every dot."""

from sparsurf.calls import options, outputs
from sparsurf.calls.limits import LENGTH
from sparsurf.calls.patch_calls import roughness
from sparsurf.patches.index import R_PATCH

EXAMPLES = """\
Roughness is the mean cosine between the normals of a patch and their mean: 1 is flat, 0 is rough. In a PLY it is colour and
property.

examples:
  sparsurf roughness protein.pdb -o roughness.ply
  sparsurf roughness dots.csv --r-patch 6 -o roughness.csv
"""


def arguments(parser):
    """Options of the command."""
    parser.add_argument("file", metavar="FILE", help="structure or dots")
    options.add_output(parser, outputs.DOTS_ALONE)
    parser.add_argument(
        "--r-patch",
        type=LENGTH.parse,
        default=R_PATCH,
        help=f"radius of a patch in Å (default {R_PATCH:g})",
    )
    options.add_molecule(parser)


def run(wish):
    """Write the dots with their roughness."""
    outputs.check(wish, outputs.DOTS_ALONE)
    surface, _ = options.read_dots(wish)
    options.say(f"roughness of {len(surface)} dots")
    values = roughness(surface, radius=wish.r_patch, d_link=wish.d_link)
    outputs.write_dots(wish, surface, {"roughness": values}, "roughness")
