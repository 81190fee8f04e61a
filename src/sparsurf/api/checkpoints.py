"""Checkpoints: parts of a long result that are stored while it is computed, so that a stopped call continues from them.

The name of a part is a hash of all that it follows from, so that a part of other input or other arguments is never taken.
It cannot be known what a function of the user follows from, so that a call with one takes no parts of another call.
"""

from __future__ import annotations

import hashlib
import json
import logging
import os
import shutil
import tempfile
import uuid
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import chain, compress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf import registry
from sparsurf.files import import_pyarrow
from sparsurf.progress import Progress
from sparsurf.threads import in_processes
from sparsurf.version import __version__

if TYPE_CHECKING:
    import pandas as pd

    from sparsurf.dot_fields.named_fields import FieldLike

log = logging.getLogger("sparsurf")

WAITING_PER_JOB = 4  # tasks
LENGTH_OF_KEY = 32  # letters of the hash in the name of a part
FORMATS = registry.suffixes("frames")  # The formats of tables that are written one after another.
ROWS_PER_GROUP = 100_000  # A group of a Parquet file has at least so many rows.


def digest_of_arguments(*arguments: Any, fields: Sequence[FieldLike]) -> Any:
    """Return a hash, which can be continued, of the version, of arguments and of fields.

    A field of the user makes it a hash of this call alone, because edits of what its function uses cannot be seen.
    """
    of_library = [isinstance(field, str) and _is_of_library(field) for field in fields]
    of_call = [] if all(of_library) else [uuid.uuid4().hex]
    names = [field for field in fields if isinstance(field, str)]
    return hashlib.sha256(f"{__version__} {arguments} {names + of_call}".encode())


def _is_of_library(field: str) -> bool:
    """Return whether the library computes a field of this name; roughness has no entry in the table."""
    choice = registry.choice_of("field", field)
    return choice is None or choice.is_built_in


@contextmanager
def store_beside(path: str | Path, kind: str) -> Iterator[Path]:
    """Open the hidden folder next to a result in which its parts are stored; it is deleted when the result is written.

    Standard output, a pipe and a device have no place for it, so that nothing is left of a call that was stopped.
    """
    result = Path(os.path.realpath(path))
    if str(path) == "-" or (result.exists() and not result.is_file()):
        with tempfile.TemporaryDirectory() as temporary:
            yield Path(temporary)
        return
    store = result.with_name(f".{result.name}.{kind}")
    store.mkdir(exist_ok=True)
    try:
        yield store
    except BaseException:
        if not any(store.iterdir()):
            store.rmdir()
        raise
    shutil.rmtree(store)


def in_parts(
    tasks: Sequence[Any],
    function: Callable[[Any], Any],
    jobs: int,
    unit: str,
    store: Path | None,
    digests: Iterable[Any],
    arrays: Callable[[Any], Mapping[str, np.ndarray] | None],
    size: Callable[[Any], int] = lambda task: 1,
) -> Iterator[tuple[Any, Any]]:
    """Yield the file of the part of each task, in order, and what a function of the task has returned.

    The file is None without a `store`, and the result is None where a call that was stopped has stored it.

    Parameters
    ----------
    tasks : what is computed one by one
    jobs : number of processes
    unit : what progress counts, of which a task has `size`
    store : folder of the parts, from `store_beside`
    digests : for each task a hash of all that it follows from
    arrays : what is stored of a result; None for nothing
    """
    files: list[Any] = [None] * len(tasks)
    if store is not None:
        files = [store / f"{digest.hexdigest()[:LENGTH_OF_KEY]}.npz" for digest in digests]
        stale = {*store.iterdir()} - {*files}
        for path in stale:
            path.unlink()
        if any(path.suffix == ".npz" for path in stale):
            log.warning(
                "%s: parts of a stopped call followed from other input, other arguments or a function of your own, and cannot be "
                "used.", store,
            )  # fmt: skip
    # before the loop, in which files of the same content share a part
    is_left = [file is None or not file.exists() for file in files]
    left = [*compress(tasks, is_left)]
    total = sum(map(size, tasks))
    progress = Progress(unit, total, total - sum(map(size, left)))
    computed = map(function, left) if jobs == 1 else in_processes(function, left, jobs, WAITING_PER_JOB)
    try:
        for task, file, is_next in zip(tasks, files, is_left, strict=True):
            result = next(computed) if is_next else None
            if is_next and file and (stored := arrays(result)) is not None:
                unfinished = file.with_suffix(".part")
                with unfinished.open("wb") as stream:
                    np.savez(stream, **stored)  # type: ignore[arg-type]
                unfinished.replace(file)
            progress.advance(is_next * size(task))
            yield file, result
    finally:
        progress.close()


def table_writers(
    tables: Iterable[pd.DataFrame], failures: Mapping[str, str] | None = None
) -> dict[str, Callable[[Path], Any]]:
    """Return the functions of a path that write tables with the same columns one after another, by suffix.

    `failures`, which is complete when all tables were taken, is stored in the metadata of a Parquet file.
    """

    def csv(path: Path) -> None:
        with path.open("w", encoding="utf-8", newline="") as stream:
            for k, table in enumerate(tables):
                table.to_csv(stream, index=False, header=k == 0, float_format="%.10g")

    def parquet(path: Path) -> None:
        pyarrow = import_pyarrow()
        groups = _groups(tables)
        first = next(groups)
        types = {
            name: pyarrow.from_numpy_dtype(column.dtype) if column.dtype.kind in "biuf" else pyarrow.string()
            for name, column in first.items()
        }
        schema = pyarrow.schema([*types.items()])
        with pyarrow.parquet.ParquetWriter(path, schema, compression="zstd") as writer:
            for table in chain([first], groups):
                writer.write_table(pyarrow.Table.from_pandas(table, schema, preserve_index=False))
            if failures is not None:
                writer.add_key_value_metadata({"failures": json.dumps(failures, ensure_ascii=False)})

    return {".parquet": parquet, ".csv": csv}


def _groups(tables: Iterable[pd.DataFrame]) -> Iterator[pd.DataFrame]:
    """Yield tables joined to at least ROWS_PER_GROUP rows each, but for the last one."""
    import pandas as pd  # here: it takes long to load

    waiting: list[pd.DataFrame] = []
    for table in tables:
        waiting.append(table)
        if sum(map(len, waiting)) >= ROWS_PER_GROUP:
            yield pd.concat(waiting)
            waiting = []
    if waiting:
        yield pd.concat(waiting)
