"""Parts of a long result that are stored while it is computed, so that a call that was stopped continues from them.

The name of a part is a hash of all that it follows from, so that a part of other input or other arguments is never taken.
It cannot be known what a function of the user follows from, so that a call with one takes no parts of another call.
"""

from __future__ import annotations

import hashlib
import logging
import shutil
import uuid
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf import kinds
from sparsurf.files import pluralise
from sparsurf.version import __version__

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sparsurf.dot_fields.registry import FieldLike

log = logging.getLogger("sparsurf")

LENGTH_OF_KEY = 32  # letters of the hash in the name of a part


def digest_of_arguments(*arguments: Any, fields: Sequence[FieldLike] = ()) -> Any:
    """Return a hash, which can be continued, of the version, of arguments and of fields.

    A field of the user makes it a hash of this call alone, because edits of what its function uses cannot be seen.
    """
    of_library = [isinstance(field, str) and _is_of_library(field) for field in fields]
    of_call = [] if all(of_library) else [uuid.uuid4().hex]
    names = [field for field in fields if isinstance(field, str)]
    return hashlib.sha256(f"{__version__} {arguments} {names + of_call}".encode())


def _is_of_library(field: str) -> bool:
    """Return whether the library computes a field of this name; roughness has no entry in the table."""
    choice = kinds.choice_of("field", field)
    return choice is None or choice.is_built_in


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
            "%s: %s of a stopped call followed from other input, other arguments or a function of your own, and cannot be used.",
            result, pluralise(len(finished), kind),
        )  # fmt: skip


def write_part(file: Path, arrays: Mapping[str, np.ndarray]) -> None:
    """Write a part under its final name once it is whole."""
    unfinished = file.with_suffix(".part")
    with unfinished.open("wb") as stream:
        np.savez(stream, **arrays)  # type: ignore[arg-type]
    unfinished.replace(file)
