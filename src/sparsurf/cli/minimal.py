"""`minimal`, `floors` and `settle`: the few dots that stand for a surface, as functions and as `sparsurf minimal`."""

from dataclasses import replace

from sparsurf import InputError
from sparsurf.cli import options, outputs
from sparsurf.cli.inputs import (
    PERCENT,
    SEED,
    Limits,
    agreed,
    as_molecule,
    as_surface,
    has_atoms,
    placed_already,
)
from sparsurf.cli.making import rules_of, surface
from sparsurf.cli.subsets import prepare
from sparsurf.patches.index import D_LINK
from sparsurf.recovery.relaxation import relax as settled_places
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study.floors import FRESH
from sparsurf.study.floors import noise_floors as measured_floors
from sparsurf.study.minimal_subset import select_minimal_subset
from sparsurf.study.prepared_surface import number_of_tests
from sparsurf.study.required_dots import Trials
from sparsurf.surfaces.molecular_surface import surface_generator
from sparsurf.surfaces.radii import radii as atomic_radii
from sparsurf.surfaces.surface import Surface
from sparsurf.threads import available_cores

EXAMPLES = """\
Without --percent, --dots or --z, as few dots are kept as give the surface back: the surface recovered from them differs from
the whole no more than other dots of the same surface do, within a tenth. `sparsurf recover` makes that surface. For a
structure, the other dots are placed on its atoms. For a file of dots they come from the recovered surface and differ less, so
that more dots are kept. Z falls slowly there: another --seed may keep half or twice as many dots.

Each dot comes with `dot`, its number on the surface from 0, and `weight`, the number of dots that it stands for. `spacing` is
the distance (Å) of the kept dots around it, and `reach` how far the surface goes on, in spacings.
A file named .minimal holds places and normals in 12 bytes a dot.

With --settle the dots leave their places a little: they are no longer dots of the surface, but fewer give it back.

examples:
  sparsurf minimal protein.pdb -o minimal.csv
  sparsurf minimal protein.pdb --dots 500 --sampler poisson -o minimal.ply
  sparsurf minimal protein.pdb --percent 10 -o protein.minimal
  sparsurf minimal dots.csv --z 1.0 -o minimal.npz
"""
TESTS = 200  # test dots, as in a study
DEFAULT_SEED = 20261120  # as in a study
NUMBER = Limits(0, whole=True)
Z = Limits(0, open_low=False)


def minimal(
    given,
    *,
    percent=None,
    n=None,
    z=None,
    sampler="farthest",
    settle=False,
    seed=DEFAULT_SEED,
    frame=0,
    probe=1.4,
    density="auto",
    radii="dms",
    d_link=D_LINK,
    cavities="keep",
):
    """The few dots that stand for a surface: those that a study and the command hand out for the same file and seed.

    Parameters
    ----------
    given : path of a structure, a molecule, or dots as in `prepare`
        Without a size, other dots are placed on the atoms; for dots of a file they come from the recovered surface.
    percent, n, z : float, int, float, at most one of them
        Of the dots; their number; the Z to reach. Without: as few as give the surface back.
    sampler : str
        As in `sample`.
    settle : bool
        Whether the dots leave their places a little, so that fewer give the surface back.
    seed : int
    frame, probe, density, radii, d_link, cavities : as in `surface`

    Returns
    -------
    Subset
        `dots` (n,), `weight` (n,), `surface` of the kept dots, and `table`, a DataFrame.

    Examples
    --------
    >>> import sparsurf
    >>> few = sparsurf.minimal("data/tdp43/topology.pdb", percent=10)
    >>> len(few.dots), list(few.table)[:4]
    (2460, ['dot', 'x', 'y', 'z'])
    """
    limits = {"percent": ("n_S_percent", percent, PERCENT), "n": ("n_S", n, NUMBER), "z": ("Z", z, Z)}
    wishes = {
        key: limit.check(value, name) for name, (key, value, limit) in limits.items() if value is not None
    }
    if len(wishes) > 1:
        raise InputError("minimal: give only one of percent, n and z.")
    how = {"probe": probe, "density": density, "radii": radii, "d_link": d_link, "cavities": cavities}
    dots, own, molecule = _dots_of(given, frame, how)
    if n is not None and n > len(dots):
        raise InputError(f"minimal: n is {n}, more than the {len(dots)} dots of the surface.")
    return chosen(dots, own, molecule, wishes, sampler, bool(settle), seed, d_link)


