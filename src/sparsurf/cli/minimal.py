"""`sparsurf minimal`: the few dots that represent a surface."""

import argparse

from sparsurf.api import writing
from sparsurf.api.inputs import ERROR, NUMBER_OF_DOTS, PERCENT
from sparsurf.api.minimal import DISTANCE, minimal
from sparsurf.cli import options, outputs
from sparsurf.report.numbers import share
from sparsurf.sampling.samplers import SAMPLERS

WIDE = 2.5  # ratio of the ends of an interval, of the number of dots, that calls for a fixed share

EXAMPLES = """\
By default, the smallest subset is kept from which the surface can be recovered 0.02 Å off on average, see --error. The error
is that of the dots that are not kept. `sparsurf recover` makes that surface. The number of dots has a 95 % interval: another
--seed keeps another number in it.

Each dot comes with `dot`, its number on the surface from 0, and `weight`, the number of dots that it stands for. `spacing` is
the distance (Å) of the kept dots around it, and `reach` how far the surface goes on, in spacings.
A .pml opens the dots on their molecule in PyMOL, a .bild as spheres in ChimeraX.

examples:
  sparsurf minimal protein.pdb -o minimal.csv
  sparsurf minimal protein.pdb --n-dots 500 --sampler poisson -o minimal.ply
  sparsurf minimal protein.pdb --percent 10 -o protein.npz
  sparsurf minimal protein.pdb -o minimal.pml
  sparsurf minimal protein.pdb --error 0.05 -o minimal.csv
  sparsurf minimal dots.csv --max-z 1.0 -o minimal.npz
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("file", metavar="FILE", help="structure or dots")
    options.add_output(parser, writing.DOTS_ALONE)
    size = parser.add_mutually_exclusive_group()
    size.add_argument(
        "--percent",
        type=options.number(PERCENT),
        help="share of all dots to keep",
    )
    size.add_argument(
        "--n-dots",
        type=options.number(NUMBER_OF_DOTS),
        help="number of dots to keep; the paper's samplers keep about that many",
    )
    size.add_argument(
        "--error",
        type=options.number(DISTANCE),
        help="keep as few dots as recover the surface this far off on average, Å (default 0.02)",
    )
    size.add_argument(
        "--max-z",
        type=options.number(ERROR),
        help="keep as few dots as have a Z of at most this as they are, not recovered",
    )
    parser.add_argument(
        "--sampler",
        choices=SAMPLERS,
        metavar="SAMPLER",
        default="farthest",
        help=f"how to choose: {', '.join(SAMPLERS)} (default farthest)",
    )
    options.add_seed(parser, "seed of the random numbers, as in a study")
    options.add_fields(parser, "values at the dots: hydropathy, potential, bfactor")
    options.add_d_link(parser)
    options.add_molecule(parser)


def run(args: argparse.Namespace) -> None:
    """Write the chosen dots."""
    outputs.check(args, writing.DOTS_ALONE)
    surface, molecule = options.read_dots(args)
    options.say(f"choosing among {len(surface):,} dots")
    few = minimal(
        options.with_fields(args, surface, molecule),
        percent=args.percent,
        n_dots=args.n_dots,
        error=args.error,
        max_z=args.max_z,
        sampler=args.sampler,
        seed=args.seed,
        d_link=args.d_link,
    )
    words = f"{len(few):,} of {len(surface):,} dots"
    if few.interval:
        ends = " to ".join(share(100 * end / len(surface)) for end in few.interval)
        words += f" ({share(100 * len(few) / len(surface))} %; 95 % interval {ends} %)"
        if few.interval[1] > WIDE * few.interval[0]:
            words += ". The interval is wide: --percent keeps a fixed share"
    outputs.write(args, writing.Dots(few.surface, few.table, "weight", words=words))
