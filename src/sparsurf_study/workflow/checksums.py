"""SHA-256 of files and folders, kept between runs by size, times and inode; planning a study imports this without numpy."""

import hashlib
import json
import os
import time
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path

from sparsurf.files import checksum_of_file

MARK_OF_SNAKEMAKE = ".snakemake_timestamp"  # which it writes into a folder that is an output
SECONDS_UNTIL_SETTLED = 2.0  # a file that changed later might change again without another time
Stamp = tuple[int, int, int, int]


def stamp(path: str | Path) -> Stamp:
    """Return what changes with a file: size, time of the last edit, time of the last change of its entry, and inode."""
    status = os.stat(path)
    return status.st_size, status.st_mtime_ns, status.st_ctime_ns, status.st_ino


def files_of(path: str | Path) -> list[Path]:
    """Return a file itself, or all files below a folder in the order of their names, without Snakemake's own."""
    path = Path(path)
    if not path.is_dir():
        return [path]
    return sorted(file for file in path.rglob("*") if file.is_file() and file.name != MARK_OF_SNAKEMAKE)


def stamps(paths: Iterable[str]) -> dict[Path, Stamp]:
    """Return the stamps of files and of all files below folders."""
    return {file: stamp(file) for path in paths for file in files_of(path)}


class Checksums:
    """SHA-256 of files by path. With a store, a file whose stamp is unchanged since it was read is not read again."""

    def __init__(self, store: Path | None = None) -> None:
        self.store, self._known = store, dict[str, list]()
        if store is not None:
            with suppress(OSError, ValueError):
                content = json.loads(store.read_text(encoding="utf-8"))
                self._known = content if isinstance(content, dict) else {}
        self._is_new = False

    def of(self, path: str | Path) -> str:
        """Return the SHA-256 of a file, or that of the names and checksums of all files below a folder; FileNotFoundError."""
        if not os.path.isdir(path):
            return self._of_file(path)
        digest = hashlib.sha256()
        for file in files_of(path):
            digest.update(f"{file.relative_to(path).as_posix()}\0{self._of_file(file)}\n".encode())
        return digest.hexdigest()

    def _of_file(self, path: str | Path) -> str:
        # Without a store every byte is read: a check that trusted dates would miss a file that was edited with its former date
        if self.store is None:
            return checksum_of_file(path)
        seen, (last_stamp, digest) = list(stamp(path)), self._known.get(str(path), (None, ""))
        if last_stamp != seen:
            digest = checksum_of_file(path)
            if time.time() - max(seen[1:3]) / 1e9 > SECONDS_UNTIL_SETTLED:
                self._known[str(path)], self._is_new = [seen, digest], True
        return digest

    def of_all(self, paths: Iterable[str | Path]) -> dict[str, str]:
        """Return the SHA-256 of files and folders by path, without those that are missing."""
        found = {}
        for path in map(str, paths):
            with suppress(FileNotFoundError, NotADirectoryError):
                found[path] = self.of(path)
        return found

    def save(self) -> None:
        """Keep what was read in the store, where its folder is and can be written."""
        if (
            self.store is not None and self._is_new and self.store.parent.parent.is_dir()
        ):  # of a run that has begun
            with suppress(OSError):
                write_json(self.store, self._known)
                self._is_new = False


def write_json(path: Path, content: Mapping) -> None:
    """Write JSON that is whole whenever it has its name."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")  # of several jobs, each has its own
    temporary.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    os.replace(temporary, path)
