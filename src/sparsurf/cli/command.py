"""The command line: `sparsurf COMMAND FILE ...`, also `python -m sparsurf`.

Each command is a module of its own, loaded only when it is asked for, so that a small one starts fast.
"""

import argparse
import logging
import os
import re
import sys
from contextlib import contextmanager, suppress
from importlib import import_module

from sparsurf import InputError, __version__, printable, progress

COMMANDS = {
    "surface": "dots with normals of the solvent-excluded surface of a molecule",
    "roughness": "local roughness of every dot",
    "minimal": "the few dots that stand for a surface",
    "recover": "the dense surface of a few dots with normals",
    "descriptors": "2D Zernike descriptors of patches",
    "find": "the same site on other surfaces",
    "recommend": "which combination of the paper's sampling suits a surface, from the evidence of many proteins",
}
FAILED, NOT_UNDERSTOOD, INTERRUPTED = 1, 2, 130  # exit codes
EPILOG = """\
FILE is a structure (.pdb .ent .cif .mmcif, also .gz; .gro .h5) or, except for `surface`, a file of dots (DMS, CSV with
x,y,z,nx,ny,nz, PLY, npz or .minimal). Lengths are in Å. -o names the file of the result, and its suffix the format; `-o -`
writes to standard output. npz and DMS keep the area, kind and atom of every dot. Errors are one sentence on standard error.

exit codes: 0 done, 1 the sentence says what is wrong with a file, 2 the command line was not understood

examples:
  sparsurf surface protein.pdb -o dots.ply
  sparsurf roughness protein.pdb -o - | head
  sparsurf minimal protein.pdb --percent 10 -o minimal.csv
  sparsurf recover minimal.csv -o dense.ply
  sparsurf surface --help
"""


class Parser(argparse.ArgumentParser):
    """One that answers a mistake with a sentence, and not with all its options."""

    def error(self, message):
        """End with the sentence and where to read more."""
        self.exit(NOT_UNDERSTOOD, f"{self.prog}: {message}. See {self.prog} --help.\n")


def main(arguments=None):
    """Run one command; returns its exit code.

    Parameters
    ----------
    arguments : list of str
        Of the command line; those of the process without.
    """
    arguments = sys.argv[1:] if arguments is None else list(arguments)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # not so where a test catches it
            stream.reconfigure(errors="replace")  # of a locale without Å
    for k in reversed(range(len(arguments) - 1)):  # -3-2 is a range of residues, no option
        if arguments[k] == "--residues" and re.match(r"-\d", arguments[k + 1]):
            arguments[k : k + 2] = [f"--residues={arguments[k + 1]}"]
    parser, modules = build_parser(next((each for each in arguments if not each.startswith("-")), None))
    asked, others = parser.parse_known_args(arguments)
    if others and not (hasattr(asked, "targets") and all(each[:1] != "-" for each in others)):
        several = not any(each.startswith("-") for each in others)
        hint = " (one file at a time; a study takes a folder of them)" if several else ""
        parser.error(f"unrecognized arguments: {' '.join(others)}{hint}")
    if others:  # files after an option, which argparse has given to no list that may be empty
        asked.targets += others
    progress.enabled = not asked.quiet
    try:
        with _warnings_to_stderr(), _compiling(asked.quiet):
            modules[asked.command].run(asked)
        sys.stdout.flush()
    except BrokenPipeError:  # the reader, `head` say, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (InputError, OSError) as error:
        print(f"sparsurf {asked.command}: {_sentence(error)}", file=sys.stderr)
        return FAILED
    except MemoryError:
        print(f"sparsurf {asked.command}: there is not enough memory; ask for fewer dots.", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        print(f"sparsurf {asked.command}: interrupted", file=sys.stderr)
        return INTERRUPTED
    return 0


def build_parser(asked=None):
    """The parser, with all options of the command `asked` and one line for each of the others; and its module."""
    parser = Parser(
        prog="sparsurf",
        description="Minimal representations of molecular surfaces.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"sparsurf {__version__}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True, title="commands")
    modules = {}
    for name, line in COMMANDS.items():
        if name != asked:
            commands.add_parser(name, help=line)
            continue
        modules[name] = import_module(f"sparsurf.cli.{name}")
        own = commands.add_parser(
            name,
            help=line,
            description=f"{line[0].upper()}{line[1:]}.",
            epilog=modules[name].EXAMPLES,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
        modules[name].arguments(own)
        own.add_argument("-q", "--quiet", action="store_true", help="say only what went wrong")
    return parser, modules


@contextmanager
def _compiling(quiet):
    """Say when kernels are compiled, before the first of them; those that were compiled before are only loaded."""
    from numba.core import event  # here: a command's module needs it anyway, --help does not

    class Listener(event.Listener):
        def on_start(self, _):
            event.unregister("numba:compile", self)
            print("Compiling kernels, once: up to half a minute ...", file=sys.stderr, flush=True)

        def on_end(self, _):
            pass

    listener = Listener()
    if not quiet:
        event.register("numba:compile", listener)
    try:
        yield
    finally:
        with suppress(ValueError):  # gone already
            event.unregister("numba:compile", listener)


@contextmanager
def _warnings_to_stderr():
    """What the library warns of, one line each; its notes are for the logs of a study."""
    handler = logging.StreamHandler()  # the standard error of now: tests exchange it
    handler.setFormatter(logging.Formatter("sparsurf: warning: %(message)s"))
    log = logging.getLogger("sparsurf")
    before, propagate, level = log.handlers, log.propagate, log.level
    log.handlers, log.propagate = [handler], False
    log.setLevel(logging.WARNING)
    try:
        yield
    finally:
        log.handlers, log.propagate = before, propagate
        log.setLevel(level)


def _sentence(error):
    if isinstance(error, OSError):
        return printable(f"{error.filename or 'the output'}: {error.strerror}.")
    return str(error)
