"""`sparsurf residues`: the surface of a molecule by residue."""

import argparse
from typing import Any

import numpy as np

from sparsurf.api import writing
from sparsurf.arguments import D_LINK
from sparsurf.cli import folders, options, outputs
from sparsurf.errors import InputError
from sparsurf.files import pluralise

FORMATS = (*writing.TABLE_FORMATS, *writing.PAGE_FORMATS, *writing.OF_COLUMN)
EXAMPLES = f"""\
The table has a row for each residue: its total, contact, saddle and concave area (Å^2), its mean and lowest roughness (1 is
flat, 0 is rough) and the mean of each field over its dots (mean_bfactor), all blank for a buried residue, its depth (Å), and the
number of its dots, in total and on the walls of cavities. A .html or a .png file shows the roughness along each chain.

A table for --table begins with a line such as chain,residue,score, followed by a line such as A,52,0.7 for each residue.

{folders.FOLDERS_IN_HELP}
examples:
  sparsurf residues protein.pdb -o residues.csv
  sparsurf residues protein.pdb -o profile.png
  sparsurf residues protein.pdb --residues 209-214 --fields hydropathy -o -
  sparsurf residues protein.pdb --column mean_roughness -o roughness.pdb
  sparsurf residues protein.pdb --fields bfactor,apbs.dx -o residues.csv
  sparsurf residues protein.pdb --table own.csv --fields score -o residues.csv
  sparsurf residues structures/ --fields hydropathy -o residues.csv
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    folders.add_files(parser, "structure")
    options.add_output(parser, FORMATS)
    options.add_column(parser)
    options.add_residues(parser)
    options.add_fields(parser)
    options.add_molecule(parser)
    options.add_placement(parser, " keep", "reentrant")
    parser.set_defaults(d_link=D_LINK)


def run(args: argparse.Namespace) -> None:
    """Write the table of residues."""
    if names := options.names_of_requested_fields(args):
        from sparsurf.api.field_values import check_fields  # here: a missing file needs no numba

        check_fields(names, "residues", of_residues=True, has_table=args.table is not None)
    if folders.written(args, FORMATS, _computed, names):
        return
    options.refuse_column(args)
    table, surface, molecule = _computed(args)
    of_column = {"column": args.column, "molecule": molecule, "frame": args.frame or 0}
    writing.write_table(args.output, table, about=options.about(args), surface=surface, **of_column)
    outputs.report(
        args, f"{pluralise(len(table['area']), 'residue', separator=',')}, {table['area'].sum():,.0f} Å^2"
    )


def _computed(args: argparse.Namespace) -> tuple[Any, Any, Any]:
    """Return the columns of the residues of FILE, the surface and the molecule."""
    surface, molecule = options.read_dots(args)
    if molecule is None:
        raise InputError(
            f"{args.file} holds dots, which have no residues; give the structure that they lie on."
        )
    from sparsurf.api.fields import columns_of_residues  # here: wrong arguments need no numba

    options.say(f"roughness of {len(surface):,} dots")
    table = columns_of_residues(options.with_requested_fields(args, surface, molecule))
    if args.residues is not None:
        import pandas as pd  # here: it takes long to load; its index tells a page which residues these are

        rows = np.unique(molecule.residue_index[options.requested_atoms(args, molecule)])
        return pd.DataFrame(table).iloc[rows], surface, molecule
    return table, surface, molecule
