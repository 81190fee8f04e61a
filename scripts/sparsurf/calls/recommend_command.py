"""`sparsurf recommend`: which combination of the paper's sampling to take.

Answers from the surfaces of a run (summary.csv, relation.csv, surfaces.csv of results/<run>), with the evidence.
"""

from pathlib import Path

from sparsurf import InputError
from sparsurf.calls import options
from sparsurf.calls.patch_calls import roughness
from sparsurf.report.recommendation import read_run, recommend
from sparsurf.streams import stream
from sparsurf.surfaces.spacing import spacing

ALIKE = 1.03  # spacings of dots that differ by less than this factor count as equal
EXAMPLES = """\
The run is one of `make run`; the more surfaces it has, the better it can answer. A mean roughness can stand for FILE.

examples:
  sparsurf recommend protein.pdb --n-s 20
  sparsurf recommend --roughness 0.63 --n-s 20 --results results/default
"""


def arguments(parser):
    """Options of the command."""
    surface = parser.add_mutually_exclusive_group(required=True)
    surface.add_argument(
        "file", metavar="FILE", nargs="?", help="structure or dots whose mean roughness is taken"
    )
    surface.add_argument(
        "--roughness", type=options.number(0, 1, open_low=False), help="mean roughness, 0 (rough) to 1 (flat)"
    )
    parser.add_argument(
        "--n-s", type=options.number(0, 100), required=True, help="wished n_S in %% of the dots"
    )
    parser.add_argument("--results", type=Path, help="results/<run>; default: the one summed up last")
    options.add_molecule(parser)


def run(wish):
    """Print the answer."""
    folder = wish.results or newest()
    evidence = read_run(folder)
    asked = note = ""
    mean_roughness = wish.roughness
    if wish.file is not None:
        rules = evidence["surfaces"].iloc[0]
        wish.d_link = rules["D_link"]
        dots, _ = options.read_dots(wish)
        mean_roughness = roughness(dots, radius=rules["R_patch"], d_link=rules["D_link"]).mean()
        note = spacing_note(spacing(dots.points), evidence["surfaces"]["spacing"])
        asked = f" ({round(wish.n_s / 100 * len(dots))} of the {len(dots)} dots of {wish.file})"
    print(header(folder, evidence["surfaces"]))
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


def newest():
    """Folder of the newest summary below results/."""
    tables = sorted(Path("results").glob("*/summary.csv"), key=lambda path: path.stat().st_mtime)
    if not tables:
        raise InputError(
            "there is no results/*/summary.csv here: run the study first (make run), or give --results."
        )
    return tables[-1].parent
