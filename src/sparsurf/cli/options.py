"""Options that several commands share, and the surfaces that they request."""

import argparse
import math
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from sparsurf import progress
from sparsurf.api.inputs import DENSITY, LENGTH, PROBE, Limits, check_frame, is_structure
from sparsurf.api.surfaces import CAVITIES
from sparsurf.api.surfaces import surface as surface_of
from sparsurf.cli.outputs import FRAME
from sparsurf.errors import InputError
from sparsurf.molecules.formats import STRUCTURES, suffix
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.patches.index import D_LINK
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.surfaces.surface import Surface

ALL = "all"
ATOM_OPTIONS = ("chains", "residues", "selection", "model", "altloc", "hydrogens", "ligands")
STRUCTURE_OPTIONS = {  # without a meaning for a file of dots, and their defaults
    **dict.fromkeys(["trajectory", *ATOM_OPTIONS, "density", "frame", "frames"]),
    **{"altloc": "first", "hydrogens": "keep", "probe": PROBE_RADIUS, "radii": "dms", "cavities": "keep"},
}


def number(limits: Limits) -> Callable[[str], float]:
    """Return the parser of an option that takes a number within limits, for argparse."""

    def parse(text: str) -> float:
        try:
            value = int(text) if limits.whole else float(text)
        except ValueError:
            value = math.nan
        if not limits.allow(value):
            raise argparse.ArgumentTypeError(f"{text!r} must be {limits.words}")
        return value

    return parse


