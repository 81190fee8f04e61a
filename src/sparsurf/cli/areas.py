"""`sparsurf areas`: exact areas by atom, residue, chain and group, and what touches what."""

import argparse
from typing import Any

import sparsurf
from sparsurf.api import writing
from sparsurf.api.inputs import is_file_of_spheres
from sparsurf.arguments import TOUCHED_AREA
from sparsurf.cli import folders, options, outputs
from sparsurf.errors import InputError
from sparsurf.files import pluralise

TABLES = ("atoms", "residues", "chains", "groups", "pairs", "contacts")
FORMATS = (*writing.TABLE_FORMATS, *writing.OF_COLUMN)
WITH_RESIDUES = ("atoms", "residues", "contacts")  # tables with rows of residues
EXAMPLES = f"""\
The table has a row for each residue: its solvent-accessible and its solvent-excluded area (Å^2), the accessible area as a share
of the largest one that the residue can have (relative; theoretical maxima of Tien et al., 2013; blank for residues that have
none), the accessible area that its partners bury (Å^2), the accessible area of its main chain, its side chain, its polar atoms
(N, O) and its other atoms, and the share that its partners bury of its area without them (share_buried). The areas are exact and
need no dots. They count the walls of cavities. The maxima are for residues without hydrogens and depend on the radii, so that a
share may exceed 1.
--selection and --chains say what is present; --residues reports rows of the whole.

What buries what: each chain of polymers and each ligand that is read (--ligands HEM,ZN, or all) is a partner by itself. --groups
H,L+G names partners: groups with + between, each a list of chains, ranges of residues (A:10-52) and ligands. An atom belongs to
the group that names it most closely, by its ligand, else its range, else its chain; atoms of no group are absent. --groups
residues makes each residue a partner.
--of pairs writes two rows for each pair that touches: the area of the first partner (group or chain) that the other buries
where both are alone, and the reverse; half of their sum is the area of the interface. --of contacts writes that of each residue,
with its distance from the partner (that of the two nearest atoms, Å), --of groups and --of chains the areas of each partner.
--of contacts has rows of all ligands, unless --ligands, --selection or --groups says what is read; they change no other row.

FILE may also hold radii (.xyzr .xyzrn .pqr) or the elements of a small molecule (.sdf .mol .mol2), which get radii of Bondi; the
table is then one of atoms.

{folders.FOLDERS_IN_HELP}
examples:
  sparsurf areas protein.pdb -o areas.csv
  sparsurf areas protein.pdb --radii bondi --of atoms -o atoms.csv
  sparsurf areas complex.pdb --of pairs -o -
  sparsurf areas fab_antigen.pdb --groups H,L+G --of pairs -o -
  sparsurf areas myoglobin.pdb --groups A+HEM --of contacts -o -
  sparsurf areas protein.pdb --trajectory run.xtc --frame 20 -o areas.csv
  sparsurf areas protein.pdb --column relative -o relative.pdb
  sparsurf areas structures/ --of chains -o chains.csv
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    folders.add_files(parser, "structure, a file with radii or elements")
    options.add_output(parser, FORMATS)
    help_text = f"what has a row: {', '.join(TABLES)}; default residues"
    parser.add_argument("--of", choices=TABLES, metavar="ROWS", help=help_text)
    options.add_column(parser)
    options.add_groups(parser)
    options.add_residues(parser)
    options.add_molecule(parser)
    options.add_placement(parser, None)


def run(args: argparse.Namespace) -> None:
    """Write the table."""
    table_of = args.of or "residues"
    if args.residues is not None and table_of not in WITH_RESIDUES:
        raise InputError(
            f"--residues: the table of {table_of} has no rows of residues; leave the option out, or ask "
            f"for {', '.join(WITH_RESIDUES)}."
        )
    if folders.written(args, FORMATS, _computed):
        return
    options.refuse_column(args)
    table, computed = _computed(args)
    writing.write_table(
        args.output, table, column=args.column, molecule=computed.molecule, frame=computed.frame
    )
    message = pluralise(len(next(iter(table.values()))), "row", separator=",")
    if args.of == "contacts":
        message += (
            f", of which {(table['buried'] >= TOUCHED_AREA).sum():,} touch, by {TOUCHED_AREA:g} Å^2 or more"
        )
    else:
        message += (
            f", {computed.accessible.sum():,.1f} Å^2 accessible, {computed.excluded.sum():,.1f} Å^2 excluded"
        )
        message += (
            f", {computed.buried.sum():,.1f} Å^2 buried between partners" if computed.buried.any() else ""
        )
    outputs.report(args, message)


def _computed(args: argparse.Namespace) -> tuple[Any, Any]:
    """Return the columns of the table of FILE, and its areas."""
    rules = options.placement_options(args)
    del rules["cavities"]  # no option of this command
    with_ligands = args.of == "contacts" and args.ligands is args.selection is args.groups is None
    if with_ligands := with_ligands and not is_file_of_spheres(args.file):
        args.ligands = "all"
    source, of_molecule = options.read_spheres_or_atoms(args, "areas of")
    if not of_molecule and args.of not in (None, "atoms"):
        raise InputError(f"--of: {args.file} holds spheres, which have no {args.of}; leave the option out.")
    if with_ligands:
        from sparsurf.molecules.overlaps import without_overlaps  # here: a mistake needs no numpy

        source = without_overlaps(source, args.frame or 0)
    computed = sparsurf.areas(source, groups=args.groups, **rules, **of_molecule)
    table = computed.columns(args.of or ("residues" if of_molecule else "atoms"))
    if args.residues is not None and computed.molecule is not None:
        atoms = options.requested_atoms(args, computed.molecule)
        chosen = {*zip(computed.molecule.chain[atoms], computed.molecule.residue[atoms], strict=True)}
        rows = [label in chosen for label in zip(table["chain"], table["residue"], strict=True)]
        table = {name: column[rows] for name, column in table.items()}
    return table, computed
