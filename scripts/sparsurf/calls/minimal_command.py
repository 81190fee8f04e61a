"""`sparsurf minimal`: the few dots that stand for a surface."""

import numpy as np

from sparsurf import InputError
from sparsurf.calls import options, outputs
from sparsurf.calls.subset_calls import prepare
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study.minimal import minimal_subset
from sparsurf.surfaces.surface import Surface

EXAMPLES = """\
Each dot comes with `dot`, its number on the surface from 0, in the order of choice, and `weight`, the number of dots of the
surface that it stands for.

examples:
  sparsurf minimal protein.pdb -o minimal.csv
  sparsurf minimal protein.pdb --dots 500 --sampler poisson -o minimal.ply
  sparsurf minimal dots.csv --z 1.0 -o minimal.npz
"""
PERCENT = 20.0


def arguments(parser):
    """Options of the command."""
    parser.add_argument("file", metavar="FILE", help="structure or dots")
    options.add_output(parser, outputs.DOTS_ALONE)
    size = parser.add_mutually_exclusive_group()
    size.add_argument(
        "--percent",
        type=options.number(0, 100),
        default=PERCENT,
        help=f"of the dots to keep (default {PERCENT:g})",
    )
    size.add_argument("--dots", type=options.number(0, whole=True), help="number of dots to keep")
    size.add_argument("--z", type=options.number(0, open_low=False), help="keep as few dots as reach this Z")
    parser.add_argument(
        "--sampler", choices=SAMPLERS, default="farthest", help="how to choose (default farthest)"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the random numbers (default 0)")
    options.add_molecule(parser)


def run(wish):
    """Write the chosen dots."""
    surface, _ = options.read_dots(wish)
    options.say(f"choosing among {len(surface)} dots")
    ready = prepare(surface, d_link=wish.d_link, seed=wish.seed)
    if wish.dots is not None and wish.dots > len(surface):
        raise InputError(f"--dots: {wish.dots} are more than the {len(surface)} dots of the surface.")
    n = wish.dots or (None if wish.z is not None else max(1, round(wish.percent / 100 * len(surface))))
    dots, weight = minimal_subset(ready, wish.sampler, n, wish.z)
    kept = Surface(*(getattr(surface, name)[dots] for name in Surface.__dataclass_fields__))
    outputs.write_dots(wish, kept, {"dot": np.asarray(dots), "weight": weight}, "weight")
