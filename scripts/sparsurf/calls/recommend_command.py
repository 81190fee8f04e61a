"""`sparsurf recommend`: which combination of the paper's sampling to take.

Answers with the evidence of many proteins (docs/proteins.md), which comes along, or of the surfaces of a run (summary.csv,
relation.csv, surfaces.csv of results/<run>).
"""

from pathlib import Path

from sparsurf import InputError
from sparsurf.calls import options
from sparsurf.calls.inputs import is_structure
from sparsurf.calls.limits import PERCENT, Limits
from sparsurf.calls.patch_calls import roughness
from sparsurf.report.recommendation import EVIDENCE, read_run, recommend
from sparsurf.streams import stream
from sparsurf.surfaces.spacing import DENSER, refuse_sparse, spacing

MANY = "docs/proteins.md"  # tells how the evidence that comes along was measured
WITHOUT = " without its hydrogens, as the evidence is"
N_S = 10  # %, a tenth of the dots
ALIKE = 1.03  # spacings of dots that differ by less than this factor count as equal
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
    surface.add_argument(
        "--roughness", type=Limits(0, 1, open_low=False).parse, help="mean roughness, 0 (rough) to 1 (flat)"
    )
    parser.add_argument(
        "--n-s",
        type=PERCENT.parse,
        default=N_S,
        help=f"wished n_S in %% of the dots (default {N_S})",
    )
    parser.add_argument(
        "--results", type=Path, help="results/<run>; default: many proteins, docs/proteins.md"
    )
    options.add_molecule(parser, d_link=False)  # the evidence has its own


def run(wish):
    """Print the answer."""
    evidence = read_run(wish.results or EVIDENCE)
    asked = note = ""
    mean_roughness = wish.roughness
    if wish.file is None:
        options.refuse_of_structure(wish, "a mean roughness")
    else:
        rules = evidence["surfaces"].iloc[0]
        wish.d_link = rules["D_link"]
        bare = rules.get("hydrogens") == "remove" and is_structure(wish.file)
        if bare:
            wish.hydrogens = "remove"
        dots, _ = options.read_dots(wish)
        if len(dots) == 1:
            raise InputError(f"{wish.file} has a single dot, which has no roughness: give a surface.")
        refuse_sparse(dots.points, rules["D_link"], wish.file, DENSER)
        mean_roughness = roughness(dots, radius=rules["R_patch"], d_link=rules["D_link"]).mean()
        note = spacing_note(spacing(dots.points), evidence["surfaces"]["spacing"])
        asked = f" ({round(wish.n_s / 100 * len(dots))} of the {len(dots)} dots of {wish.file}{WITHOUT if bare else ''})"
    print(header(wish.results or MANY, evidence["surfaces"]))
    print(f"Asked: mean roughness {mean_roughness:.3f}, n_S {wish.n_s:g} % of the dots{asked}.{note}")
    print(recommend(evidence, mean_roughness, wish.n_s, stream(0, "recommend")), flush=True)


def header(folder, seen):
    """What the answer is taken from."""
    proteins, found = seen["protein"].nunique(), seen["mean_roughness"]
    return (
        f"{folder}: {len(seen)} {'surface' if len(seen) == 1 else 'surfaces'} of {proteins} "
        f"{'protein' if proteins == 1 else 'proteins'}, mean roughness {found.min():.3f} .. {found.max():.3f}."
    )


def spacing_note(own, seen):
    """A warning where the dots lie closer or farther apart than those of the run; else nothing."""
    low, high = seen.min(), seen.max()
    if low / ALIKE <= own <= high * ALIKE:
        return ""
    return (
        f"\nIts dots lie {own:.3f} Å apart, those of the run {low:.3f} .. {high:.3f} Å: under `kept` d depends "
        "strongly on that, so the numbers below do not hold for it."
    )
