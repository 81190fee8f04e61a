"""`sparsurf points`: a few points with normals on the surface of a structure, or of every structure of a folder."""

import argparse
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from sparsurf import progress
from sparsurf.api.inputs import is_structure
from sparsurf.api.points import JOBS, N_POINTS, points, points_of
from sparsurf.api.writing import write_file
from sparsurf.arguments import DENSITY, NUMBER_OF_DOTS
from sparsurf.cli import options, outputs
from sparsurf.errors import InputError
from sparsurf.files import import_pyarrow, pluralise
from sparsurf.molecules.formats import STRUCTURES, stem
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf.surfaces.surface import Surface

TABLE = ".parquet"
FORMATS = (TABLE, ".npz", ".ply")
COLUMNS = ("x", "y", "z", "nx", "ny", "nz")
ROWS_PER_GROUP = 100_000  # of a Parquet file
EXAMPLES = """\
FILE is a structure, or a folder of structures, whose points become one Parquet table with the columns name, x, y, z, nx, ny
and nz (float32, Å). The points lie exactly on the surface, as far from one another as possible, with its analytic
normals; without points in closed cavities. The same structure gives the same bytes on every machine. An npz holds
points and normals, (n, 3) each. Of a folder, structures that fail are left out with a warning.

examples:
  sparsurf points structures/ -n 1024 -o points.parquet
  sparsurf points protein.pdb -n 512 -o points.npz
  sparsurf points protein.pdb --density 0.5 -o points.ply
"""
Named = Iterable[tuple[str, np.ndarray, np.ndarray]]


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("file", metavar="FILE", help="structure, or folder of structures")
    options.add_output(parser, FORMATS)
    size = parser.add_mutually_exclusive_group()
    size.add_argument(
        "-n",
        "--n-dots",
        type=options.number(NUMBER_OF_DOTS),
        help=f"number of points on each structure (default {N_POINTS})",
    )
    size.add_argument("--density", type=options.number(DENSITY), help="points per Å^2 instead")
    options.add_seed(parser, "of the first point, from which the others follow")
    options.add_probe_radius(parser)
    parser.add_argument(
        "--jobs", type=options.number(JOBS), default=1, help="processes for a folder (default 1)"
    )


def run(args: argparse.Namespace) -> None:
    """Write the points."""
    is_folder = Path(args.file).is_dir()
    if not is_folder and not is_structure(args.file):
        raise InputError(f"{args.file} is not a structure ({', '.join(STRUCTURES)}), and no folder.")
    formats = (TABLE,) if is_folder else FORMATS
    outputs.check(args, formats)
    settings = {"density": args.density, "seed": args.seed, "probe_radius": args.probe_radius}
    written: list[int] = []
    if is_folder:
        results = points_of(args.file, args.n_dots, jobs=args.jobs, **settings)
        named: Named = progress.progress_bar(results, "structures")
        writers: dict[str, Callable[[Path], Any]] = {}
    else:
        xyz, normals = points(args.file, args.n_dots, **settings)
        named = [(stem(args.file), xyz, normals)]
        writers = {
            ".npz": lambda path: np.savez(path, points=xyz, normals=normals),
            ".ply": lambda path: write_ply(path, Surface(xyz, normals)),
        }
    writers[TABLE] = lambda path: _write_table(path, named, written)
    write_file(args.output, formats, writers)
    n, structures = (
        (sum(written), pluralise(len(written), "structure")) if is_folder else (len(xyz), "the surface")
    )
    outputs.report(args, f"{n:,} points on {structures}")


def _write_table(path: Path, named: Named, written: list[int]) -> None:
    """Write a Parquet table of all points, a few structures at a time; count the points of each in `written`."""
    pyarrow = import_pyarrow()
    numbers = [(column, pyarrow.float32()) for column in COLUMNS]
    schema = pyarrow.schema([("name", pyarrow.string()), *numbers])
    with pyarrow.parquet.ParquetWriter(path, schema, compression="zstd") as writer:
        waiting: list[tuple[str, np.ndarray]] = []
        for name, xyz, normals in named:
            waiting.append((name, np.hstack([xyz, normals])))
            written.append(len(xyz))
            if sum(len(rows) for _, rows in waiting) >= ROWS_PER_GROUP:
                writer.write_table(_table(pyarrow, schema, waiting))
                waiting = []
        if not written:
            raise InputError("points: no structure was left; the warnings say why.")
        if waiting:
            writer.write_table(_table(pyarrow, schema, waiting))


def _table(pyarrow: Any, schema: Any, named: list[tuple[str, np.ndarray]]) -> Any:
    """Return the rows of a few structures."""
    columns = np.ascontiguousarray(np.concatenate([rows for _, rows in named]).T)
    names = np.repeat([name for name, _ in named], [len(rows) for _, rows in named])
    return pyarrow.table([pyarrow.array(names, pyarrow.string()), *columns], schema=schema)
