"""Run a command on each structure of a folder, or of several files, and write one table of what it measures."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from sparsurf import registry
from sparsurf.cli import options, outputs
from sparsurf.files import pluralise
from sparsurf.molecules.listing import structures_in
from sparsurf.surfaces.radii import check_radii

# Arguments from which no result follows
IRRELEVANT = {"file", "files", "function", "given", "jobs", "output", "quiet", "words"}
FOLDERS_IN_HELP = """\
FILE may also be a folder, or several files. One table (.csv .parquet) then begins with the column name: the path of each
structure below the folder without its suffix, such as job1/model, or in a list the shortest end of the path that no other file
has. Folders below are read as well, and a warning names other files that hold structures. Options hold for each structure, and
structures that cannot be read are left out and named at the end. A call that was stopped continues from the structures that were
finished, and writes the same bytes.
"""


def add_files(parser: argparse.ArgumentParser, meaning: str) -> None:
    """Add FILE, which may be a folder or several files, and the number of processes."""
    parser.add_argument("files", nargs="+", metavar="FILE", help=f"{meaning}, a folder, or several files")
    options.add(parser, "jobs", has_default=True)


def written(
    args: argparse.Namespace,
    formats: tuple[str, ...],
    compute: Callable[..., Any],
    fields: Sequence[Any] = (),
) -> bool:
    """Return whether FILE is a folder or several files, of which one table is written then; check the output of one file.

    `compute` returns what is written of the structure `args.file`: points, or a table and more.
    """
    given = args.files if len(args.files) > 1 else args.files[0]
    args.file = "the list of files" if len(args.files) > 1 else given
    is_one = given is args.file and not os.path.isdir(given)
    outputs.check(args, formats if is_one else registry.suffixes("frames"))
    if is_one:
        return False
    import pandas as pd

    from sparsurf.api.field_values import refuse_maps  # here, as below: a missing file needs no numba
    from sparsurf.api.folders import ResultsOfFolder

    options.refuse_structure_options(args, "structures")
    refuse_maps(fields, args.command)
    args.radii = args.radii and check_radii(args.radii)  # what results follow from is not the name of a file
    files = structures_in(given)
    arguments = {name: value for name, value in vars(args).items() if name not in IRRELEVANT}

    def table_of(path: Path) -> Any:
        """Return the table of one structure."""
        result = compute(argparse.Namespace(**arguments, file=str(path), quiet=True))
        return result.to_frame() if hasattr(result, "to_frame") else pd.DataFrame(result[0])

    results = ResultsOfFolder(files, table_of, args.jobs)
    rows = results.write(args.output, sorted(arguments.items()), fields)
    n_folders = len({path.parent for path in files.values()})
    text = f"{pluralise(len(files) - len(results.failures), 'structure')} in {pluralise(n_folders, 'folder')}, {rows:,} rows"
    text += f", {results.n_before:,} finished before" if results.n_before else ""
    text += f"; left out: {', '.join(results.failures)}" if results.failures else ""
    outputs.report(args, text)
    return True
