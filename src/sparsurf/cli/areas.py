"""`sparsurf areas`: exact areas by atom, residue and chain."""

import argparse
from typing import Any

from sparsurf.api import writing
from sparsurf.api.inputs import is_file_of_spheres
from sparsurf.cli import options, outputs
from sparsurf.errors import InputError
from sparsurf.files import pluralise

TABLES = ("atoms", "residues", "chains", "pairs")
EXAMPLES = """\
The table has a row for each residue: its solvent-accessible and its solvent-excluded area (Å^2), the accessible area as a share
of the largest one that the residue can have (relative; theoretical maxima of Tien et al., 2013; blank for residues that have
none), and the accessible area that the other chains bury (Å^2). The areas are exact and need no dots. They count the walls of
cavities. The maxima are for residues without hydrogens and depend on the radii, so that a share may exceed 1.
--of atoms and --of chains write the same areas for atoms and for chains. --of pairs writes the area of each chain that each other
chain buries where both are alone.

FILE may also hold radii (.xyzr .xyzrn .pqr) or the elements of a small molecule (.sdf .mol .mol2), which get radii of Bondi; the
table is then one of atoms.

examples:
  sparsurf areas protein.pdb -o areas.csv
  sparsurf areas protein.pdb --radii bondi --of atoms -o atoms.csv
  sparsurf areas complex.pdb --of pairs -o -
  sparsurf areas protein.pdb --trajectory run.xtc --frame 20 -o areas.csv
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("file", metavar="FILE", help="structure, or a file with radii or elements")
    options.add_output(parser, writing.TABLE_FORMATS)
    help_text = f"what has a row: {', '.join(TABLES)} (of chains); default residues"
    parser.add_argument("--of", choices=TABLES, metavar="ROWS", help=help_text)
    options.add_molecule(parser)
    options.add_placement(parser, None)


def run(args: argparse.Namespace) -> None:
    """Write the table."""
    outputs.check(args, writing.TABLE_FORMATS)
    from sparsurf.api.areas import areas  # here: wrong arguments need no kernels

    source: Any = args.file
    rules = options.placement_options(args)
    del rules["cavities"]  # no option of this command
    if is_file_of_spheres(args.file):
        options.refuse_structure_options(args, "spheres")
        if args.of not in (None, "atoms"):
            raise InputError(
                f"--of: {args.file} holds spheres, which have no {args.of}; leave the option out."
            )
        args.of = "atoms"
    elif not options.reads_atoms(args):
        raise InputError(
            f"{args.file} holds dots, and dots hold no atoms; give the structure that they lie on."
        )
    else:
        source = options.read_atoms(args)
        rules["frame"] = args.frame or 0
        options.say(f"areas of {source.n_atoms:,} atoms")
    computed = areas(source, **rules)
    table = getattr(computed, args.of or "residues")
    writing.write_table(args.output, table)
    message = (
        f"{pluralise(len(table), 'row', separator=',')}, {computed.accessible.sum():,.1f} Å^2 accessible, "
    )
    message += f"{computed.excluded.sum():,.1f} Å^2 excluded"
    buried = f", {computed.buried.sum():,.1f} Å^2 buried between chains" if computed.buried.any() else ""
    outputs.report(args, message + buried)