def add_molecule(parser: argparse.ArgumentParser, several: bool = True) -> None:
    """Add the options that choose atoms of a structure and place its dots; `several`: of more than one frame."""
    atoms = parser.add_argument_group("atoms of a structure")
    atoms.add_argument("--trajectory", help="file of frames that belongs to the structure")
    frame = atoms.add_mutually_exclusive_group()
    frame.add_argument(
        "--frame",
        type=number(Limits(0, whole=True, open_low=False)),
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
    words = "number of the model to take" + "; all: each is a frame, from 0" * several
    atoms.add_argument("--model", type=_model if several else _one_model, help=words)
    atoms.add_argument("--altloc", help="first, highest (occupancy) or a letter (default first)")
    atoms.add_argument("--hydrogens", choices=["keep", "remove"], help="hydrogens of the file (default keep)")
    atoms.add_argument("--ligands", help="residue names to take with the protein, such as HEM,ZN")
    dots = parser.add_argument_group("surface of a structure")
    dots.add_argument(
        "--probe", type=number(PROBE), help=f"radius of the probe in Å (default {PROBE_RADIUS:g})"
    )
    dots.add_argument(
        "--density", type=number(DENSITY), help="dots per Å^2 (default: 5.35, or more where patches need it)"
    )
    dots.add_argument("--radii", choices=["dms", "bondi"], help="table of radii (default dms)")
    words = "dots of closed cavities inside the molecule (default keep)"
    dots.add_argument("--cavities", choices=CAVITIES, help=words)
    dots.add_argument(
        "--d-link",
        type=number(LENGTH),
        default=D_LINK,
        help=f"Å, dots of a patch closer than this are linked ({D_LINK})",
    )
    parser.set_defaults(**STRUCTURE_OPTIONS)


def add_fields(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose the fields of the dots."""
    fields = parser.add_argument_group("fields of a structure's dots")
    fields.add_argument(
        "--fields",
        metavar="NAMES",
        help="hydropathy, potential, bfactor, or columns of --table; with commas between",
    )
    fields.add_argument(
        "--table", help="CSV with a value for each residue, or atom, in columns residue, chain, atom, NAME"
    )
    fields.add_argument(
        "--charges", default="table", help="charges of the potential: table (default), pdb2pqr, or a PQR file"
    )


def with_fields(
    args: argparse.Namespace, surface: Surface, molecule: Molecule | None, frame: int = 0
) -> Surface:
    """Return the surface with the requested fields."""
    if args.fields is args.table is None and args.charges == "table":
        return surface
    from sparsurf.dot_fields.registry import FIELDS, compute_fields  # here: few ask for fields

    names = [name.strip() for name in (args.fields or "").split(",") if name.strip()]
    if args.fields is not None and not names:
        raise InputError("--fields names none; give names such as hydropathy, or leave it out.")
    if args.table is not None and not set(names) - FIELDS.keys():
        raise InputError(
            f"--table: --fields names no column of {args.table}; name one, or leave out --table."
        )
    if args.charges != "table" and "potential" not in names:
        raise InputError(
            "--charges: they apply to the potential only; add --fields potential, or leave out --charges."
        )
    if molecule is None:
        raise InputError(f"--fields: {args.file} holds dots, and fields follow from atoms; give a structure.")
    several = args.frames is not None or (args.model == ALL and args.frame is None)
    if several and args.charges not in ("table", "pdb2pqr"):
        raise InputError("--charges: a PQR file holds one frame; give --frame, or other charges.")
    table = compute_fields(names, molecule.frame(frame), surface.points, args.charges, args.table)
    return replace(
        surface, fields=surface.fields | {str(name): column.to_numpy() for name, column in table.items()}
    )


def add_output(parser: argparse.ArgumentParser, formats: Sequence[str]) -> None:
    """Add the options of the output file."""
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="OUT",
        help=f"file to write ({' '.join(formats)}, each also .gz), or - for stdout",
    )
    parser.add_argument(
        "--format",
        choices=[suffix.lstrip(".") for suffix in formats],
        help="instead of the suffix of OUT (default csv)",
    )


def add_mesh(parser: argparse.ArgumentParser, mesh: bool = False) -> None:
    """Add the options on the content of a PLY; `mesh`: closed triangles can be written instead of dots."""
    if mesh:
        parser.add_argument("--mesh", action="store_true", help="write closed triangles instead of dots")
    parser.add_argument(
        "--binary", action="store_true", help="write a PLY as bytes, half as long; PyMOL reads text only"
    )
    parser.add_argument(
        "--no-faces", action="store_true", help="write dots without triangles between them (faster)"
    )


def surfaces(args: argparse.Namespace) -> Iterator[tuple[int, Surface, Molecule | None]]:
    """Yield number, Surface and Molecule of each frame of FILE; the molecule of a file of dots is None."""
    if not is_structure(args.file):
        refuse_structure_options(args, f"{args.file}, which holds dots")
        yield 0, read_surface(args.file), None
        return
    molecule = read_atoms(args)
    numbers = frames_of(args, molecule)
    say(f"surface of {molecule.n_atoms:,} atoms")
    for frame in progress.progress_bar(numbers, "frames"):
        yield frame, place_dots(args, molecule, frame), molecule


def read_dots(args: argparse.Namespace) -> tuple[Surface, Molecule | None]:
    """Return the first of `surfaces`, and its molecule."""
    _, dots, molecule = next(surfaces(args))
    return dots, molecule


def place_dots(args: argparse.Namespace, molecule: Molecule, frame: int) -> Surface:
    """Return the surface of a frame of FILE, placed by the rules of the options."""
    return surface_of(
        molecule,
        frame=frame,
        probe_radius=args.probe,
        density=args.density or "auto",
        radii=args.radii,
        d_link=args.d_link,
        cavities=args.cavities,
    )


def frames_of(args: argparse.Namespace, molecule: Molecule) -> list[int]:
    """Return the numbers of the requested frames, counted from 0."""
    if args.frames is None:
        return [args.frame or 0]
    every = range(molecule.n_frames)
    frames = slice(None) if args.frames == ALL else args.frames
    numbers = list(every[frames] if isinstance(frames, slice) else frames)
    for frame in numbers:
        check_frame(molecule, frame, args.trajectory or args.file)
    if not numbers:
        raise InputError(
            f"--frames: none of the {molecule.n_frames} frames of {args.trajectory or args.file} is among them."
        )
    return numbers


def read_atoms(args: argparse.Namespace) -> Molecule:
    """Return the molecule of FILE, with all its frames."""
    keys = {key: getattr(args, key) for key in ATOM_OPTIONS}
    keys["ligands"] = keys["ligands"].split(",") if keys["ligands"] else False
    if args.model == ALL:
        keys["model"], args.frames = None, args.frames or (ALL if args.frame is None else None)
    molecule = read_molecule(args.file, args.trajectory, **keys)
    check_frame(molecule, args.frame or 0, args.trajectory or args.file)
    if molecule.n_frames > 1 and args.frame is args.frames is None and not args.quiet:
        several = "models" if suffix(args.file) in STRUCTURES and not args.trajectory else "frames"
        print(
            f"{args.trajectory or args.file} has {molecule.n_frames} {several}: the first is taken. "
            "--frame takes another.",
            file=sys.stderr,
        )
    return molecule


def refuse_structure_options(args: argparse.Namespace, what: str) -> None:
    """Raise InputError if an option of structures is given for `what`, which is not a structure."""
    for name, default in STRUCTURE_OPTIONS.items():
        if getattr(args, name) != default:
            raise InputError(f"--{name} has no meaning for {what}; leave it out.")


def say(text: str) -> None:
    """Print on a terminal what is being done; not in logs and pipes."""
    if sys.stderr.isatty():
        print(f"{text} ...", file=sys.stderr, flush=True)


def _model(text: str) -> int | str:
    """Parse the number of a model, or all."""
    if text != ALL and not text.removeprefix("-").isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} must be the number of a model, or all")
    return text if text == ALL else int(text)


def _one_model(text: str) -> int:
    """Parse the number of a model."""
    if not text.removeprefix("-").isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} must be the number of one model, such as 1")
    return int(text)


def _frames(text: str) -> str | slice | list[int]:
    """Parse all, a list of numbers, or a slice such as 0:100:10."""
    if text == ALL:
        return ALL
    try:
        if ":" in text:
            frames = slice(*(int(word) if word else None for word in text.split(":")))
            frames.indices(1)  # a step of 0 is a ValueError
            return frames
        numbers = [int(word) for word in text.split(",")]
    except (ValueError, TypeError):
        numbers = [-1]
    if min(numbers) < 0:
        raise argparse.ArgumentTypeError(f"{text!r} must be all, numbers such as 0,5,10, or 0:100:10")
    return numbers
