"""`sparsurf minimal`: the few dots that stand for a surface."""

from dataclasses import replace

import numpy as np

from sparsurf import InputError
from sparsurf.calls import options, outputs
from sparsurf.calls.limits import PERCENT, SEED, Limits
from sparsurf.calls.subset_calls import prepare
from sparsurf.calls.surface_calls import rules_of
from sparsurf.recovery.readings import RECOVERED
from sparsurf.recovery.recovering import REACH, spacing_of
from sparsurf.recovery.settling import settle
from sparsurf.sampling.samplers import SAMPLERS, weights
from sparsurf.study.evaluator import number_of_tests
from sparsurf.study.floors import FRESH, floors
from sparsurf.study.minimal import minimal_subset
from sparsurf.study.minimal_by_floor import enough_dots, smallest
from sparsurf.surfaces.making import fitting_density, molecular_surface
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.surface import Surface

EXAMPLES = """\
Without --percent, --dots or --z as few dots are kept as give the surface back: described from the surface recovered from
them, patches differ no more than from other dots of the same surface, within a tenth (as `minimal: {floor: fresh dots}` of
a study does). `sparsurf recover` makes that surface. Of a structure, the other dots are laid on its atoms anew; of a file
of dots, they come from the surface that all of these give back and differ less, so that more dots are kept. Z falls slowly
there: another --seed, with other test dots, may keep half or twice as many, of a short peptide a fifth or five times.

Each dot comes with `dot`, its number on the surface from 0, in the order of choice; `weight`, the number of dots of the
surface that it stands for; `spacing` (Å) of the kept dots around it, and `reach` (in spacings), how far the surface goes on.

With --settle the dots leave their places a little: they are not dots of the surface any more, but fewer give it back.

examples:
  sparsurf minimal protein.pdb -o minimal.csv
  sparsurf minimal protein.pdb --dots 500 --sampler poisson -o minimal.ply
  sparsurf minimal dots.csv --z 1.0 -o minimal.npz
"""
TESTS = 200  # test dots, as in a study


def arguments(parser):
    """Options of the command."""
    parser.add_argument("file", metavar="FILE", help="structure or dots")
    options.add_output(parser, outputs.DOTS_ALONE)
    size = parser.add_mutually_exclusive_group()
    size.add_argument(
        "--percent", type=PERCENT.parse, help="of the dots to keep (default: as few as suffice)"
    )
    size.add_argument(
        "--dots",
        type=Limits(0, whole=True).parse,
        help="number of dots to keep; of the paper's samplers, as of --percent, about so many",
    )
    size.add_argument("--z", type=Limits(0, open_low=False).parse, help="keep as few dots as reach this Z")
    parser.add_argument(
        "--sampler", choices=SAMPLERS, default="farthest", help="how to choose (default farthest)"
    )
    parser.add_argument(
        "--settle",
        action="store_true",
        help="move the dots off their places, so that the surface recovered from them comes nearer to the whole one",
    )
    parser.add_argument(
        "--seed",
        type=SEED.parse,
        default=0,
        help="of the random numbers (default 0); `sample` of Python draws others with it",
    )
    options.add_molecule(parser)


def run(wish):
    """Write the chosen dots."""
    outputs.check(wish, outputs.DOTS_ALONE)
    surface, molecule = options.read_dots(wish)
    options.say(f"choosing among {len(surface)} dots")
    ready = prepare(surface, d_link=wish.d_link, seed=wish.seed)
    if wish.dots is not None and wish.dots > len(surface):
        raise InputError(f"--dots: {wish.dots} are more than the {len(surface)} dots of the surface.")
    if wish.dots is wish.z is wish.percent is None:
        dots = _as_few_as_suffice(wish, ready, molecule)
        weight = weights(ready.points, dots)
    else:
        n = wish.dots or (None if wish.z is not None else max(1, round(wish.percent / 100 * len(surface))))
        dots, weight = minimal_subset(ready, wish.sampler, n, wish.z)
    kept = Surface(*(getattr(surface, name)[dots] for name in Surface.__dataclass_fields__))
    if wish.settle:
        better = settle(kept.points, kept.normals, surface.points, surface.normals, threads=ready.threads)
        kept = replace(kept, points=better[0], normals=better[1])
    spacing = spacing_of(kept.points, kept.normals)
    columns = {
        "dot": np.asarray(dots),
        "weight": weight,
        "spacing": spacing,
        "reach": np.full(len(kept), REACH),
    }
    outputs.write_dots(wish, kept, columns, "weight")


def _as_few_as_suffice(wish, ready, molecule):
    """The smallest subset whose recovered Z is within a tenth of that of fresh dots; of a structure, these lie on its atoms."""
    own = {}
    if molecule is not None:
        sizes = radii(molecule, wish.radii)
        rules = rules_of(wish.probe, wish.density or "auto")
        density = fitting_density(molecule, wish.frame, sizes, rules, wish.d_link, "surface", tell=False)
        own = {
            "lay": lambda xyz: molecular_surface(xyz, sizes, wish.probe, density),
            "atoms": molecule.xyz[wish.frame],
        }
    n_tests = number_of_tests(TESTS, len(ready.points))
    found = floors(ready, n_tests, **own, moved=())
    enough = enough_dots(ready, wish.sampler, found, n_tests, readings=(RECOVERED,), settled=wish.settle)
    dots = smallest(ready, wish.sampler, found, FRESH, enough, n_tests, settled=wish.settle)
    options.say(
        f"{len(dots)} dots suffice: the surface recovered from them has the Z of other dots of the same surface, "
        f"{found.set_index('floor').loc[FRESH, 'Z']:.2f}, within a tenth"
    )
    return dots
