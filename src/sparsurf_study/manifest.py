"""SHA256SUMS of a run: every result with its checksum, as `sha256sum -c` reads it."""

import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path

from sparsurf.files import checksum_of_file

NAME = "SHA256SUMS"


def write_sums(run: Path, sums: Mapping[str, str]) -> None:
    """Write the manifest of a run, whole or not at all."""
    new = run / f".{NAME}.new"
    lines = "".join(f"{digest}  {name}\n" for name, digest in sorted(sums.items()))
    try:
        new.write_text(lines, encoding="utf-8")
        os.replace(new, run / NAME)
    except OSError:  # such as a full disk, which names no file
        new.unlink(missing_ok=True)
        raise


def sums_of(run: Path, files: Iterable[Path]) -> dict[str, str]:
    """Return the checksums of files by their names from the folder of a run."""
    return {file.relative_to(run).as_posix(): checksum_of_file(file) for file in files}


def read_sums(run: Path) -> dict[str, str]:
    """Return the checksums in the manifest of a run by name; none before its end."""
    try:
        text = (run / NAME).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return {}
    return {name: digest for digest, name in re.findall(r"^([0-9a-f]{64})  (.+)$", text, re.M)}


def keep(run: Path, names: Collection[str]) -> None:
    """Keep only some lines of a manifest: results are about to change, apart from those that are to be what they were."""
    if kept := {name: digest for name, digest in read_sums(run).items() if name in names}:
        write_sums(run, kept)
    else:
        (run / NAME).unlink(missing_ok=True)


def differing(run: Path) -> Iterator[tuple[str, str]]:
    """Yield the files of a run that are not as its end found them, with what they are: missing or changed."""
    for name, digest in read_sums(run).items():
        path = run / name
        if not path.is_file():
            yield name, "missing"
        elif checksum_of_file(path) != digest:
            yield name, "changed"
