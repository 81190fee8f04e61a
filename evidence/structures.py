"""The structures of the evidence: a table of names, files, sources and checksums, and the sets that each belongs to."""

import csv
import gzip
import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

from sparsurf.errors import InputError

HOME = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Structure:
    """A row of structures.csv.

    Attributes
    ----------
    name : str
    file : path relative to the folder of structures or to the repository
    url : where it is downloaded from; empty if it is not published as a file of its own
    sha256 : checksum of what the URL returns; of the uncompressed content where only `file` is compressed
    sets : names of the studies that the structure takes part in
    """

    name: str
    file: str
    url: str
    sha256: str
    sets: tuple[str, ...]


def read_structures(path: str | Path) -> dict[str, Structure]:
    """Read the table of structures, by name."""
    with open(HOME / path, encoding="utf-8", newline="") as stream:
        rows = [row | {"sets": tuple(row["sets"].split())} for row in csv.DictReader(stream)]
    return {row["name"]: Structure(**row) for row in rows}


def names_in_set(structures: dict[str, Structure], name: str) -> list[str]:
    """Return the names of the structures of a set, in the order of the table."""
    return [structure.name for structure in structures.values() if name in structure.sets]


def downloads(structures: dict[str, Structure]) -> dict[str, Structure]:
    """Return structures that can be downloaded, by the name of their file."""
    return {os.path.basename(s.url): s for s in structures.values() if s.url}


def local_file(structure: Structure, folder: str | None) -> str | None:
    """Return the path of a structure in the repository or in `folder`; None if it is in neither.

    Raises
    ------
    InputError : the file is not the structure that was measured
    """
    for path in (HOME / structure.file, Path(folder or HOME) / structure.file):
        if path.is_file():
            if structure.sha256 not in _checksums(path):
                raise InputError(f"{path} differs from the structure in evidence/structures.csv: replace it.")
            return str(path)
    return None


def _checksums(path: Path) -> set[str]:
    """Return SHA-256 of a file and, of a compressed file, of its content."""
    contents = [path.read_bytes()]
    if path.suffix == ".gz":
        contents.append(gzip.decompress(contents[0]))
    return {hashlib.sha256(content).hexdigest() for content in contents}


def protein_entry(structure: Structure, folder: str | None, **options: str | int) -> dict:
    """Return the entry of a structure in the section `proteins` of a study's config."""
    path = local_file(structure, folder)
    source = {"structure": path} if path else {"url": structure.url, "sha256": structure.sha256}
    return source | options


def complexes(structures: dict[str, Structure]) -> dict[str, tuple[str, str]]:
    """Return the complexes of the set `bound` and their two partners."""
    names = [name.removesuffix("_r") for name in names_in_set(structures, "bound") if name.endswith("_r")]
    return {name: (f"{name}_r", f"{name}_l") for name in names}
