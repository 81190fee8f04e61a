"""`sparsurf show`: one page on a molecule or a surface."""

import argparse
import os
from pathlib import Path

from sparsurf.api.pages import page_of_surface
from sparsurf.api.show import PAGE_ENDINGS, has_display, open_page, write_page
from sparsurf.cli import options, outputs
from sparsurf.errors import InputError
from sparsurf.molecules.formats import stem
from sparsurf.patches.index import D_LINK

OWN_PAGE = b'<meta name="generator" content="sparsurf '  # in a page that may be written again
BYTES_OF_A_TABLE_HEAD = 1000

EXAMPLES = """\
The page shows the surface, which you can rotate and colour by roughness, fields or the kinds of its dots; the roughness of the
residues along each chain; the ten roughest residues; and the parts of the structure that were left out. The page is one file that
needs no network. It opens in the browser unless --no-open is given or there is no display.
Without -o, the page is written into the current folder, under the name of FILE with the suffix .html.

examples:
  sparsurf show protein.pdb
  sparsurf show protein.pdb --no-open -o page.html
  sparsurf show dots.csv --no-open
  sparsurf show protein.pdb --trajectory run.xtc --frame 20
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("file", metavar="FILE", help="structure, dots, or a mesh in PLY")
    help_text = "file to write (.html; default: the name of FILE with the suffix .html)"
    parser.add_argument("-o", "--output", metavar="OUT", help=help_text)
    parser.add_argument(
        "--no-open", action="store_true", help="write the page without opening it in the browser"
    )
    options.add_molecule(parser)
    options.add_placement(parser)
    parser.set_defaults(d_link=D_LINK)


def run(args: argparse.Namespace) -> None:
    """Write the page, and open it where there is a display."""
    if args.output is None:
        args.output = f"{stem(args.file)}.html"
        _refuse_other_file(Path(args.output))
    outputs.check(args, PAGE_ENDINGS)
    surface, _ = options.read_dots(args)
    write_page(args.output, page_of_surface(surface, options.about(args)))
    opens = not args.no_open and has_display() and os.path.isfile(args.output)
    outputs.report(args, f"{len(surface):,} dots{'' if opens else '; open this page in a browser'}")
    if opens:
        open_page(args.output)


def _refuse_other_file(path: Path) -> None:
    """Raise InputError if a file that no one named would be replaced, unless it is a page of this program."""
    if path.is_file():
        with path.open("rb") as file:
            if OWN_PAGE not in file.read(BYTES_OF_A_TABLE_HEAD):
                raise InputError(
                    f"{path} exists and was not written by sparsurf; choose another file with -o."
                )
