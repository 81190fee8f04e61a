"""The output of a command: checked before anything is computed, written for one frame or several, and reported."""

import argparse
import os
import re
import sys
from collections.abc import Iterable

import pandas as pd

from sparsurf.api.writing import NUMBERS, Dots, parse_output, write_dots, write_file
from sparsurf.errors import InputError
from sparsurf.surfaces.formats.csv import write_csv

FRAME = "{frame}"  # in the name of a file: its number
READ_OPTIONS = ("file", "trajectory", "at", "table", "charges")  # which can name a file


def check(args: argparse.Namespace, formats: tuple[str, ...]) -> None:
    """Raise InputError if the output cannot be written, before anything is computed.

    Parameters
    ----------
    args : argparse.Namespace
        With `output`, `format` and the files that the command reads.
    formats : tuple of suffixes
    """
    files = [getattr(args, key, None) for key in READ_OPTIONS] + [*getattr(args, "targets", ())]
    if any(_writes_to(args.output, file) for file in files if isinstance(file, str) and file):
        raise InputError(f"{args.output} is a file that is read; name another one to write.")
    suffix = parse_output(args.output, args.format, formats)[0]
    if suffix != ".ply" and getattr(args, "binary", False):
        raise InputError(f"--binary is about a PLY, and {args.output} is none; leave it out.")
    if suffix == ".dms" and getattr(args, "fields", None):
        raise InputError(f"--fields: {suffix} has no room for them; name a file in {', '.join(NUMBERS)}.")
    every_model = getattr(args, "model", None) == "all" and args.frame is None
    several = getattr(args, "frames", None) or every_model
    if several and suffix != ".csv" and FRAME not in str(args.output):
        raise InputError(
            f"{args.output}: several frames need a CSV or {FRAME} in the name, such as dots_{FRAME}.ply."
        )


def _writes_to(output: str, file: str) -> bool:
    """Return whether `output`, for some frame if its name has {frame}, is an existing file."""
    folder, name = os.path.split(output)
    if FRAME not in name:
        return os.path.isfile(output) and os.path.exists(file) and os.path.samefile(file, output)
    of_frame = re.escape(name).replace(re.escape(FRAME), r"\d+")
    of_file, of_output = os.path.dirname(file) or ".", folder or "."
    return bool(re.fullmatch(of_frame, os.path.basename(file))) and (
        os.path.isdir(of_file) and os.path.isdir(of_output) and os.path.samefile(of_file, of_output)
    )


def write_frames(args: argparse.Namespace, results: Iterable[tuple[int, Dots]]) -> None:
    """Write the results of one frame or of several, and report each.

    Parameters
    ----------
    args : argparse.Namespace
    results : iterable of (frame, Dots)
        Several frames become one table with a column `frame`, or a file for each.
    """
    settings = not args.no_faces, args.binary
    tables: list[pd.DataFrame] = []
    fields: set[str] = set()
    for frame, dots in results:
        if FRAME in str(args.output):
            output = str(args.output).replace(FRAME, str(frame))
            write_dots(output, args.format, dots, *settings)
            report(args, output, dots.words)
        elif args.frames:
            tables.append(dots.to_frame())
            tables[-1].insert(0, "frame", frame)
            fields |= dots.surface.fields.keys() - {*dots.table}
        else:
            write_dots(args.output, args.format, dots, *settings)
            report(args, args.output, dots.words)
    if tables:
        table, names = pd.concat(tables, ignore_index=True), sorted(fields)
        write_file(args.output, args.format, (".csv",), {".csv": lambda path: write_csv(path, table, names)})
        report(args, args.output, f"{len(table):,} dots of {len(tables)} frames")


def report(args: argparse.Namespace, output: str, words: str) -> None:
    """Print what was written, unless it went to standard output or --quiet was given."""
    if str(output) != "-" and not args.quiet:
        print(f"wrote {output}: {words}", file=sys.stderr, flush=True)
