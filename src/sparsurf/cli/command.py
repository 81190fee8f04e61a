"""The command line: `sparsurf COMMAND FILE ...`, also `python -m sparsurf`.

Each command is a module of its own, loaded only when it is called, so that a small one starts fast.
"""

from __future__ import annotations

import argparse
import errno
import logging
import os
import re
import sys
import textwrap
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from importlib import import_module
from typing import Any, NoReturn

from sparsurf import FUNCTIONS, __version__, progress, registry
from sparsurf.arguments import did_you_mean
from sparsurf.errors import InputError, name_in_call, printable
from sparsurf.files import open_closed_streams
from sparsurf.garbage_collection import collect_rarely
from sparsurf.kernel_cache import require_kernel_cache
from sparsurf.messages import listening
from sparsurf.molecules.formats import STRUCTURE_LABELS, TOPOLOGY_LABELS
from sparsurf.threads import ignore_numba_threads

COMMANDS = {
    "show": "an interactive page of a molecule: its surface, roughness, fields and residues",
    "surface": "dots with normals of the solvent-excluded surface of a molecule",
    "roughness": "local roughness of every dot",
    "residues": "area, roughness and fields, such as the B factor, of the surface of every residue",
    "areas": "accessible (SASA), excluded and buried area of atoms, residues, chains, ligands and groups, exactly",
    "regions": "patches of a surface where a field is above or below a threshold, with their areas and residues",
    "frames": "areas and burial, roughness and fields of every residue and ligand in every frame of a trajectory",
    "points": "a few points with normals of a structure",
    "minimal": "keep few dots that represent a surface",
    "atoms": "the atoms that determine the surface of a molecule exactly",
    "recover": "reconstruct a dense surface from a few dots with normals",
    "descriptors": "2D Zernike descriptors of patches",
}
WORDS_OF_USERS = {  # and what does it
    "sasa": "write `sparsurf areas`", "contacts": "write `sparsurf areas --of contacts`", "patches": "write `sparsurf regions`",
    "mesh": "write `sparsurf surface --mesh`", "pockets": "the page 'Partners' of the documentation names programs that do this",
}  # fmt: skip
FAILED, NOT_UNDERSTOOD, INTERRUPTED = 1, 2, 130  # exit codes
TERMINAL_WIDTH = 80
EPILOG = f"""\
FILE is a structure ({STRUCTURE_LABELS}; with --trajectory also {TOPOLOGY_LABELS}) or a file of dots
({" ".join(registry.suffixes("dots", is_read=True))}; a CSV has the columns x,y,z,nx,ny,nz).
Both may be compressed (.gz .bz2 .xz), except for HDF5. `sparsurf frames --help` lists the formats of trajectories. `surface`,
`residues`, `areas`, `frames`, `points` and `atoms` accept no dots, and `recover` accepts only dots. All commands but `residues`,
`frames` and `recover` also accept files of spheres ({" ".join(registry.suffixes("spheres", is_read=True))}).
`areas`, `residues` and `points` write one table of a folder or of several files. Lengths are in Å. -o names the file
of the result, and its suffix determines the format; an existing file of this name is replaced, but never an input. `-o -` writes
to standard output, and -q prints only warnings and errors. npz and DMS keep the area, kind
and atom of every dot. Errors are printed on standard error.

exit codes: 0 success, 1 an input file or a value is wrong, 2 the command line is wrong

examples:
  sparsurf show protein.pdb
  sparsurf surface protein.pdb -o dots.ply
  sparsurf roughness protein.pdb -o - | head
  sparsurf areas fab_antigen.pdb --groups H,L+G --of pairs -o -
  sparsurf frames complex.pdb --trajectory run.xtc --ligands LIG -o run.csv
  sparsurf residues protein.pdb --fields bfactor -o residues.csv
  sparsurf minimal protein.pdb --percent 10 -o minimal.csv
  sparsurf recover minimal.csv -o dense.ply
  sparsurf surface --help
"""


