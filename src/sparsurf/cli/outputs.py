"""The output of a command: checked before anything is computed, and reported when it is written."""

import argparse
import os
import sys
from collections.abc import Callable
from pathlib import Path

from sparsurf.api.about import refuse_missing_matplotlib
from sparsurf.api.writing import SUFFIXES_OF_NUMBERS, DotsToWrite, parse_output, write_dots
from sparsurf.errors import InputError

READ_OPTIONS = ("file", "trajectory", "at")  # which can name a file


def check(
    args: argparse.Namespace,
    formats: tuple[str, ...],
    path_of_second: Callable[[str], Path | None] | None = None,
) -> None:
    """Raise InputError if the output cannot be written in one of the formats, before anything is computed.

    Neither the output nor the second file that is written next to it, whose path `path_of_second` returns, may be an input.
    """
    _refuse_input(args, args.output, "")
    suffix = parse_output(args.output, formats)[0]
    if path_of_second is not None and (second := path_of_second(args.output)) is not None:
        _refuse_input(args, str(second), f", which is written next to {args.output},")
    if suffix == ".png":
        refuse_missing_matplotlib(args.output)
    if suffix == ".dms" and getattr(args, "fields", None):
        raise InputError(
            f"--fields: {suffix} files cannot store fields; name a file that ends in {', '.join(SUFFIXES_OF_NUMBERS)}."
        )


def _refuse_input(args: argparse.Namespace, output: str, description: str) -> None:
    """Raise InputError if an output is a file that the command reads."""
    if os.path.isfile(output):
        files = (getattr(args, key, None) for key in READ_OPTIONS)
        if any(os.path.samefile(f, output) for f in files if isinstance(f, str) and os.path.exists(f)):
            raise InputError(f"{output}{description} is an input file; name another file to write.")


def write_output(args: argparse.Namespace, dots: DotsToWrite) -> None:
    """Write dots and report them."""
    write_dots(args.output, dots)
    report(args, dots.message)


def is_reported(args: argparse.Namespace) -> bool:
    """Return whether what was written is reported: not if it went to standard output or --quiet was given."""
    return args.output != "-" and not args.quiet


def report(args: argparse.Namespace, message: str) -> None:
    """Print what was written."""
    if is_reported(args):
        print(f"wrote {args.output}: {message}", file=sys.stderr, flush=True)
