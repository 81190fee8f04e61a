"""`sparsurf atoms`: the atoms that determine the surface of a molecule."""

import argparse

import sparsurf
from sparsurf.api.inputs import is_file_of_spheres
from sparsurf.cli import options, outputs
from sparsurf.messages import no_warnings

FORMATS = (".xyzr", ".pqr", ".pdb")
EXAMPLES = """\
The atoms that the probe touches determine the surface, and none of them can be left out. A few inner atoms (plugs) keep the probe
out of the voids between them. The surface of the result is the surface of the molecule, for this probe and, where the walls of
cavities are kept, for every larger one; with another table of radii it is another surface.
A .xyzr holds x, y, z and the radius of each atom, for MSMS and other programs; a .pqr and a .pdb also hold the names of atoms and
residues, and the radius of each atom is its last column or its B factor. The header says the radius of the probe and the radii.

FILE may also hold radii (.xyzr .xyzrn .pqr) or the elements of a small molecule (.sdf .mol .mol2), which get radii of Bondi; the
result is then a .xyzr.

examples:
  sparsurf atoms protein.pdb -o few.xyzr
  sparsurf atoms protein.pdb --cavities remove -o few.pdb
  sparsurf atoms protein.pdb --trajectory run.xtc --frame 20 -o few.pqr
  sparsurf surface few.xyzr -o dots.ply
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    options.add_file(parser, "structure, or a file with radii or elements")
    options.add_output(parser, FORMATS)
    options.add_molecule(parser)
    options.add_placement(parser, " keep", "plugs")


def run(args: argparse.Namespace) -> None:
    """Write the atoms."""
    outputs.check(args, (".xyzr",) if is_file_of_spheres(args.file) else FORMATS)
    source, of_molecule = options.read_spheres_or_atoms(args, "surface of")
    rules = options.placement_options(args)
    few = sparsurf.surface_atoms(source, **rules, **of_molecule, **options.given(args, "plugs"))
    sparsurf.write(few, args.output)
    if outputs.is_reported(args):
        with no_warnings():  # of atoms without plugs
            area = sparsurf.recover(few).total_area
        n_touched = int(few.touched.sum())
        message = f"{len(few):,} of {len(few.spheres.radii):,} atoms ({len(few) / area:.3f} per Å^2): {n_touched:,} that the "
        message += f"probe touches, and {len(few) - n_touched:,} plugs. "
        equal = "The surface is the same as that of all atoms."
        outputs.report(
            args, message + (equal if few.is_exact else "They may not determine the surface exactly.")
        )
