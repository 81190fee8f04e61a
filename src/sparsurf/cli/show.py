"""`sparsurf show`: one page on a molecule or a surface."""

import argparse
import os
import sys
from functools import partial
from pathlib import Path

from sparsurf.api.frame_pages import page_of_frames, ranked_frames, shown_positions
from sparsurf.api.pages import page_of_surface
from sparsurf.api.replacing import is_own_page
from sparsurf.api.show import has_display, open_page
from sparsurf.api.writing import PAGE_ENDINGS, DotsToWrite, write_page
from sparsurf.arguments import D_LINK
from sparsurf.cli import options, outputs
from sparsurf.molecules.formats import stem

EXAMPLES = """\
The page shows the surface above the cartoon of the molecule and its ligands, coloured by roughness, fields, chains or the kinds
of its dots; which residues touch which chain or ligand, and the area that is buried; the roughness of the residues along each
chain; the ten roughest residues; and the parts of the structure that were left out. A residue that you click or search for is
shown in the picture, in the list and in the profile. The page of a few dots, such as minimal.csv, shows the surface that
`sparsurf recover` reconstructs from them. With --trajectory and without --frame, the page shows at most 100 frames with a
slider, which residues move most, and which change most: in their roughness, or in what --rank names. The page is one file that
needs no network. It opens in the browser unless --no-open is given or there is no display. Without -o, the page is written into
the current folder, under the name of FILE with the suffix .html, to which _frames is added for a trajectory, _frame20 for frame
20, and _model3 for model 3.

examples:
  sparsurf show protein.pdb
  sparsurf show protein.pdb --no-open -o page.html
  sparsurf show protein.pdb --fields potential --limits=-3,3
  sparsurf show dots.csv --no-open
  sparsurf show protein.pdb --trajectory run.xtc
  sparsurf show protein.pdb --trajectory run.xtc --rank area
  sparsurf show protein.pdb --trajectory run.xtc --frame 20
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    options.add_file(parser, "structure, dots, or a mesh in PLY")
    help_text = "file to write (.html; default: the name of FILE with the suffix .html)"
    parser.add_argument("-o", "--output", metavar="OUT", help=help_text)
    parser.add_argument(
        "--no-open", action="store_true", help="write the page without opening it in the browser"
    )
    options.add_molecule(parser)
    options.add_placement(parser, " keep", "reentrant")
    options.add_fields(parser)
    options.add_limits(parser)
    options.add_ranking(parser.add_argument_group("residues of a trajectory"))
    parser.set_defaults(d_link=D_LINK)


def run(args: argparse.Namespace) -> None:
    """Write the page, and open it where there is a display."""
    if args.output is None:
        args.output = f"{stem(args.file)}{_of_frames(args)}.html"
        outputs.check(args, PAGE_ENDINGS, {Path(args.output): is_own_page})
    outputs.check(args, PAGE_ENDINGS)
    shows_frames = _shows_frames(args)
    rules = options.placement_options(args)
    of_one = {"fields": args.fields, "limits": args.limits}
    request = ranked_frames(args.rank, args.rank_by, shows_frames, rules, **of_one)
    molecule, key = options.read_atoms(args, {}) if shows_frames else None, None
    if molecule is not None and molecule.n_frames > 1:
        about, name = options.about(args), Path(args.trajectory).name
        page = page_of_frames(molecule, about, name, request, partial(_say, args))
        counted = f"{len(shown_positions(molecule.n_frames))} frames"
    else:
        surface = options.with_requested_fields(args, *options.read_dots(args))
        options.say(f"page of {len(surface):,} dots")
        shown, counted = next(iter(surface.fields), "roughness"), f"{len(surface):,} dots"
        page = page_of_surface(surface, options.about(args), shown, limits=args.limits)
        key = DotsToWrite(surface, {}, limits=args.limits).key(args.output)
    write_page(args.output, page)
    opens = not args.no_open and has_display() and os.path.isfile(args.output)
    outputs.report(args, f"{counted}{'' if opens else '; open this page in a browser'}", key)
    if opens:
        open_page(args.output)


def _shows_frames(args: argparse.Namespace) -> bool:
    """Return whether the page is asked to show the frames of a trajectory."""
    return args.trajectory is not None and args.frame is None and options.reads_atoms(args)


def _of_frames(args: argparse.Namespace) -> str:
    """Return what the model and the frames that are shown add to the name of the page."""
    model = "" if args.model is None else f"_model{args.model}"
    frame = "_frames" if args.trajectory is not None else ""
    return model + (frame if args.frame is None else f"_frame{args.frame}")


def _say(args: argparse.Namespace, text: str) -> None:
    """Print what is being done."""
    if not args.quiet:
        print(text, file=sys.stderr, flush=True)
