"""`sparsurf roughness`: R_i of every dot."""

from __future__ import annotations

import argparse

import sparsurf
from sparsurf.api import writing
from sparsurf.cli import options, outputs

FORMATS = writing.OUTPUTS_OF_DOTS_ALONE
EXAMPLES = """\
Roughness is the mean cosine of the angles between the normals of a patch and their mean: 1 is flat, 0 is rough. A PLY stores it
as a vertex property and as a colour, and a .pml file opens the dots in these colours in PyMOL. A .html file is the page of
`sparsurf show`, and a .png file is a picture. Where patches of the dots would be fragmented, as those of a subset, the
roughness is that of the surface that `sparsurf recover` reconstructs from them.

examples:
  sparsurf roughness protein.pdb -o roughness.ply
  sparsurf roughness protein.pdb -o roughness.png
  sparsurf roughness dots.csv --r-patch 6 -o roughness.csv
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    options.add_file(parser, "structure or dots")
    options.add_output(parser, FORMATS)
    options.add(parser, "r_patch", has_default=True)
    options.add_limits(parser)
    options.add_residues(parser)
    options.add(parser, "d_link", has_default=True)
    options.add_molecule(parser)
    options.add_placement(parser, " keep", "reentrant")


def run(args: argparse.Namespace) -> None:
    """Write the dots with their roughness."""
    outputs.check(args, FORMATS)
    surface, molecule = options.read_dots(args)
    options.say(f"roughness of {len(surface):,} dots")
    rules = options.given(args, "r_patch", "d_link")
    values = sparsurf.roughness(surface, **rules)
    chosen = options.dots_of_residues(args, surface, molecule)
    surface, values = surface.take(chosen), values[chosen]
    table = {"roughness": values} | ({} if molecule is None else molecule.label_columns(surface.atom))
    message = f"{len(surface):,} dots, mean roughness {values.mean():.3f}"
    options.say(f"writing {len(surface):,} dots")
    from sparsurf.settings import PatchesSettings  # here: a mistake needs no pydantic

    about = options.about(args, patches=PatchesSettings(**rules), roughness=values)
    outputs.write_output(args, writing.DotsToWrite(surface, table, "roughness", message=message, about=about))
