"""Options that several commands share, and the surfaces that they request."""

from __future__ import annotations

import argparse
import logging
import math
import re
import shlex
import sys
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NoReturn, get_args

import numpy as np

import sparsurf
from sparsurf import progress, registry
from sparsurf.api.inputs import check_frame, is_file_of_spheres
from sparsurf.api.page_metadata import About, heard
from sparsurf.arguments import (
    ARGUMENTS,
    EACH_RESIDUE,
    MODELS,
    PLDDT,
    RANK,
    Hydrogens,
    Limits,
    split_names,
)
from sparsurf.cli.command import StoreOnce
from sparsurf.dot_fields.maps import MAPS
from sparsurf.errors import InputError, naming_file
from sparsurf.files import ends_in
from sparsurf.molecules.formats import (
    FILE_OF_DOTS,
    STRUCTURE_LABELS,
    TOPOLOGY_LABELS,
    TRAJECTORY_LABELS,
    suffix,
    title,
)
from sparsurf.molecules.selection import select_atoms
from sparsurf.molecules.source import Source, open_source, what_is_no_structure
from sparsurf.surfaces.radii import check_radii
from sparsurf.surfaces.spheres import SPHERE_FORMATS

if TYPE_CHECKING:
    import pandas as pd

log = logging.getLogger("sparsurf")

HOW_TO_READ = ("altloc", "hydrogens", "plddt", "whole")
ATOM_OPTIONS = ("chains", "selection", "ligands", "model", "assembly", "assembly_name")
VALUES_OF_ATOMS = ("table", "smooth", "charges")  # what a user says of atoms
STRUCTURE_OPTIONS = (
    "trajectory",
    "frame",
    *ATOM_OPTIONS,
    *HOW_TO_READ,
    "residues",
    "groups",
    *VALUES_OF_ATOMS,
)  # without a meaning for a file of dots
PLACEMENT_OPTIONS = ("probe_radius", "radii", "cavities", "reentrant", "boundary")  # which have none, either


class Names(Container[str]):
    """The names of a kind, as choices of an option: installed packages are asked only for help and for an unknown name."""

    def __init__(self, kind: str, *added: str) -> None:
        self.kind, self.added = kind, added

    def __contains__(self, name: object) -> bool:
        return name in self.added or registry.has(self.kind, name)

    def __iter__(self) -> Iterator[str]:
        return iter([*self.added, *registry.names(self.kind)])

    def __len__(self) -> int:
        return len(self.added) + len(registry.names(self.kind))


class SeveralNames(Names):
    """The names of a kind of which an option takes several, with commas between; they are looked up one by one later."""

    def __contains__(self, name: object) -> bool:
        return True


def number_within(limits: Limits) -> Callable[[str], float]:
    """Return the parser of an option that takes a number within limits, for argparse."""

    def parse(text: str) -> float:
        try:
            value = int(text) if limits.whole else float(text)
        except ValueError:
            value = math.nan
        if not limits.allow(value):
            raise argparse.ArgumentTypeError(f"{text!r} is invalid; it must be {limits.words}")
        return value

    return parse


def add(
    parser: argparse._ActionsContainer,
    name: str,
    *flags: str,
    meaning: str = "",
    has_default: bool = False,
    metavar: str | None = None,
) -> None:
    """Add the option of an argument, with its limits or choices, and the words that it has everywhere or a `meaning` of its own.

    Unless it `has_default`, the option is None where it is not given, so that it can be told from one that is.
    """
    parameter = ARGUMENTS[name]
    allowed: Any = parameter.allowed
    if allowed is bool:
        parser.add_argument(
            f"--{name}", action=argparse.BooleanOptionalAction, default=None, help=meaning or parameter.words
        )
        return
    checks = {"type": number_within(allowed)} if isinstance(allowed, Limits) else {"choices": allowed}
    checks |= {"default": parameter.default} if has_default else {}
    option = f"--{name.replace('_', '-')}"
    parser.add_argument(*flags, option, metavar=metavar, help=meaning or parameter.words, **checks)


def given(args: argparse.Namespace, *names: str) -> dict[str, Any]:
    """Return the arguments of a function that stand on the command line."""
    values = {name: getattr(args, name, None) for name in names}
    return {name: value for name, value in values.items() if value is not None}


