"""Apply a function of one file to every structure of a folder or list: in processes, continued after a stop, failures listed."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sparsurf import progress
from sparsurf.api.checkpoints import digest_of_arguments, in_parts, store_beside, table_writers
from sparsurf.api.writing import write_file
from sparsurf.errors import InputError
from sparsurf.files import checksum_of_file, pluralise
from sparsurf.messages import kind_of_warning, listening

if TYPE_CHECKING:
    import pandas as pd

    from sparsurf.dot_fields.named_fields import FieldLike

log = logging.getLogger("sparsurf")

# In a stored table: the beginning of the names of its columns, and the name of its warnings
COLUMN_OF_PART, WARNINGS_OF_PART = "column ", " warnings"


class Outcome(NamedTuple):
    """The result of a structure, or why there is none, and the warnings that its file caused: their kind and sentence."""

    result: Any
    warnings: Any

    def arrays(self) -> dict[str, np.ndarray] | None:
        """Return a result that is a table, and the warnings, as they are stored; nothing of a structure that failed."""
        if isinstance(self.result, str):
            return None
        columns = {
            f"{COLUMN_OF_PART}{name}": column.to_numpy(None if column.dtype.kind in "biuf" else str)
            for name, column in self.result.items()
        }
        return columns | {WARNINGS_OF_PART: np.array(self.warnings, str).reshape(-1, 2)}


class ResultsOfFolder(Iterator[tuple[str, Any]]):
    """The result of each structure of a folder, one after the other by name.

    Attributes
    ----------
    failures : dict, name -> str, why a structure is left out; complete at the end
    """

    def __init__(self, files: Mapping[str, Path], function: Callable[[Path], Any], jobs: int) -> None:
        """Take structures by name, a function of the path of one, and the number of processes."""
        self.failures: dict[str, str] = {}
        self.n_before = 0  # structures that were finished by a call that was stopped
        self._files, self._function, self._jobs = files, function, jobs
        self._results = self._successes()

    def __next__(self) -> Any:
        return next(self._results)

    def write(self, output: str | Path, arguments: Any, fields: Sequence[FieldLike]) -> int:
        """Write the results, which are tables, as one table, and return the number of its rows.

        The table of each structure is stored before. What a stopped call has stored for the same file, `arguments` and `fields`
        is taken from there.
        """
        written: list[int] = []
        with store_beside(output, "structures") as store:
            digests = (
                digest_of_arguments(arguments, _checksum(path), fields=fields)
                for path in self._files.values()
            )
            tables = self._tables(self._successes(store, digests), written)
            write_file(output, table_writers(tables, self.failures))
        return sum(written)

    def _tables(self, results: Iterator[tuple[str, Any]], written: list[int]) -> Iterator[pd.DataFrame]:
        """Yield the table of each structure, and count its rows; raise InputError if there is none."""
        columns: list[str] = []
        for name, table in results:
            columns = columns or [*table]
            if [*table] != columns:
                self.failures[name] = (
                    f"it has other columns than the structures before it: {', '.join(table)}"
                )
                continue
            table.insert(0, "name", name)
            written.append(len(table))
            yield table
        if not written:
            raise InputError("all structures failed; the warnings give the reasons.")

    def _successes(self, store: Path | None = None, digests: Iterable[Any] = ()) -> Iterator[tuple[str, Any]]:
        """Yield the results that there are, and report at the end what was wrong."""
        notes: dict[str, dict[str, str]] = {}  # by kind of warning: sentences by the names of structures
        paths, n = [*self._files.values()], len(self._files)
        outcomes = in_parts(paths, self._outcome, self._jobs, "structures", store, digests, Outcome.arrays)
        for name, (file, outcome) in zip(self._files, outcomes, strict=True):
            if outcome is None:
                self.n_before += 1
                outcome = _stored(file)
            for kind, sentence in outcome.warnings:
                notes.setdefault(kind, {}).setdefault(name, sentence)
            if isinstance(outcome.result, str):
                self.failures[name] = outcome.result
            else:
                yield name, outcome.result
        for sentences in notes.values():
            name, sentence = next(iter(sentences.items()))
            several = "" if len(sentences) == 1 else f"{len(sentences)} of {n} structures, such as "
            log.warning("%s%s: %s", several, name, sentence)
        if self.failures:
            reasons = "; ".join(f"{name}: {reason.rstrip('.')}" for name, reason in self.failures.items())
            of_all = f"of {pluralise(n, 'structure')} {'is' if len(self.failures) == 1 else 'are'}"
            log.warning("%d %s left out: %s", len(self.failures), of_all, reasons)

    def _outcome(self, path: Path) -> Outcome:
        """Return what becomes of a structure."""
        heard: list[logging.LogRecord] = []
        with listening(heard.append), progress.hidden():
            try:
                result = self._function(path)
            except (InputError, OSError) as error:
                result = str(error)
            except MemoryError:
                result = f"{path} needs more memory than there is."
        head = f"{path}: "
        notes = [(kind_of_warning(record), record.getMessage().removeprefix(head)) for record in heard]
        return Outcome(result, notes)


def _stored(file: Path) -> Outcome:
    """Return what a stopped call has stored of a structure."""
    import pandas as pd  # here: it takes long to load

    with np.load(file, allow_pickle=False) as arrays:
        columns = {name.removeprefix(COLUMN_OF_PART): array for name, array in arrays.items()}
    notes = columns.pop(WARNINGS_OF_PART).tolist()
    return Outcome(pd.DataFrame(columns), notes)


def _checksum(path: Path) -> str:
    """Return the checksum of a file; its path if it cannot be read, as nothing is stored of such a file."""
    try:
        return checksum_of_file(path)
    except OSError:
        return str(path)
