"""`sparsurf descriptors`: what distinguishes one patch from another."""

from argparse import ArgumentTypeError

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.calls import options, outputs
from sparsurf.calls.limits import LENGTH, Limits
from sparsurf.calls.patch_calls import descriptors
from sparsurf.patches.index import R_ZERNIKE
from sparsurf.patches.zernike.polynomials import indices

EXAMPLES = """\
A row per patch: the number of its dot, its place, and |c_nm| as z_n_m, by n, then m (121 numbers; npz: `dot`, `points`, `z`).
Two patches are as different as their rows are far apart (Euclid). Take --down for the partner of a complex.

examples:
  sparsurf descriptors protein.pdb --every 100 -o descriptors.csv
  sparsurf descriptors dots.csv --at 0,17,300 -o -
"""


def arguments(parser):
    """Options of the command."""
    parser.add_argument("file", metavar="FILE", help="structure or dots")
    options.add_output(parser, outputs.TABLES)
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--at", type=_numbers, help="numbers of the dots, from 0, such as 0,17,300 (default: every dot)"
    )
    where.add_argument("--every", type=Limits(0, whole=True).parse, help="every n-th dot")
    parser.add_argument(
        "--radius",
        type=LENGTH.parse,
        default=R_ZERNIKE,
        help=f"of a patch in Å (default {R_ZERNIKE:g})",
    )
    parser.add_argument("--down", action="store_true", help="turn the mean normal to -z instead of +z")
    options.add_molecule(parser)


def run(wish):
    """Write the descriptors."""
    outputs.check(wish, outputs.TABLES)
    surface, _ = options.read_dots(wish)
    at = wish.at if wish.at is not None else np.arange(0, len(surface), wish.every or 1)
    if max(at) >= len(surface):
        raise InputError(f"--at: there is no dot {max(at)}; the surface has 0 to {len(surface) - 1}.")
    options.say(f"descriptors of {len(at)} patches")
    z = descriptors(surface, at, radius=wish.radius, up=not wish.down, d_link=wish.d_link)
    names = [f"z_{n}_{m}" for n, m in indices()]
    place = pd.DataFrame(surface.points[at], columns=["x", "y", "z"])
    table = pd.concat([pd.Series(at, name="dot"), place, pd.DataFrame(z, columns=names)], axis=1)
    outputs.write_table(wish, table, {"dot": np.asarray(at), "points": surface.points[at], "z": z})


def _numbers(text):
    """Numbers of dots, as a list."""
    words = [word.strip() for word in text.split(",")]
    if not all(word.isdigit() for word in words):
        raise ArgumentTypeError(f"{text!r} must be whole numbers from 0 on, such as 0,17,300")
    return [int(word) for word in words]
