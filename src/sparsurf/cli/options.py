"""Options that several commands share, and the surfaces that they speak of."""

import argparse
import sys
from dataclasses import replace

from sparsurf import InputError, progress
from sparsurf.cli.inputs import DENSITY, LENGTH, PROBE, Limits, check_frame, is_structure
from sparsurf.cli.making import CAVITIES
from sparsurf.cli.making import surface as surface_of
from sparsurf.cli.outputs import FRAME
from sparsurf.dot_fields.columns import RESERVED_NAMES
from sparsurf.molecules.formats import STRUCTURES, suffix
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.patches.index import D_LINK
from sparsurf.surfaces.read_surface import read_surface

ALL = "all"
OF_MOLECULE = ("chains", "residues", "selection", "model", "altloc", "hydrogens", "ligands")
OF_STRUCTURE = {  # options without a meaning for a file of dots, and their defaults
    **dict.fromkeys(["trajectory", *OF_MOLECULE, "density", "frame", "frames"]),
    **{"altloc": "first", "hydrogens": "keep", "probe": 1.4, "radii": "dms", "cavities": "keep"},
}


def add_molecule(parser, d_link=True, several=True):
    """Which atoms of a structure, and how its dots are made.

    Parameters
    ----------
    d_link : whether D_link can be requested
    several : whether several frames can be
    """
    atoms = parser.add_argument_group("atoms of a structure")
    atoms.add_argument("--trajectory", help="file of frames that belongs to the structure")
    frame = atoms.add_mutually_exclusive_group()
    frame.add_argument(
        "--frame",
        type=Limits(0, whole=True, open_low=False).parse,
        help="frame to take, from 0 (default 0)",
    )
    if several:
        frame.add_argument(
            "--frames",
            type=_frames,
            help=f"several frames: all, 0,5,10, or 0:100:10; name a CSV, or {FRAME} in OUT",
        )
    atoms.add_argument("--chains", help="chain identifiers, such as A,B")
    atoms.add_argument("--residues", help="ranges, such as A:10-52A,60")
    atoms.add_argument("--selection", help="mdtraj expression; 'all' for every atom (default: protein)")
    words = "number of the model, of several" + "; all: each is a frame, from 0" * several
    atoms.add_argument("--model", type=_model if several else _one_model, help=words)
    atoms.add_argument("--altloc", help="first, highest (occupancy) or a letter (default first)")
    atoms.add_argument("--hydrogens", choices=["keep", "remove"], help="hydrogens of the file (default keep)")
    atoms.add_argument("--ligands", help="residue names to take with the protein, such as HEM,ZN")
    dots = parser.add_argument_group("surface of a structure")
    dots.add_argument("--probe", type=PROBE.parse, help="radius of the probe in Å (default 1.4)")
    dots.add_argument(
        "--density", type=DENSITY.parse, help="dots per Å^2 (default: 5.35, or more where patches need it)"
    )
    dots.add_argument("--radii", choices=["dms", "bondi"], help="table of radii (default dms)")
    words = "dots of closed cavities inside the molecule (default keep)"
    dots.add_argument("--cavities", choices=CAVITIES, help=words)
    if d_link:
        dots.add_argument(
            "--d-link",
            type=LENGTH.parse,
            default=D_LINK,
            help=f"Å, dots of a patch closer than this are linked ({D_LINK})",
        )
    parser.set_defaults(**OF_STRUCTURE)


def add_fields(parser):
    """Which fields come with the dots."""
    fields = parser.add_argument_group("fields of a structure's dots")
    fields.add_argument(
        "--fields",
        metavar="NAMES",
        help="hydropathy, potential, bfactor, volume, aromaticity, charge, or columns of --table; with commas between",
    )
    fields.add_argument(
        "--table", help="CSV with a value for each residue, or atom, in columns residue, chain, atom, NAME"
    )
    fields.add_argument(
        "--charges", default="table", help="of the potential: table (default), pdb2pqr, or a PQR file"
    )


def with_fields(asked, surface, molecule, frame=0):
    """The surface with the fields that a command is asked for."""
    if asked.fields is asked.table is None and asked.charges == "table":
        return surface
    from sparsurf.dot_fields.registry import FIELDS, compute_fields  # here: few ask for fields

    names = [name.strip() for name in (asked.fields or "").split(",") if name.strip()]
    if asked.fields is not None and not names:
        raise InputError("--fields names none; give names such as hydropathy, or leave it out.")
    if asked.table is not None and not set(names) - FIELDS.keys():
        raise InputError(
            f"--table: --fields names no column of {asked.table}; name one, or leave out --table."
        )
    if asked.charges != "table" and "potential" not in names:
        raise InputError(
            "--charges: they are of the potential; add --fields potential, or leave out --charges."
        )
    if molecule is None:
        raise InputError(
            f"--fields: {asked.file} holds dots, and fields follow from atoms; give a structure."
        )
    several = asked.frames is not None or (asked.model == ALL and asked.frame is None)
    if several and asked.charges not in ("table", "pdb2pqr"):
        raise InputError("--charges: a PQR file is of one frame; give --frame, or other charges.")
    if never := sorted({*names} & (RESERVED_NAMES | {"self"})):
        raise InputError(f"--fields: a field cannot be called {never[0]}; rename the column.")
    table = compute_fields(names, molecule.frame(frame), surface.points, asked.charges, asked.table)
    return replace(surface, fields=surface.fields | dict(table))


