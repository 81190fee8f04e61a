"""`sparsurf regions`: connected dots at which a field lies past a threshold."""

import argparse

import numpy as np

from sparsurf.api import writing
from sparsurf.arguments import D_LINK
from sparsurf.cli import options, outputs
from sparsurf.files import pluralise

LARGEST = 3  # The page begins with the areas of so many regions.
FORMATS = (*writing.TABLE_FORMATS, *writing.PAGE_ENDINGS)
EXAMPLES = """\
A region is a connected set of dots at which the field is above (or below) the threshold. The table has a row for each, the
largest first: region, area (Å^2), dots, mean and peak of the field, residues, and the centre x, y, z (Å). Compare two states at
the same threshold. The walls of closed cavities are left out, unless --cavities keep is given. With --field enclosure, regions
are enclosed surface; they are not ranked as binding sites. A .html file is the page of `sparsurf show` in the colours of the
field, with the residues of the regions in its list.

examples:
  sparsurf regions protein.pdb --field hydropathy --above 1 -o patches.csv
  sparsurf regions protein.pdb --field potential --below -1 -o negative.html
  sparsurf regions protein.pdb --field enclosure --above 2 -o enclosed.npz
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    options.add_file(parser, "structure or dots")
    options.add_output(parser, FORMATS)
    parser.add_argument(
        "--field", required=True, choices=options.SeveralNames("field"), metavar="NAME",
        help="a field of the dots: %(choices)s, a map, a column of --table or of a file of dots",
    )  # fmt: skip
    threshold = parser.add_mutually_exclusive_group(required=True)
    options.add(threshold, "above")
    options.add(threshold, "below")
    options.add(parser, "min_area", has_default=True)
    options.add_values_of_atoms(parser)
    options.add_molecule(parser)
    options.add_placement(parser, " remove")
    parser.set_defaults(d_link=D_LINK)


def run(args: argparse.Namespace) -> None:
    """Write the table of regions, or the page that lists them."""
    outputs.check(args, FORMATS)
    surface, _ = options.read_dots(args, "remove")
    from sparsurf.api.regions import regions, with_field  # here: wrong arguments need no numba

    surface = with_field(surface, args.field, **options.values_of_atoms(args))
    table = regions(surface, *surface.fields, above=args.above, below=args.below, min_area=args.min_area)
    summary = f"{pluralise(len(table), 'region')}, {table['area'].sum():,.0f} Å^2"
    (values,) = surface.fields.values()
    if unknown := int(np.isnan(values).sum()):
        summary += f"; {unknown:,} of {len(values):,} dots have no value and are in no region"
    past = f"above {args.above:g}" if args.below is None else f"below {args.below:g}"
    having = f"{'has' if len(table) == 1 else 'have'} a {next(iter(surface.fields))} {past}"
    answer = f"{pluralise(len(table), 'region')} {having}, {table['area'].sum():,.0f} Å^2 in total"
    if len(table) > 1:
        answer += f"; the largest: {', '.join(f'{area:,.0f}' for area in table['area'].head(LARGEST))} Å^2"
    about = options.about(args, answer=f"{answer}.".replace("^2", "²"))
    writing.write_table(args.output, table, about=about, surface=surface)
    outputs.report(args, summary)
