"""`recommend`: which combination of the paper's sampling to take, as a function and as `sparsurf recommend`.

Answers with the evidence of many proteins (docs/proteins.md), which comes along, or of the surfaces of a run (summary.csv,
relation.csv, surfaces.csv of results/<run>).
"""

from numbers import Real
from pathlib import Path

import numpy as np

from sparsurf import InputError
from sparsurf.cli import options
from sparsurf.cli.inputs import PERCENT, Limits, as_molecule, as_surface, has_atoms, is_structure
from sparsurf.cli.making import surface as surface_of
from sparsurf.cli.roughness import roughness as roughness_of
from sparsurf.report.recommendation import EVIDENCE, read_run
from sparsurf.report.recommendation import recommend as answer
from sparsurf.streams import stream
from sparsurf.surfaces.spacing import DENSER_SURFACE_REMEDY, refuse_sparse, spacing

MANY = "docs/proteins.md"  # tells how the evidence that comes along was measured
WITHOUT = " without its hydrogens, as the evidence is"
N_S = 10  # %, a tenth of the dots
ALIKE = 1.03  # spacings of dots that differ by less than this factor count as equal
ROUGHNESS = Limits(0, 1, open_low=False)
EXAMPLES = """\
Without --results the evidence is that of docs/proteins.md; a run of `make run` can take its place, and the more proteins it
has, the better it can answer. A mean roughness can stand for FILE.

examples:
  sparsurf recommend protein.pdb
  sparsurf recommend --roughness 0.63 --n-s 20
"""


def arguments(parser):
    """Options of the command."""
    surface = parser.add_mutually_exclusive_group(required=True)
    surface.add_argument(
        "file", metavar="FILE", nargs="?", help="structure or dots whose mean roughness is taken"
    )
    surface.add_argument("--roughness", type=ROUGHNESS.parse, help="mean roughness, 0 (rough) to 1 (flat)")
    parser.add_argument(
        "--n-s",
        type=PERCENT.parse,
        default=N_S,
        help=f"requested n_S in %% of the dots (default {N_S})",
    )
    parser.add_argument(
        "--results", type=Path, help="results/<run>; default: many proteins, docs/proteins.md"
    )
    options.add_molecule(parser, d_link=False, several=False)  # the evidence has its own
    parser.set_defaults(hydrogens=None)  # so that it is known whether they are asked for


class Answer(str):
    """A text that a notebook shows as it is printed."""

    def __repr__(self):
        return str(self)


def recommend(given, percent=N_S, results=None):
    """Which combination of the paper's sampling suits a surface, as text.

    Parameters
    ----------
    given : float, the mean roughness of a surface; path of a structure or molecule; or dots, as in `prepare`
        A molecule, also that of dots that know theirs, is taken without its hydrogens where the evidence is.
    percent : float
        Requested n_S in % of the dots.
    results : path of results/<run>; the evidence of many proteins without

    Examples
    --------
    >>> import sparsurf
    >>> print(sparsurf.recommend(0.63, 20))  # doctest: +SKIP
    """
    percent, evidence = PERCENT.check(percent, "percent"), read_run(Path(results or EVIDENCE))
    if isinstance(given, Real):
        mean, note = ROUGHNESS.check(given, "roughness"), ""
    else:
        dots = _bare(given, evidence["surfaces"].iloc[0])
        mean, note = (
            _mean(dots, evidence),
            spacing_note(spacing(dots.points), evidence["surfaces"]["spacing"]),
        )
    return Answer(f"{note}\n{answer(evidence, mean, percent, stream(0, 'recommend'))}".strip())


def _bare(given, rules):
    """Dots of what is given, of a molecule as the evidence has them."""
    origin = getattr(given, "placed", None)
    if not (origin or has_atoms(given)):
        return as_surface(given)
    molecule, frame, how = origin[:3] if origin else (as_molecule(given), 0, {})
    if rules.get("hydrogens") == "remove":
        molecule = molecule.take(~np.isin(molecule.element, ["H", "D"]))
    return surface_of(molecule, frame=frame, **how | {"d_link": rules["D_link"]})


def run(asked):
    """Print the answer."""
    evidence = read_run(asked.results or EVIDENCE)
    of = note = ""
    mean_roughness, kept = asked.roughness, asked.hydrogens == "keep"
    asked.hydrogens = asked.hydrogens or "keep"
    if asked.file is None:
        options.refuse_of_structure(asked, "a mean roughness")
    else:
        rules = evidence["surfaces"].iloc[0]
        asked.d_link = rules["D_link"]
        bare = rules.get("hydrogens") == "remove" and is_structure(asked.file)
        if bare and kept:
            raise InputError(
                "--hydrogens keep: the evidence is of structures without hydrogens; leave it out."
            )
        if bare:
            asked.hydrogens = "remove"
        dots, _ = options.read_dots(asked)
        mean_roughness = _mean(dots, evidence, asked.file)
        note = spacing_note(spacing(dots.points), evidence["surfaces"]["spacing"])
        of = f" ({round(asked.n_s / 100 * len(dots))} of the {len(dots)} dots of {asked.file}{WITHOUT if bare else ''})"
    print(header(asked.results or MANY, evidence["surfaces"]))
    print(f"Asked: mean roughness {mean_roughness:.3f}, n_S {asked.n_s:g} % of the dots{of}.{note}")
    print(answer(evidence, mean_roughness, asked.n_s, stream(0, "recommend")), flush=True)


def _mean(dots, evidence, name="surface"):
    """Mean roughness of dots by the rules of the evidence."""
    rules = evidence["surfaces"].iloc[0]
    if len(dots) == 1:
        raise InputError(f"{name} has a single dot, which has no roughness: give a surface.")
    refuse_sparse(dots.points, rules["D_link"], name, DENSER_SURFACE_REMEDY)
    return roughness_of(dots, radius=rules["R_patch"], d_link=rules["D_link"]).mean()


def header(folder, seen):
    """What the answer is taken from."""
    proteins, found = seen["protein"].nunique(), seen["mean_roughness"]
    return (
        f"{folder}: {len(seen)} {'surface' if len(seen) == 1 else 'surfaces'} of {proteins} "
        f"{'protein' if proteins == 1 else 'proteins'}, mean roughness {found.min():.3f} to {found.max():.3f}."
    )


def spacing_note(own, seen):
    """A warning where the dots lie closer or farther apart than those of the run; else nothing."""
    low, high = seen.min(), seen.max()
    if low / ALIKE <= own <= high * ALIKE:
        return ""
    return (
        f"\nIts dots lie {own:.3f} Å apart, those of the run {low:.3f} to {high:.3f} Å. As coded, d depends on that: "
        "the numbers below do not hold for it."
    )
