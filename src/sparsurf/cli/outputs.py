"""The output of a command: checked before anything is computed, and reported when it is written."""

import argparse
import os
import sys

from sparsurf.api.about import refuse_missing_matplotlib
from sparsurf.api.writing import SUFFIXES_OF_NUMBERS, DotsToWrite, parse_output, write_dots
from sparsurf.errors import InputError

READ_OPTIONS = ("file", "trajectory", "at")  # which can name a file


def check(args: argparse.Namespace, formats: tuple[str, ...]) -> None:
    """Raise InputError if the output cannot be written in one of the formats, before anything is computed."""
    for key in READ_OPTIONS:
        file = getattr(args, key, None)
        both_exist = isinstance(file, str) and os.path.exists(file) and os.path.isfile(args.output)
        if both_exist and os.path.samefile(str(file), args.output):
            raise InputError(f"{args.output} is an input file; name another file to write.")
    suffix = parse_output(args.output, formats)[0]
    if suffix == ".png":
        refuse_missing_matplotlib(args.output)
    if suffix == ".dms" and getattr(args, "fields", None):
        raise InputError(
            f"--fields: {suffix} files cannot store fields; name a file that ends in {', '.join(SUFFIXES_OF_NUMBERS)}."
        )


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
