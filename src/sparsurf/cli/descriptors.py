"""`descriptors`: what distinguishes one patch from another, as a function and as `sparsurf descriptors`."""

import logging
from argparse import ArgumentTypeError

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.cli import options, outputs
from sparsurf.cli.inputs import LENGTH, Limits, as_array, as_index
from sparsurf.patches.descriptors import DESCRIPTORS, PUBLISHED, describe
from sparsurf.patches.index import D_LINK, R_ZERNIKE
from sparsurf.patches.zernike.polynomials import indices
from sparsurf.threads import available_cores

log = logging.getLogger("sparsurf")

EXAMPLES = """\
A row per patch: the number of its dot, its place, and |c_nm| as z_n_m, by n, then m (121 numbers; npz: `dot`, `points`, `z`).
Two patches are as different as their rows are far apart (Euclid). Take --down for the partner of a complex.

examples:
  sparsurf descriptors protein.pdb --every 100 -o descriptors.csv
  sparsurf descriptors dots.csv --at 0,17,300 -o -
"""


def descriptors(surface, at=None, *, radius=R_ZERNIKE, up=True, d_link=D_LINK, descriptor=PUBLISHED):
    """2D Zernike descriptors of patches.

    Parameters
    ----------
    surface : as in `roughness`
    at : (T,) int dots, (N,) bool, or (T, 3) float places in Å, around which the patches are cut; every dot without
    radius : float
        R_zernike in Å.
    up : bool
        Whether the mean normal of a patch is turned to +z, or to -z as for the partner of a complex.
    d_link : float
        Å; dots closer than this are linked, and a patch is the largest linked island.
    descriptor : {'published', 'rotation_robust'}
        'rotation_robust' hardly changes when the molecule is turned; it does best with a `d_link` of 0.6.

    Returns
    -------
    (T, 121) float64, ``|c_nm|`` by n, then m; zeros where there is no patch, with a warning

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> z = sparsurf.descriptors(dots, [0, 100, 200])
    >>> z.shape
    (3, 121)

    Two patches are as different as their descriptors are far apart:

    >>> import numpy as np
    >>> round(float(np.linalg.norm(z[0] - z[1])), 2)
    1.74
    """
    radius = LENGTH.check(radius, "radius")
    if not isinstance(up, bool | np.bool_):
        raise InputError(f"up is {up!r}; it must be True or False.")
    if descriptor not in list(DESCRIPTORS):  # a list: what a user gives may have no hash
        raise InputError(f"descriptor is {descriptor!r}; it must be one of {', '.join(DESCRIPTORS)}.")
    index = as_index(surface, d_link)
    return described(index, _places(index, at), radius, up, "at", descriptor)


def described(index, places, radius, up, name, descriptor=PUBLISHED):
    """Descriptors (T, 121) of the patches around places (T, 3), called `name`; a warning where there is none."""
    z, sizes = describe(index, places, radius, up, available_cores(), descriptor)
    if n_empty := np.count_nonzero(sizes == 0):
        message = "%s: %d of %d places have no patch, as no dot lies within %g Å; their descriptors are zeros"
        log.warning(message, name, n_empty, len(places), radius)
    return z


def _places(index, at):
    """(T, 3) places, Å, of what `descriptors` takes as `at`."""
    points, n = index.xyz[index.position], len(index.dot)
    if at is None:
        return points
    at = as_array(at, n, "at")
    if at.ndim == 2 and at.shape[1] == 3:
        if at.dtype.kind not in "iuf" or not np.isfinite(at).all():
            raise InputError("at: some of the places are no numbers; leave them out.")
        return np.ascontiguousarray(at, dtype=float)
    if at.ndim != 1 or at.dtype.kind not in "iu":
        raise InputError(
            f"at: give (T,) numbers of dots or (T, 3) places, not {at.dtype} of shape {at.shape}."
        )
    if len(at) and not (at.min() >= 0 and at.max() < n):
        raise InputError(f"at: dots {at.min()} to {at.max()} are asked for, the surface has 0 to {n - 1}.")
    return points[at]


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
    parser.add_argument(
        "--descriptor",
        choices=DESCRIPTORS,
        default=PUBLISHED,
        help="rotation_robust: hardly changes when the molecule is turned (default published)",
    )
    options.add_molecule(parser, several=False)


def run(asked):
    """Write the descriptors."""
    outputs.check(asked, outputs.TABLES)
    surface, _ = options.read_dots(asked)
    at = asked.at if asked.at is not None else np.arange(0, len(surface), asked.every or 1)
    if max(at) >= len(surface):
        raise InputError(f"--at: there is no dot {max(at)}; the surface has 0 to {len(surface) - 1}.")
    how = {"radius": asked.radius, "up": not asked.down, "d_link": asked.d_link}
    z = descriptors(surface, at, **how, descriptor=asked.descriptor)
    place = pd.DataFrame(surface.points[at], columns=["x", "y", "z"])
    place.insert(0, "dot", at)
    table = pd.concat([place, table_of(z)], axis=1)
    arrays = {"dot": np.asarray(at), "points": surface.points[at], "z": z}
    outputs.write_table(asked.output, asked.format, table, arrays)
    outputs.wrote(asked, asked.output, f"{len(at):,} patches")


def table_of(z):
    """DataFrame of descriptors (T, 121), a column for each order."""
    return pd.DataFrame(z, columns=[f"z_{n}_{m}" for n, m in indices()])


def _numbers(text):
    """Numbers of dots, as a list."""
    words = [word.strip() for word in text.split(",")]
    if not all(word.isdigit() for word in words):
        raise ArgumentTypeError(f"{text!r} must be whole numbers from 0 on, such as 0,17,300")
    return [int(word) for word in words]