class StoreOnce(argparse.Action):
    """Store the value of an option, and refuse the option where it is repeated: argparse would keep the last value."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        """Store the value, unless this option had one."""
        self.store(parser, namespace, self.dest, values, option_string)

    def store(self, parser: Any, namespace: Any, name: str, value: Any, option_string: str | None) -> None:
        """Store a value under a name, unless this option gave that name one."""
        given = vars(namespace).setdefault("given", set())
        if option_string and name in given:
            parser.error(f"{option_string} is given twice; give it once")
        given.add(name)
        setattr(namespace, name, value)


class Parser(argparse.ArgumentParser):
    """A parser that answers a mistake with one sentence, not with all its options."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        """Make the parser as argparse does; its options take one value."""
        settings |= {"formatter_class": argparse.RawDescriptionHelpFormatter, "allow_abbrev": False}
        super().__init__(*args, **settings)
        self.register("action", None, StoreOnce)
        self.register("action", "store", StoreOnce)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse as argparse does, and keep the words for `error`."""
        self.words = sys.argv[1:] if args is None else list(args)
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        """Exit with the sentence, the name that the user may have meant, and where to read more."""
        hint = ""
        if message.startswith("the following arguments are required"):
            names = self._option_string_actions
            options = [word.split("=")[0] for word in self.words if word.startswith("--")]
            unknown = [word for word in options if not any(name.startswith(word) for name in names)]
            if unknown:  # a misspelt option is told first: it may be the one that is missing
                self.refuse_unknown(unknown[:1])
        if choice := re.search(r"invalid choice: '(.*)' \(choose from (.*)\)$", message):
            word = choice[1].lower().removesuffix("s")
            meant = [text for name, text in WORDS_OF_USERS.items() if name.removesuffix("s") == word]
            of_command = meant and "areas" in choice[2]
            hint = (
                f"; {meant[0]}." if of_command else did_you_mean(choice[1], re.findall(r"[\w.-]+", choice[2]))
            )
        self._exit_with(message, hint)

    def refuse_unknown(self, unknown: Sequence[str], advice: str = "") -> NoReturn:
        """Exit with the words that nothing is known about, and the option that the user may have meant by one of them."""
        option = next((word.split("=")[0] for word in unknown if word.startswith("-")), None)
        hint = did_you_mean(option, ["--quiet", *self._option_string_actions]) if option else ""
        self._exit_with(f"unrecognized arguments: {' '.join(unknown)}{advice}", hint)

    def _exit_with(self, message: str, hint: str) -> NoReturn:
        """Exit with one sentence."""
        self.exit(NOT_UNDERSTOOD, f"{self.prog}: {message}{hint or '.'} See {self.prog} --help.\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command, by default that of the process, and return its exit code."""
    if arguments is None:  # the process belongs to the command
        arguments = sys.argv[1:]
        collect_rarely()
    arguments = list(arguments)
    open_closed_streams()
    ignore_numba_threads()
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # a test may have replaced it
            stream.reconfigure(errors="replace")  # of a locale without Å
    for k in reversed(
        range(len(arguments) - 1)
    ):  # -3-2 is a range of residues, and -5,5 are limits, no options
        if arguments[k] in ("--residues", "--limits") and re.match(r"-[\d.]", arguments[k + 1]):
            arguments[k : k + 2] = [f"{arguments[k]}={arguments[k + 1]}"]
    quiet = [word for word in arguments if word in ("-q", "--quiet")]  # before a command or after it
    arguments = quiet + [word for word in arguments if word not in quiet]
    os.environ["MPLBACKEND"] = "agg"  # whatever Jupyter or a desktop sets
    command = next((word for word in arguments if not word.startswith("-")), None)
    try:
        if command in COMMANDS:  # its module loads kernels
            require_kernel_cache()
    except InputError as error:
        print(f"sparsurf {command}: {error}", file=sys.stderr)
        return FAILED
    parser, options = build_parser(command)
    with _warnings_to_stderr():  # of options that were renamed
        args, unparsed = parser.parse_known_args(arguments)
    if unparsed:
        several = not any(word.startswith("-") for word in unparsed)
        advice = "one file at a time, the rest are options such as --trajectory; a study takes a folder"
        advice = "give all files before the options" if command in ("areas", "residues", "points") else advice
        hint = f" ({advice})" if several else ""
        if command == "frames" and "--frame" in unparsed:
            hint = " (frames measures all frames; residues --frame measures one)"
        (options or parser).refuse_unknown(unparsed, hint)
    args.words = arguments  # which a page names as its command
    progress.enabled = not args.quiet
    try:
        with _warnings_to_stderr(options), _compiling(args.quiet), progress.lines_in_log(args.command):
            args.function(args)
        sys.stdout.flush()
    except BrokenPipeError:  # the reader, `head` say, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (InputError, OSError) as error:
        print(f"sparsurf {args.command}: {_sentence(error, options)}", file=sys.stderr)
        return FAILED
    except MemoryError:
        print(f"sparsurf {args.command}: there is not enough memory; ask for fewer dots.", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        print(f"sparsurf {args.command}: interrupted", file=sys.stderr)
        return INTERRUPTED
    return 0


def build_parser(command: str | None) -> tuple[Parser, Parser | None]:
    """Return the parser, with a line for each command, and the parser of one command with all its options."""
    parser = Parser(
        prog="sparsurf",
        description="Minimal representations of molecular surfaces.",
        epilog=wrapped(EPILOG),
    )
    parser.add_argument(
        "-q",
        "--quiet",
        action="store_true",
        help="print only warnings and errors (accepted by every command)",
    )
    parser.add_argument("--version", action="version", version=f"sparsurf {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True, title="commands")
    options = None
    for name, line in COMMANDS.items():
        if name != command:
            commands.add_parser(name, help=line)
            continue
        module = import_module(f"sparsurf.cli.{name}")
        options = commands.add_parser(
            name,
            help=line,
            description=f"{line[0].upper()}{line[1:]}.",
            epilog=wrapped(module.EXAMPLES),
        )
        module.arguments(options)
        options.set_defaults(function=module.run)
    return parser, options


def wrapped(text: str) -> str:
    """Fill paragraphs to the width of a terminal; indented lines stay as they are."""
    blocks = []
    for block in text.split("\n\n"):
        lines = block.splitlines()
        head = [line for line in lines if not line.startswith(" ")]
        indented = [line for line in lines if line.startswith(" ")]
        blocks.append(
            "\n".join([textwrap.fill(" ".join(head), TERMINAL_WIDTH, break_on_hyphens=False), *indented])
        )
    return "\n\n".join(blocks) + "\n"


@contextmanager
def _compiling(quiet: bool) -> Iterator[None]:
    """Print a message before the first kernel is compiled; kernels that were compiled before are only loaded."""

    def tell() -> None:
        progress.before_compiling = None
        notice = "Compiling this command for its first use, which takes up to half a minute ..."
        print(notice, file=sys.stderr, flush=True)

    progress.before_compiling = None if quiet else tell
    try:
        yield
    finally:
        progress.before_compiling = None


def _warnings_to_stderr(options: Parser | None = None) -> AbstractContextManager[None]:
    """Print warnings of the library, one line each; its notes are for the logs of a study."""

    def warn(record: logging.LogRecord) -> None:
        sentence = getattr(record, "sentence", None)
        text = record.getMessage() if sentence is None else sentence.worded(_option_of(options))
        print(f"sparsurf: warning: {text}", file=sys.stderr)

    return listening(warn)


def _option_of(options: Parser | None) -> Callable[[str], str]:
    """Return a function that returns the option of an argument, or the argument itself where the command has none."""

    def option(argument: str) -> str:
        name = name_in_call(argument)
        word = "--" + name.replace("_", "-")
        return word if options is not None and word in options._option_string_actions else name

    return option


def _sentence(error: InputError | OSError, options: Parser | None) -> str:
    """Return the message of an error, with the options of the command where it names arguments."""
    if isinstance(error, OSError):
        is_full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        advice = " Free space on this disk, or name an output on another one." if is_full else ""
        return printable(f"{error.filename or 'the output'}: {error.strerror}.{advice}")
    message = error.worded(_option_of(options))
    command, _, reason = message.partition(": ")
    return (
        reason if command in COMMANDS or command in FUNCTIONS else message
    )  # the line begins with the command already