def floors(
    given,
    *,
    seed=DEFAULT_SEED,
    frame=0,
    probe=1.4,
    density="auto",
    radii="dms",
    d_link=D_LINK,
    cavities="keep",
):
    """Noise floors: Z between two descriptions of one surface.

    Parameters
    ----------
    given, seed, frame, probe, density, radii, d_link, cavities : as in `minimal`

    Returns
    -------
    DataFrame
        floor, Z, se, low, high (95 %), draws, test_dots: other dots of the surface, of the turned molecule, and, for a
        structure, of moved atoms.

    Examples
    --------
    >>> import sparsurf
    >>> table = sparsurf.floors("protein.pdb")  # doctest: +SKIP
    """
    how = {"probe": probe, "density": density, "radii": radii, "d_link": d_link, "cavities": cavities}
    dots, own, _ = _dots_of(given, frame, how)
    ready = prepare(dots, d_link=d_link, seed=seed)
    return measured_floors(ready, number_of_tests(TESTS, len(dots)), *own)


def settle(few, surface):
    """Kept dots moved a little, so that the surface recovered from them comes nearer to the whole one.

    Parameters
    ----------
    few, surface : dots, as in `prepare`

    Returns
    -------
    Surface

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> few = dots.take(sparsurf.sample(dots, percent=2))
    >>> better = sparsurf.settle(few, dots)
    >>> bool(0.01 < abs(better.points - few.points).mean() < 0.5)
    True
    """
    few, whole = as_surface(few), as_surface(surface)
    places = settled_places(few.points, few.normals, whole.points, whole.normals, threads=available_cores())
    return replace(few, points=places[0], normals=places[1])


def chosen(dots, own, molecule, wishes, sampler, settled, seed, d_link):
    """The Subset of dots; `own` is of `layer`, `wishes` as in the config's `minimal`."""
    ready = prepare(dots, d_link=d_link, seed=seed)
    trials = Trials(ready, sampler, number_of_tests(TESTS, len(dots)), relaxed=settled)
    found = None if wishes else measured_floors(ready, len(trials.tests), *own, moved=())
    return select_minimal_subset(trials, wishes or {"floor": FRESH}, found, molecule)


def _dots_of(given, frame, how):
    """Dots, what places others on the atoms, and the Molecule; the last two empty for dots alone."""
    wishes = {key: value for key, value in how.items() if key != "d_link"}  # which serves all dots
    if isinstance(given, Surface) and given.placed:
        molecule, frame, rules, *_ = agreed(given.placed, "minimal", frame=frame, **wishes)
        return given, _laid_on(molecule, frame, **rules), molecule
    if not has_atoms(given):
        placed_already("minimal", frame=frame, **wishes)
        return as_surface(given), (None, None), None
    molecule = as_molecule(given)
    return surface(molecule, frame=frame, **how), _laid_on(molecule, frame, **how), molecule


def _laid_on(molecule, frame, probe, density, radii, d_link, cavities):
    """What places other dots on the atoms of one frame."""
    rules = rules_of(probe, density, cavities)
    return surface_generator(molecule, frame, atomic_radii(molecule, radii), rules, d_link, "surface")


def arguments(parser):
    """Options of the command."""
    parser.add_argument("file", metavar="FILE", help="structure or dots")
    options.add_output(parser, outputs.DOTS_ALONE)
    options.add_mesh(parser)
    size = parser.add_mutually_exclusive_group()
    size.add_argument(
        "--percent", type=PERCENT.parse, help="of the dots to keep (default: as few as suffice)"
    )
    size.add_argument(
        "--dots",
        type=NUMBER.parse,
        help="number of dots to keep; the paper's samplers keep about that many",
    )
    size.add_argument("--z", type=Z.parse, help="keep as few dots as reach this Z")
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
        default=DEFAULT_SEED,
        help=f"of the random numbers (default {DEFAULT_SEED}, that of a study)",
    )
    options.add_fields(parser)
    options.add_molecule(parser)


def run(asked):
    """Write the chosen dots."""
    outputs.check(asked, outputs.DOTS_ALONE)
    outputs.write_each(asked, _each(asked))


def _each(asked):
    wishes = {"n_S": asked.dots, "Z": asked.z, "n_S_percent": asked.percent}
    wishes = {key: value for key, value in wishes.items() if value is not None}
    for frame, dots, molecule in options.surfaces(asked):
        if asked.dots is not None and asked.dots > len(dots):
            raise InputError(f"--dots: {asked.dots} are more than the {len(dots)} dots of the surface.")
        options.say(f"choosing among {len(dots):,} dots")
        own, dots = _own(asked, molecule, frame), options.with_fields(asked, dots, molecule, frame)
        few = chosen(dots, own, molecule, wishes, asked.sampler, asked.settle, asked.seed, asked.d_link)
        words = f"{len(few.dots):,} of {len(dots):,} dots"
        yield frame, outputs.Dots(few.surface, few.table, "weight", words=words)


def _own(asked, molecule, frame):
    """Of a structure, what places other dots on its atoms."""
    return (None, None) if molecule is None else _laid_on(molecule, frame, **options.how(asked))
