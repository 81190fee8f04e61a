"""Options that several commands share, and the surface that they speak of."""

import sys
from pathlib import Path

from sparsurf import InputError
from sparsurf.calls.inputs import check_frame, is_structure
from sparsurf.calls.limits import DENSITY, LENGTH, PROBE, Limits
from sparsurf.calls.surface_calls import surface as surface_of
from sparsurf.molecules.reading import read_molecule
from sparsurf.patches.index import D_LINK
from sparsurf.surfaces.reading import read_surface

OF_MOLECULE = ("chains", "residues", "selection", "model", "altloc", "hydrogens", "ligands")
OF_STRUCTURE = {  # options without a meaning for a file of dots, and their defaults
    **dict.fromkeys(["trajectory", *OF_MOLECULE, "density"]),
    **{"frame": 0, "altloc": "first", "hydrogens": "keep", "probe": 1.4, "radii": "dms"},
}


def add_molecule(parser, d_link=True):
    """Which atoms of a structure, and how its dots are made; `d_link` is whether D_link can be wished."""
    atoms = parser.add_argument_group("atoms of a structure")
    atoms.add_argument("--trajectory", help="file of frames that belongs to the structure")
    atoms.add_argument(
        "--frame",
        type=Limits(0, whole=True, open_low=False).parse,
        help="frame to take, from 0 (default 0)",
    )
    atoms.add_argument("--chains", help="chain identifiers, such as A,B")
    atoms.add_argument("--residues", help="ranges, such as A:10-52A,60")
    atoms.add_argument("--selection", help="mdtraj expression; 'all' for every atom (default: protein)")
    atoms.add_argument("--model", type=int, help="number of the model, of several")
    atoms.add_argument("--altloc", help="first, highest (occupancy) or a letter (default first)")
    atoms.add_argument("--hydrogens", choices=["keep", "remove"], help="hydrogens of the file (default keep)")
    atoms.add_argument("--ligands", help="residue names to take beside the protein, such as HEM,ZN")
    dots = parser.add_argument_group("surface of a structure")
    dots.add_argument("--probe", type=PROBE.parse, help="radius of the probe in Å (default 1.4)")
    dots.add_argument(
        "--density", type=DENSITY.parse, help="dots per Å^2 (default: 5.35, or more where patches need it)"
    )
    dots.add_argument("--radii", choices=["dms", "bondi"], help="table of radii (default dms)")
    if d_link:
        dots.add_argument(
            "--d-link",
            type=LENGTH.parse,
            default=D_LINK,
            help=f"Å, dots of a patch closer than this are linked ({D_LINK})",
        )
    parser.set_defaults(**OF_STRUCTURE)


def add_output(parser, formats, mesh="triangles between the dots of a PLY, too (slower)"):
    """Where the result goes; `mesh` says what triangles it has."""
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="OUT",
        help=f"file to write ({', '.join(formats)}), or - for stdout",
    )
    parser.add_argument(
        "--format",
        choices=[each.lstrip(".") for each in formats],
        help="instead of the suffix of OUT (default csv)",
    )
    if ".ply" in formats:
        parser.add_argument("--mesh", action="store_true", help=mesh)


def read_dots(wish):
    """The Surface of a command's FILE, and its Molecule; None for a file of dots."""
    if not is_structure(wish.file):
        refuse_of_structure(wish, f"{wish.file}, which holds dots")
        return read_surface(wish.file), None
    molecule = read_atoms(wish)
    say(f"surface of {molecule.n_atoms} atoms")
    dots = surface_of(
        molecule,
        frame=wish.frame,
        probe=wish.probe,
        density=wish.density or "auto",
        radii=wish.radii,
        d_link=wish.d_link,
    )
    return dots, molecule


def read_atoms(wish):
    """The Molecule of a command's FILE."""
    keys = {key: getattr(wish, key) for key in OF_MOLECULE}
    keys["ligands"] = keys["ligands"].split(",") if keys["ligands"] else False
    molecule = read_molecule(wish.file, wish.trajectory, **keys)
    check_frame(molecule, wish.frame, wish.trajectory or wish.file)
    return molecule


def refuse_of_structure(wish, what):
    """Raise InputError where an option is given that means nothing for `what`, which is no structure."""
    for name, default in OF_STRUCTURE.items():
        if getattr(wish, name) != default:
            raise InputError(f"--{name} has no meaning for {what}; leave it out.")


def say(text):
    """Tell a terminal what is being done; logs and pipes are spared it."""
    if sys.stderr.isatty():
        print(f"{Path(sys.argv[0]).name}: {text}", file=sys.stderr, flush=True)
