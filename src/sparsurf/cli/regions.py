"""`sparsurf regions`: connected dots at which a field lies past a threshold."""

from __future__ import annotations

import argparse
from dataclasses import replace

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
    options.add_placement(parser, " remove", "reentrant")
    parser.set_defaults(d_link=D_LINK)


def run(args: argparse.Namespace) -> None:
    """Write the table of regions, or the page that lists them."""
    outputs.check(args, FORMATS)
    surface, _ = options.read_dots(args, "remove")
    from sparsurf.api.fields import columns_of_fields  # here: a missing file needs no numba
    from sparsurf.api.regions import columns_of_regions

    field, values = args.field, options.given(args, *options.VALUES_OF_ATOMS)
    if surface.molecule is not None and (values or field not in surface.fields):
        columns = columns_of_fields(surface, names=[field], **values)
        (field,) = columns
        surface = replace(surface, fields=columns)
    table = columns_of_regions(surface, field, **options.given(args, "above", "below", "min_area"))
    n = len(table["region"])
    surface = replace(surface, fields={field: surface.fields[field]})
    summary = f"{pluralise(n, 'region')}, {table['area'].sum():,.0f} Å^2"
    if unknown := int(np.isnan(surface.fields[field]).sum()):
        summary += f"; {unknown:,} of {len(surface):,} dots have no value and are in no region"
    past = f"above {args.above:g}" if args.below is None else f"below {args.below:g}"
    having = f"{'has' if n == 1 else 'have'} a {field} {past}"
    answer = f"{pluralise(n, 'region')} {having}, {table['area'].sum():,.0f} Å^2 in total"
    if n > 1:
        answer += f"; the largest: {', '.join(f'{area:,.0f}' for area in table['area'][:LARGEST])} Å^2"
    about = options.about(args, answer=f"{answer}.".replace("^2", "²"))
    writing.write_table(args.output, table, about=about, surface=surface)
    outputs.report(args, summary)