def add_file(parser: argparse.ArgumentParser, meaning: str) -> None:
    """Add FILE, which is read."""
    parser.add_argument("file", metavar="FILE", help=meaning)


def add_output(parser: argparse.ArgumentParser, formats: Sequence[str]) -> None:
    """Add the option of the output file."""
    help_text = f"file to write ({' '.join(formats)}, each also .gz)"
    help_text += ", or - for a CSV on stdout" if ".csv" in formats else ""
    parser.add_argument("-o", "--output", required=True, metavar="OUT", help=help_text)


class ModelOrNumber(StoreOnce):
    """Take the number of a model of the file, and `--model spheres` of earlier versions as `--reconstruction spheres`."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: Any = None) -> None:
        if values in MODELS:
            log.warning(
                "write --reconstruction %s in place of --model %s, which version 8 will refuse.",
                values,
                values,
            )
            self.store(parser, namespace, "reconstruction", values, option_string)
        elif re.fullmatch(r"-?\d+", values, re.ASCII):
            self.store(parser, namespace, "model", int(values), option_string)
        else:
            parser.error(f"argument {option_string}: {values!r} is not the number of a model of the file")


def add_reconstruction(parser: argparse.ArgumentParser, meaning: str) -> None:
    """Add the option that says how a surface is reconstructed."""
    add(parser, "reconstruction", meaning=meaning, has_default=True)


def add_molecule(parser: argparse.ArgumentParser, *, with_frame: bool = True) -> None:
    """Add the options that choose atoms of a structure."""
    atoms = parser.add_argument_group("atoms of a structure")
    meaning = f"trajectory whose frames belong to the structure ({TRAJECTORY_LABELS}, or a structure with several frames)"
    atoms.add_argument("--trajectory", help=meaning)
    if with_frame:
        add(atoms, "frame")
    atoms.add_argument("--chains", help="chains that are present, such as A,B")
    atoms.add_argument(
        "--selection",
        help="atoms that are present, as an mdtraj expression, in which residue is the number in the file, and resid counts"
        " from 0; 'all' for every atom (default: protein)",
    )
    atoms.add_argument(
        "--ligands",
        help="ligands that are read with the protein: all (but waters and ions), or residue names such as HEM,ZN, of which FILE"
        " needs one",
    )
    several = atoms.add_mutually_exclusive_group()
    help_text = "number of the only model to read, as written in the file (default: all models, as frames)"
    if any(action.dest == "reconstruction" for action in parser._actions):
        several.add_argument("--model", action=ModelOrNumber, metavar="NUMBER", help=help_text)
    else:
        several.add_argument("--model", type=int, metavar="NUMBER", help=help_text)
    help_text = "read the biological assembly: the copies that a file of one model declares, or all models as one molecule"
    several.add_argument("--assembly", action="store_true", default=None, help=help_text)
    help_text = "read the declared assembly of this name, such as 2, in place of the first one"
    atoms.add_argument("--assembly-name", metavar="NAME", help=help_text)
    help_text = "alternate location of an atom: first (default), highest occupancy, or a letter"
    atoms.add_argument("--altloc", help=help_text)
    help_text = "whether explicit hydrogens are read (default keep)"
    atoms.add_argument("--hydrogens", choices=get_args(Hydrogens), help=help_text)
    help_text = "lowest pLDDT (0 to 100) of the residues of a predicted model that are read (default: all)"
    atoms.add_argument("--plddt", type=number_within(PLDDT), help=help_text)
    add(atoms, "whole")


def add_groups(parser: argparse._ActionsContainer) -> None:
    """Add the option that names partners."""
    help_text = (
        "partners that bury each other, with + between: H,L+G is H and L together against G. A comma joins chains, ranges "
        "(A:10-52) and ligands of one partner (default: each chain of polymers and each ligand that is read)"
    )
    parser.add_argument("--groups", metavar="GROUPS", help=help_text)


def add_column(parser: argparse._ActionsContainer) -> None:
    """Add the option that writes a column of a table as B factors."""
    help_text = (
        "with -o NAME.pdb, column of the table, such as mean_bfactor, that the molecule has as its B factors"
    )
    parser.add_argument("--column", metavar="NAME", help=help_text)


def refuse_column(args: argparse.Namespace) -> None:
    """Raise InputError unless a column is named for a PDB file, and only for one."""
    is_pdb = ends_in(args.output, ".pdb")
    if is_pdb == (args.column is None):
        advice = (
            "name the column of the table that the PDB file holds as B factors"
            if is_pdb
            else "name an output in .pdb, or leave it out"
        )
        raise InputError(f"--column: {advice}.")


def add_residues(parser: argparse._ActionsContainer) -> None:
    """Add the option that reports some residues of the surface of all atoms."""
    help_text = (
        "residues to report, such as A:10-52A,60; to compute the surface of a part alone, use --selection"
    )
    parser.add_argument("--residues", help=help_text)


def add_placement(
    parser: argparse.ArgumentParser, cavities: str | None = " keep", *further: str
) -> argparse._ActionsContainer:
    """Add the group of options that define a surface, with `further` ones, and return it.

    `cavities` says which rule for cavities holds by default; it is None for a command without such a rule.
    """
    group = parser.add_argument_group("surface of a structure")
    add(group, "probe_radius")
    group.add_argument(
        "--radii",
        metavar="TABLE",
        help="atomic radii: dms (default), bondi, or a CSV with the columns radius (Å) and residue_name, atom or element",
    )
    if cavities is not None:
        add(group, "cavities", meaning=f"{ARGUMENTS['cavities'].meaning} (default{cavities})")
    for name in further:
        add(group, name)
    return group


def placement_options(args: argparse.Namespace, cavities: str = "keep") -> dict[str, Any]:
    """Return how dots are placed, by the names of arguments; `cavities` is the rule for cavities where none is given."""
    return {"cavities": cavities} | given(args, *PLACEMENT_OPTIONS)


def add_colours(parser: argparse._ActionsContainer) -> None:
    """Add the option that writes colours with a mesh."""
    help_text = "colour a mesh (.ply .obj .glb) by its first field or by kinds; readers for networks need files without colours"
    parser.add_argument("--colours", action="store_true", help=help_text)


def add_limits(parser: argparse._ActionsContainer) -> None:
    """Add the limits of colours."""
    help_text = "values at the ends of the colours, such as --limits=-5,5, which make files comparable (default: by field)"
    parser.add_argument("--limits", metavar="LOW,HIGH", help=help_text)


def add_ranking(parser: argparse._ActionsContainer) -> None:
    """Add the options by which the residues of a trajectory are ranked."""
    help_text = f"rank residues by how much this changes: {RANK} (default), another column, such as area or buried, or any field"
    parser.add_argument("--rank", metavar="NAME", help=help_text)
    add(parser, "rank_by")


def add_size_of_mesh(parser: argparse._ActionsContainer) -> None:
    """Add the number of vertices of a mesh, and the step that stands for it."""
    add(parser, "n_vertices")
    add(parser, "step")


def refuse_size_of_mesh(args: argparse.Namespace) -> None:
    """Raise InputError for options of a mesh where there is none."""
    if args.colours and not args.mesh:
        raise InputError(
            "--colours colours a mesh, and dots always have colours; add --mesh, or leave the option out."
        )
    sizes = [name for name in ("density", "n_vertices", "step") if getattr(args, name) is not None]
    flags = [f"--{name.replace('_', '-')}" for name in sizes]
    if {*sizes} - {"density"} and not args.mesh:
        raise InputError(f"{flags[-1]} is the size of a mesh; add --mesh, or leave the option out.")
    if len(sizes) > 1:
        raise InputError(f"give either {' or '.join(flags)}, not {'both' if len(flags) == 2 else 'all'}.")


def add_fields(parser: argparse._ActionsContainer, has_table: bool = True) -> None:
    """Add the option that chooses the fields of the dots, and if the command `has_table` those of values of atoms."""
    further = f", maps ({' '.join(MAPS)}), columns of --table" if has_table else ""
    help_text = f"values at the dots: %(choices)s{further}, with commas between"
    parser.add_argument("--fields", choices=SeveralNames("field"), metavar="NAMES", help=help_text)
    if has_table:
        add_values_of_atoms(parser)


def add_values_of_atoms(parser: argparse._ActionsContainer) -> None:
    """Add the options that say values of atoms, and how widely these are averaged."""
    help_text = (
        "CSV with a row for each residue or atom: columns residue (its number in FILE, such as 52A), chain and atom where they"
        " are needed, or residue_name in place of residue for a scale of amino acids, and columns of numbers, which --fields"
        " names; a residue_name beside residue must agree with FILE"
    )
    parser.add_argument("--table", metavar="CSV", help=help_text)
    add(parser, "smooth", metavar="WIDTH")
    help_text = "charges of the potential: table (default; PARSE, with missing hydrogens), pdb2pqr, or the path of a PQR file"
    parser.add_argument("--charges", metavar="CHARGES", help=help_text)


def source_of(args: argparse.Namespace) -> Source:
    """Return FILE, which is recognised once by its content."""
    if not hasattr(args, "source"):
        args.source = open_source(args.file)
    return args.source


def reads_atoms(args: argparse.Namespace) -> bool:
    """Return whether FILE holds atoms rather than dots."""
    return source_of(args).format.name != FILE_OF_DOTS


def refuse_file_of_dots(args: argparse.Namespace) -> NoReturn:
    """Raise InputError for a file that holds dots, or what is known by no format."""
    if suffix(args.file) in registry.suffixes(is_read=True):
        raise InputError(
            f"{args.file} holds dots, and dots hold no atoms; give the structure that they lie on."
        )
    formats = (
        f"a {STRUCTURE_LABELS} file, or one with radii or elements ({', '.join(SPHERE_FORMATS)}); with --trajectory, a "
        f"{TOPOLOGY_LABELS} file will do"
    )
    raise InputError(what_is_no_structure(source_of(args), formats))


def read_spheres_or_atoms(args: argparse.Namespace, action: str) -> tuple[Any, dict[str, Any]]:
    """Return FILE, if it holds spheres, or its molecule, and arguments about that; `action` begins what is said of its atoms."""
    if is_file_of_spheres(args.file):
        refuse_structure_options(args, "spheres")
        return args.file, {}
    if not reads_atoms(args):
        refuse_file_of_dots(args)
    molecule = read_atoms(args)
    say(f"{action} {molecule.n_atoms:,} atoms")
    return molecule, {"frame": args.frame or 0}


def read_dots(
    args: argparse.Namespace, cavities: str = "keep"
) -> tuple[sparsurf.Surface, sparsurf.Molecule | None]:
    """Return the dots of FILE, or those that are placed on its atoms, and its molecule; `args.heard` as of `read_atoms`.

    `cavities` is the rule for cavities where none is given.
    """
    if is_file_of_spheres(args.file):
        refuse_structure_options(args, "spheres")
        with heard(args.file) as args.heard:
            return sparsurf.surface(args.file, d_link=args.d_link, **placement_options(args, cavities)), None
    if not reads_atoms(args):
        refuse_structure_options(args, "dots")
        with heard(args.file) as args.heard:
            return sparsurf.read_surface(args.file), None
    molecule = read_atoms(args)
    say(f"surface of {molecule.n_atoms:,} atoms")
    rules = placement_options(args, cavities)
    return sparsurf.surface(molecule, frame=args.frame or 0, d_link=args.d_link, **rules), molecule


def refuse_structure_options(args: argparse.Namespace, content: str) -> None:
    """Raise InputError for options of a structure where the file holds something else."""
    refused = {
        "dots": (*STRUCTURE_OPTIONS, *PLACEMENT_OPTIONS), "spheres": (*STRUCTURE_OPTIONS, "radii"),
        "structures": ("trajectory", "column", "table", "smooth"),
    }[content]  # fmt: skip
    for name in refused:
        if getattr(args, name, None) is not None:
            raise InputError(
                f"--{name.replace('_', '-')} has no meaning for {args.file}, which holds {content}; leave the option out."
            )


def dots_of_residues(
    args: argparse.Namespace, surface: sparsurf.Surface, molecule: sparsurf.Molecule | None
) -> np.ndarray:
    """Return the dots of the requested residues; all dots without such a request."""
    if args.residues is None or molecule is None:
        return np.arange(len(surface))
    dots = np.flatnonzero(requested_atoms(args, molecule)[surface.atom])
    if not len(dots):
        raise InputError(
            f"--residues: no dot belongs to {args.residues}: these residues are buried, or have no atoms in the selection."
        )
    return dots


def requested_atoms(args: argparse.Namespace, molecule: sparsurf.Molecule) -> np.ndarray:
    """Return the mask (A,) of the atoms of the requested residues."""
    with naming_file(args.file):
        return select_atoms(molecule, residues=args.residues, selection="all")


def names_of_requested_fields(args: argparse.Namespace) -> list[str]:
    """Return the names of the requested fields."""
    for name in () if args.fields is not None else VALUES_OF_ATOMS:
        if getattr(args, name, None) is not None:
            raise InputError(f"--{name} is about values at the dots; name them by --fields, or leave it out.")
    return [] if args.fields is None else split_names(args.fields, "fields", "hydropathy")


def with_requested_fields(
    args: argparse.Namespace, surface: sparsurf.Surface, molecule: sparsurf.Molecule | None
) -> sparsurf.Surface:
    """Return the surface with the requested fields."""
    names = names_of_requested_fields(args)
    if not names:
        return surface
    if molecule is None:
        raise InputError(
            f"--fields: {args.file} holds dots, but fields are computed from atoms; give a structure."
        )
    of_atoms = given(args, *VALUES_OF_ATOMS)
    return _with_columns(
        surface, sparsurf.fields(molecule, surface, names, frame=args.frame or 0, **of_atoms)
    )


def with_fields_of_spheres(surface: sparsurf.Surface, names: Sequence[str]) -> sparsurf.Surface:
    """Return the surface of spheres with the requested fields, which must follow from the spheres alone."""
    if not names:
        return surface
    from sparsurf.api.field_values import check_fields  # here: few ask for fields

    return _with_columns(surface, sparsurf.fields(surface, check_fields(names, "surface")))


def _with_columns(surface: sparsurf.Surface, table: pd.DataFrame) -> sparsurf.Surface:
    """Return the surface with the columns of a table as further fields."""
    columns = {str(name): column.to_numpy() for name, column in table.items()}
    return replace(surface, fields=surface.fields | columns)


def read_atoms(args: argparse.Namespace, of_frames: Mapping[str, Any] | None = None) -> sparsurf.Molecule:
    """Return the molecule of FILE, with all its frames; what reading it said is `args.heard` from now on.

    All frames of the keys `of_frames` of `read_molecule` are used if these are given, and otherwise the one of `--frame`.
    """
    if getattr(args, "radii", None) is not None:
        check_radii(args.radii)  # before a structure is read
    keys = {key: getattr(args, key) for key in ATOM_OPTIONS}
    keys["assembly"] = keys.pop("assembly_name") or bool(keys["assembly"])
    groups = getattr(args, "groups", None)
    keys["groups"] = None if groups == EACH_RESIDUE else groups
    keys["ligands"] = False if keys["ligands"] is None else keys["ligands"]
    with heard(args.file) as args.heard:
        keys |= given(args, *HOW_TO_READ)
        molecule = sparsurf.read_molecule(source_of(args), args.trajectory, **(of_frames or {}), **keys)
    if of_frames is not None:
        return molecule
    name = args.trajectory or args.file
    check_frame(molecule, args.frame or 0, name)
    if molecule.n_frames > 1 and args.frame is None and not args.quiet:
        several = "models" if source_of(args).format.models and not args.trajectory else "frames"
        message = f"{name} has {molecule.n_frames} {several}; the first one is used, and --frame chooses another one."
        print(message, file=sys.stderr)
    return molecule


def about(args: argparse.Namespace, **attributes: Any) -> About:
    """Return what a page or picture says besides the dots; `attributes` are further attributes of About."""
    files = args.file, getattr(args, "trajectory", None)
    model = getattr(args, "model", None)
    return About(
        title(args.file), args.heard, files=files, model=model, command=shlex.join(["sparsurf", *args.words]),
        **attributes,
    )  # fmt: skip


def say(text: str) -> None:
    """Print on a terminal what is being done, and keep it for the lines of a log; not of one of many structures."""
    if not progress.enabled:
        return
    progress.stage = text
    if sys.stderr.isatty():
        print(f"{text} ...", file=sys.stderr, flush=True)
