"""Parts of a long result that are stored while it is computed, so that a call that was stopped continues from them.

The name of a part is a hash of all that it follows from, so that a part of other input or other arguments is never taken.
"""

from __future__ import annotations

import hashlib
import logging
import shutil
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.dot_fields.registry import names_of_fields
from sparsurf.files import pluralise
from sparsurf.version import __version__

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sparsurf.dot_fields.registry import FieldLike

log = logging.getLogger("sparsurf")

LENGTH_OF_KEY = 32  # letters of the hash in the name of a part


def digest_of_arguments(*arguments: Any, fields: Sequence[FieldLike] = ()) -> Any:
    """Return a hash, which can be continued, of the version, of arguments and of fields; a function of the user is its code."""
    digest = hashlib.sha256(f"{__version__} {arguments}".encode())
    for field in fields:
        code = getattr(field, "__code__", None)
        digest.update(f"{field if isinstance(field, str) else names_of_fields((field,), 'fields')}".encode())
        digest.update(b"" if code is None else code.co_code + repr(code.co_consts).encode())
    return digest


def part_file(store: Path, digest: Any) -> Path:
    """Return the file of the part that follows from what a hash was taken of."""
    return store / f"{digest.hexdigest()[:LENGTH_OF_KEY]}.npz"


@contextmanager
def store_beside(path: str | Path, kind: str) -> Iterator[Path]:
    """Open the hidden folder next to a result in which its parts are stored; it is deleted when the result is written."""
    store = Path(path).with_name(f".{Path(path).name}.{kind}")
    store.mkdir(exist_ok=True)
    try:
        yield store
    except BaseException:
        if not any(store.iterdir()):
            store.rmdir()
        raise
    shutil.rmtree(store)


def forget_other_parts(store: Path, files: Collection[Path], result: str, kind: str) -> None:
    """Delete the stored parts that are not among the files of this call, and say in one line that they cannot be used."""
    stale = set(store.iterdir()) - set(files)
    finished = [path for path in stale if path.suffix == ".npz"]
    for path in stale:
        path.unlink()
    if finished:
        log.warning(
            "%s: %s of a stopped call followed from other input or other arguments, and cannot be used.",
            result, pluralise(len(finished), kind),
        )  # fmt: skip


def write_part(file: Path, arrays: Mapping[str, np.ndarray]) -> None:
    """Write a part under its final name once it is whole."""
    unfinished = file.with_suffix(".part")
    with unfinished.open("wb") as stream:
        np.savez(stream, **arrays)  # type: ignore[arg-type]
    unfinished.replace(file)
