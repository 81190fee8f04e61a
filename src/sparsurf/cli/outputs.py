"""The output of a command: checked before anything is computed, and reported when it is written."""

import argparse
import sys
from dataclasses import replace

from sparsurf.api.page_metadata import refuse_missing_matplotlib
from sparsurf.api.replacing import Companions, beside_script, refuse_replacing
from sparsurf.api.writing import SUFFIXES_OF_NUMBERS, DotsToWrite, parse_output, write_dots
from sparsurf.errors import InputError
from sparsurf.surfaces.formats.colours import Scale, check_limits
from sparsurf.surfaces.formats.meshes import BY_TRIMESH, import_trimesh

# The options that can name files which are read.
READ_OPTIONS = ("file", "files", "trajectory", "at", "table", "charges")


def check(args: argparse.Namespace, formats: tuple[str, ...], companions: Companions | None = None) -> None:
    """Raise InputError if the output cannot be written in one of the formats, before anything is computed.

    Neither the output nor its `companions`, the files that are written besides it, may replace what `refuse_replacing` names.
    """
    given = [getattr(args, key, None) for key in READ_OPTIONS]
    inputs = [file for file in given if isinstance(file, str | list)]
    refuse_replacing(args.output, inputs)
    ending = parse_output(args.output, formats)[0]
    companions = {**(companions or {}), **beside_script(args.output)}
    refuse_replacing(args.output, inputs, companions)
    if ending == ".png":
        refuse_missing_matplotlib(args.output)
    if ending in BY_TRIMESH:
        import_trimesh(args.output)
    args.limits = check_limits(getattr(args, "limits", None))
    if ending == ".dms" and getattr(args, "fields", None):
        raise InputError(
            f"--fields: {ending} files hold no fields; name a file that ends in {', '.join(SUFFIXES_OF_NUMBERS)}."
        )


def write_output(args: argparse.Namespace, dots: DotsToWrite) -> None:
    """Write dots and report them, with the values at the ends of their colours."""
    dots = replace(dots, limits=args.limits)
    write_dots(args.output, dots)
    report(args, dots.message, dots.key(args.output))


def is_reported(args: argparse.Namespace) -> bool:
    """Return whether what was written is reported: not if it went to standard output or --quiet was given."""
    return args.output != "-" and not args.quiet


def report(args: argparse.Namespace, message: str, key: Scale | None = None) -> None:
    """Print what was written, and by which scale it is coloured."""
    message += f"\n{key.words}" if key else ""
    if is_reported(args):
        print(f"wrote {args.output}: {message}", file=sys.stderr, flush=True)
