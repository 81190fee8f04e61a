"""The command line: `sparsurf COMMAND FILE ...`, also `python -m sparsurf`.

Each command is a module of its own, loaded only when it is asked for, so that a small one starts fast.
"""

import argparse
import logging
import os
import re
import sys
from contextlib import contextmanager
from importlib import import_module

from sparsurf import InputError, __version__

COMMANDS = {
    "surface": "dots with normals of the solvent-excluded surface of a molecule",
    "roughness": "local roughness of every dot",
    "minimal": "the few dots that stand for a surface",
    "recover": "the dense surface of a few dots with normals",
    "descriptors": "2D Zernike descriptors of patches",
    "recommend": "which combination of the paper's sampling suits a surface, from the evidence of many proteins",
}
FAILED, INTERRUPTED = 1, 130  # exit codes; argparse ends with 2 where it does not understand
EPILOG = """\
FILE is a structure (.pdb .ent .cif .mmcif, also .gz; .gro .h5) or, but for `surface`, a file of dots (DMS, CSV with
x,y,z,nx,ny,nz, PLY, or npz). Lengths are in Å. Results go to the file named by -o, in the format of its suffix, or to
standard output with `-o -`; npz and DMS alone keep the area, kind and atom of every dot for reading. What went wrong
is one sentence on standard error.

exit codes: 0 done, 1 the sentence tells what was wrong with a file, 2 the command line was not understood

examples:
  sparsurf surface protein.pdb -o dots.ply
  sparsurf roughness protein.pdb -o - | head
  sparsurf minimal protein.pdb --percent 10 -o minimal.csv
  sparsurf recover minimal.csv -o dense.ply
  sparsurf surface --help
"""


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
    wish = parser.parse_args(arguments)
    try:
        with _warnings_to_stderr():
            modules[wish.command].run(wish)
        sys.stdout.flush()
    except BrokenPipeError:  # the reader, `head` say, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (InputError, OSError) as error:
        print(f"sparsurf {wish.command}: {_sentence(error)}", file=sys.stderr)
        return FAILED
    except MemoryError:
        print(f"sparsurf {wish.command}: there is not enough memory; ask for fewer dots.", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        print(f"sparsurf {wish.command}: interrupted", file=sys.stderr)
        return INTERRUPTED
    return 0


def build_parser(asked=None):
    """The parser, with all options of the command `asked` and one line for each of the others; and its module."""
    parser = argparse.ArgumentParser(
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
        modules[name] = import_module(f"sparsurf.calls.{name}_command")
        own = commands.add_parser(
            name,
            help=line,
            description=f"{line[0].upper()}{line[1:]}.",
            epilog=modules[name].EXAMPLES,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
        modules[name].arguments(own)
    return parser, modules


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
        return f"{error.filename or 'the output'}: {error.strerror}."
    return str(error)