def add_output(parser, formats):
    """Where the result goes."""
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="OUT",
        help=f"file to write ({' '.join(formats)}, each also .gz), or - for stdout",
    )
    parser.add_argument(
        "--format",
        choices=[each.lstrip(".") for each in formats],
        help="instead of the suffix of OUT (default csv)",
    )


def add_mesh(parser, mesh=False):
    """What a PLY holds; `mesh` is whether closed triangles can come instead of dots."""
    if mesh:
        parser.add_argument("--mesh", action="store_true", help="write closed triangles instead of dots")
    parser.add_argument(
        "--binary", action="store_true", help="write a PLY as bytes, half as long; PyMOL reads text only"
    )
    parser.add_argument(
        "--plain", action="store_true", help="write dots without triangles between them (faster)"
    )


def surfaces(asked):
    """The frames of a command's FILE, one by one: (number of the frame, Surface, Molecule); None for a file of dots."""
    if not is_structure(asked.file):
        refuse_of_structure(asked, f"{asked.file}, which holds dots")
        yield 0, read_surface(asked.file), None
        return
    molecule = read_atoms(asked)
    numbers = frames_of(asked, molecule)
    say(f"surface of {molecule.n_atoms:,} atoms")
    for frame in progress.progress_bar(numbers, "frames"):
        yield frame, surface_of(molecule, frame=frame, **how(asked)), molecule


def read_dots(asked):
    """The first of `surfaces`, and its Molecule."""
    _, dots, molecule = next(surfaces(asked))
    return dots, molecule


def how(asked):
    """How `surface` is asked to make the dots of a structure."""
    rules = {key: getattr(asked, key) for key in ("probe", "radii", "d_link", "cavities")}
    return rules | {"density": asked.density or "auto"}


def frames_of(asked, molecule):
    """Numbers of the frames that are asked for, counted from 0."""
    if asked.frames is None:
        return [asked.frame or 0]
    every = range(molecule.n_frames)
    numbers = list(every) if asked.frames == ALL else asked.frames
    numbers = every[numbers] if isinstance(numbers, slice) else numbers
    for number in numbers:
        check_frame(molecule, number, asked.trajectory or asked.file)
    if not numbers:
        raise InputError(
            f"--frames: none of the {molecule.n_frames} frames of {asked.trajectory or asked.file} is among them."
        )
    return numbers


def read_atoms(asked):
    """The Molecule of a command's FILE, with all its frames."""
    keys = {key: getattr(asked, key) for key in OF_MOLECULE}
    keys["ligands"] = keys["ligands"].split(",") if keys["ligands"] else False
    if asked.model == ALL:
        keys["model"], asked.frames = None, asked.frames or (ALL if asked.frame is None else None)
    molecule = read_molecule(asked.file, asked.trajectory, **keys)
    check_frame(molecule, asked.frame or 0, asked.trajectory or asked.file)
    if molecule.n_frames > 1 and asked.frame is asked.frames is None and not asked.quiet:
        several = "models" if suffix(asked.file) in STRUCTURES and not asked.trajectory else "frames"
        print(
            f"{asked.trajectory or asked.file} has {molecule.n_frames} {several}: the first is taken. "
            "--frame takes another.",
            file=sys.stderr,
        )
    return molecule


def refuse_of_structure(asked, what):
    """Raise InputError where an option is given that means nothing for `what`, which is no structure."""
    for name, default in OF_STRUCTURE.items():
        if getattr(asked, name) != default:
            raise InputError(f"--{name} has no meaning for {what}; leave it out.")


def say(text):
    """Tell a terminal what is being done; logs and pipes are spared it."""
    if sys.stderr.isatty():
        print(f"{text} ...", file=sys.stderr, flush=True)


def _model(text):
    """Number of a model, or all."""
    if text != ALL and not text.removeprefix("-").isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} must be the number of a model, or all")
    return text if text == ALL else int(text)


def _one_model(text):
    """Number of a model."""
    if not text.removeprefix("-").isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} must be the number of one model, such as 1")
    return int(text)


def _frames(text):
    """all, a list of numbers, or a slice such as 0:100:10."""
    if text == ALL:
        return ALL
    try:
        if ":" in text:
            found = slice(*(int(word) if word else None for word in text.split(":")))
            found.indices(1)  # a step of 0 is a ValueError
            return found
        numbers = [int(word) for word in text.split(",")]
    except (ValueError, TypeError):
        numbers = [-1]
    if min(numbers) < 0:
        raise argparse.ArgumentTypeError(f"{text!r} must be all, numbers such as 0,5,10, or 0:100:10")
    return numbers
