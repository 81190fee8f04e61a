"""`sparsurf descriptors`: numbers that distinguish one patch from another."""

import argparse

import numpy as np
import pandas as pd

import sparsurf
from sparsurf.api import writing
from sparsurf.arguments import Limits
from sparsurf.cli import options, outputs

PUBLISHED = "published"
OF_MOMENTS = (PUBLISHED, "rotation_robust")  # descriptors whose numbers are magnitudes of moments
MAX_ORDER = 20

EXAMPLES = """\
The table has a row for each patch: the number of its dot, its position, and the columns z_n_m, which are the 121 magnitudes
|c_nm|, ordered by n, then by m (in an npz: `dot`, `points`, `z`); a descriptor of your own has the columns z_0, z_1, ...
The Euclidean distance between two rows says how different the patches are. Use --down for one partner of a complex.

examples:
  sparsurf descriptors protein.pdb --every 100 -o descriptors.csv
  sparsurf descriptors dots.csv --at 0,17,300 -o -
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    options.add_file(parser, "structure or dots")
    options.add_output(parser, writing.TABLE_FORMATS)
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--at",
        type=_numbers,
        help="numbers of the dots at the centres of patches, from 0, such as 0,17,300 (default: all)",
    )
    options.add_residues(where)
    parser.add_argument(
        "--every", type=options.number_within(Limits(0, whole=True)), help="use only every n-th of these dots"
    )
    options.add(parser, "r_zernike", has_default=True)
    parser.add_argument(
        "--down",
        action="store_true",
        help="rotate each patch so that its mean normal points to -z instead of +z",
    )
    parser.add_argument(
        "--descriptor",
        choices=options.Names("descriptor"),
        metavar="DESCRIPTOR",
        default=PUBLISHED,
        help="numbers that describe a patch: %(choices)s (default published); rotation_robust changes very little when the "
        "molecule is rotated",
    )
    options.add(parser, "d_link", has_default=True)
    options.add_molecule(parser)
    options.add_placement(parser, " keep", "reentrant")


def run(args: argparse.Namespace) -> None:
    """Write the descriptors."""
    outputs.check(args, writing.TABLE_FORMATS)
    surface, molecule = options.read_dots(args)
    dots = options.dots_of_residues(args, surface, molecule) if args.at is None else np.asarray(args.at)
    dots = dots[:: args.every or 1]
    options.say(f"descriptors of {len(dots):,} patches")
    z = sparsurf.descriptors(
        surface,
        dots,
        r_zernike=args.r_zernike,
        up=not args.down,
        d_link=args.d_link,
        descriptor=args.descriptor,
    )
    points = surface.points[dots]
    table = pd.DataFrame({"dot": dots}).join(pd.DataFrame(points, columns=["x", "y", "z"]))
    arrays = {"dot": dots, "points": points, "z": z}
    writing.write_table(args.output, table.join(descriptor_table(z, args.descriptor)), arrays)
    outputs.report(args, f"{len(dots):,} patches")


def descriptor_table(z: np.ndarray, descriptor: str = PUBLISHED) -> pd.DataFrame:
    """Return a table of descriptors (T, width): columns z_n_m for those of the library, which are moments, else z_0, z_1, ..."""
    moments = [f"{n}_{m}" for n in range(MAX_ORDER + 1) for m in range(n % 2, n + 1, 2)]
    orders = moments if descriptor in OF_MOMENTS else range(z.shape[1])
    return pd.DataFrame(z, columns=[f"z_{order}" for order in orders])


def _numbers(text: str) -> list[int]:
    """Parse numbers of dots."""
    items = [word.strip() for word in text.split(",")]
    if not all(word.isdigit() for word in items):
        raise argparse.ArgumentTypeError(f"{text!r} must be whole numbers from 0 on, such as 0,17,300")
    return [int(word) for word in items]
