"""Which combination to take for a surface of some mean roughness and a wished number of dots.

Answers from the surfaces of a run (summary.csv, relation.csv, surfaces.csv of results/<run>), with the evidence.
"""

import argparse
import os
import sys
from pathlib import Path

from sparsurf import InputError
from sparsurf.parallel import available_cores, stream
from sparsurf.patches import build_index, refuse_sparse, spacing
from sparsurf.recommendation import read_run, recommend
from sparsurf.roughness import roughness
from sparsurf.surface import read_surface

ALIKE = 1.03  # spacings of dots that differ by less than this factor count as equal


def main(folder, percent, mean_roughness=None, path_to_surface=None):
    """The answer as text; the mean roughness is that of `path_to_surface` where none is given."""
    run = read_run(folder)
    asked = note = ""
    if path_to_surface is not None:
        surface = read_surface(path_to_surface)
        rules = run["surfaces"].iloc[0]
        index = build_index(surface.points, surface.normals, rules["D_link"])
        refuse_sparse(index, rules["D_link"], path_to_surface)
        mean_roughness = roughness(index, rules["R_patch"], available_cores()).mean()
        note = spacing_note(spacing(index), run["surfaces"]["spacing"])
        asked = f" ({round(percent / 100 * len(surface))} of the {len(surface)} dots of {path_to_surface})"
    seen, found = run["surfaces"], run["surfaces"]["mean_roughness"]
    proteins = seen["protein"].nunique()
    head = (
        f"{folder}: {len(seen)} {'surface' if len(seen) == 1 else 'surfaces'} of {proteins} "
        f"{'protein' if proteins == 1 else 'proteins'}, mean roughness {found.min():.3f} .. {found.max():.3f}.\n"
        f"Asked: mean roughness {mean_roughness:.3f}, n_S {percent:g} % of the dots{asked}.{note}"
    )
    return head + "\n" + recommend(run, mean_roughness, percent, stream(0, "recommend"))


def spacing_note(own, seen):
    """A warning where the dots lie closer or farther apart than those of the run; else nothing."""
    low, high = seen.min(), seen.max()
    if low / ALIKE <= own <= high * ALIKE:
        return ""
    return (
        f"\nIts dots lie {own:.3f} Å apart, those of the run {low:.3f} .. {high:.3f} Å: under `kept` d depends "
        "strongly on that, so the numbers below do not hold for it."
    )


def number(low, high, low_allowed):
    """Type of an argument between two limits."""

    def parse(text):
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        if not (low <= value <= high and (low_allowed or value > low)):
            words = f"{low:g} to {high:g}" if low_allowed else f"more than {low:g} and at most {high:g}"
            raise argparse.ArgumentTypeError(f"{text!r} must be a number, {words}")
        return value

    return parse


def newest():
    """Folder of the newest summary below results/."""
    tables = sorted(Path("results").glob("*/summary.csv"), key=lambda path: path.stat().st_mtime)
    if not tables:
        raise InputError(
            "there is no results/*/summary.csv here: run the study first (make run), or give --results."
        )
    return tables[-1].parent


def command(arguments=None):
    """Print the answer to the arguments of the command line; a mistake in them ends with status 2."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], allow_abbrev=False)
    surface = parser.add_mutually_exclusive_group(required=True)
    surface.add_argument("--roughness", type=number(0, 1, True), help="mean roughness, 0 (rough) to 1 (flat)")
    surface.add_argument("--surface", help="DMS file, CSV or npz whose mean roughness is taken")
    parser.add_argument(
        "--n-s", type=number(0, 100, False), required=True, help="wished n_S in %% of the dots"
    )
    parser.add_argument("--results", type=Path, help="results/<run>; default: the one summed up last")
    wish = parser.parse_args(arguments)
    try:
        print(main(wish.results or newest(), wish.n_s, wish.roughness, wish.surface), flush=True)
    except BrokenPipeError:  # the reader, `head` say, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except InputError as error:
        parser.error(str(error))


if __name__ == "__main__":
    command()
