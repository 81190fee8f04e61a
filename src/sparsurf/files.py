"""Read files that a user gives, compressed or not, up to a size that fits into memory."""

from __future__ import annotations

import bz2
import codecs
import gzip
import hashlib
import importlib
import io
import lzma
import os
import re
import stat
import sys
import zlib
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from sparsurf.errors import FILE, InputError, naming_file
from sparsurf.messages import escape_control_characters

if TYPE_CHECKING:
    import numpy as np

StrPath: TypeAlias = str | os.PathLike[str]

MAX_UNPACKED_BYTES = 2**30  # uncompressed; the largest structures of the PDB have half of it
# How compressed files begin, and the suffix and the module of the compressions that are read
PACKINGS: dict[bytes, tuple[str, Any]] = {
    b"\x1f\x8b": (".gz", gzip), b"BZh": (".bz2", bz2), b"\xfd7zXZ\0": (".xz", lzma),
}  # fmt: skip
PACKED_SUFFIXES = tuple(suffix for suffix, _ in PACKINGS.values())
OTHER_PACKINGS = {b"\x28\xb5\x2f\xfd": "zstd", b"PK\x03\x04": "zip"}
DAMAGED = (EOFError, zlib.error, lzma.LZMAError, gzip.BadGzipFile)  # what modules of compressions raise
LENGTH_OF_BEGIN = 200
MAX_QUOTED_LENGTH = 200  # characters; a message shortens a longer string
N_ROWS_TO_COMPARE = 10  # The rows at the end of a table show whether its last row is complete.
ID_OF_PDB = re.compile(r"[1-9][A-Za-z0-9]{3}")
URL_OF_PDB = "https://files.rcsb.org/download/{}.cif.gz"
URL_START = re.compile(r"[a-z][a-z0-9+]+:/", re.IGNORECASE)  # a Path drops one of its slashes
UNPACK = "unpack an archive first, and give the path of the unpacked file."

escape_control_characters()

closed_streams: set[str] = set()  # the standard streams that were closed when the program began


def open_closed_streams() -> None:
    """Let a standard stream that is closed lead nowhere, here and in the processes to come; a file would take its number."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            closed_streams.add(name)
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # the lowest free number
            setattr(sys, name, open(number, "w" if number else "r", closefd=False))  # noqa: SIM115


def shorten(text: object) -> str:
    """Return a string for a message: cut in the middle if it is longer than MAX_QUOTED_LENGTH."""
    text = str(text)
    if len(text) <= MAX_QUOTED_LENGTH:
        return text
    return f"{text[:100]}...{text[-60:]} ({len(text)} characters)"


def ends_in(path: object, suffixes: str | tuple[str, ...]) -> bool:
    """Return whether a name ends in one of some suffixes, in any case, with or without .gz."""
    return str(path).lower().removesuffix(".gz").endswith(suffixes)


def pluralise(number: int, noun: str, verb: str = "", separator: str = "") -> str:
    """Return a number with its noun, and a verb: '1 residue lacks', '2 residues lack'; a separator parts thousands."""
    counted = f"{number:{separator}} {noun}{'' if number == 1 else 's'}"
    several = {"is": "are", "has": "have", "": ""}.get(verb) or verb.removesuffix("s")
    return f"{counted} {verb if number == 1 else several}".rstrip()


def checksum_of_file(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file."""
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def as_path(path: str | os.PathLike[str]) -> Path:
    """Return a Path of a string or a path; raise InputError for anything else."""
    if isinstance(path, Path):
        return path
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"a path is a string or a Path, not {type(path).__name__}: name the file.")
    if not os.fspath(path):
        raise InputError("a path is empty: name the file.")
    return Path(path)


def existing_file(path: str | os.PathLike[str]) -> Path:
    """Return the Path of a regular file; raise InputError for a folder, a pipe, a device, or if nothing is there."""
    given, path = path, as_path(path)
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        raise _absent(given) from None
    except NotADirectoryError:
        raise InputError(f"{shorten(path)} leads into a file: {UNPACK}") from None
    except (OSError, ValueError) as error:  # a null byte in the name is a ValueError
        if "\n" in str(path):
            raise _absent(given) from None
        raise _unreadable(path, error) from None
    if stat.S_ISDIR(mode):
        raise InputError(
            f"{shorten(path)} is a folder: give one file, or let a study take all its files, "
            f"`proteins: {{folder: {shorten(path)}}}`."
        )
    if not stat.S_ISREG(mode):
        raise InputError(
            f"{shorten(path)} is a pipe or a device: store its content in a file, and give that file."
        )
    return path


def _absent(path: str | os.PathLike[str]) -> InputError:
    """Return the InputError for a path where nothing is: a URL, the text of a file, or a wrong path."""
    text = os.fspath(path)
    if URL_START.match(text):
        return InputError(f"{shorten(text)} is a URL: give a file; nothing is downloaded.")
    if "\n" in text.strip():
        first = shorten(text.strip().partition("\n")[0])
        return InputError(
            f"the text of a file stands in place of its path, {first!r}: store it in a file, and give its path."
        )
    if ID_OF_PDB.fullmatch(text):
        return InputError(
            f"{text} does not exist. If it is an entry of the PDB, download {URL_OF_PDB.format(text.upper())} and give that file;"
            f" a study downloads it by its key `pdb: {text}`."
        )
    return InputError(f"{shorten(text)} does not exist: check the path.")


def _unreadable(path: Path, error: OSError | ValueError) -> InputError:
    """Return the InputError for a path that the operating system refuses."""
    return InputError(f"{shorten(path)} cannot be read: {getattr(error, 'strerror', None) or error}.")


def packing_of(begin: bytes) -> tuple[str, Any]:
    """Return the suffix and the module of the compression of a file that begins so; an empty suffix and None without one."""
    found = (packing for magic, packing in PACKINGS.items() if begin.startswith(magic))
    return next((packing for packing in found if packing[0] != ".bz2" or begin[4:6] == b"1A"), ("", None))


def refuse_packed(path: object, begin: bytes) -> None:
    """Raise InputError for a file that begins as one of a compression that is not read; an npz is a zip file of arrays."""
    kind = next((kind for magic, kind in OTHER_PACKINGS.items() if begin.startswith(magic)), None)
    if kind and b".npy" not in begin[:LENGTH_OF_BEGIN]:
        raise InputError(
            f"{path} is compressed with {kind}, which is not read; unpack it, and give the unpacked file."
        )


def beginning(path: StrPath, size: int) -> bytes:
    """Return the first bytes of the content of a file, uncompressed; those that are there of a damaged one."""
    with open(path, "rb") as stored:
        begin = stored.read(size)
    module = packing_of(begin)[1]
    if module is None:
        return begin
    out = b""
    with suppress(*DAMAGED, OSError), module.open(path) as stream:
        while len(out) < size and (piece := stream.read1(size - len(out))):
            out += piece
    return out


def read_bytes(path: str | os.PathLike[str]) -> bytes:
    """Return the bytes of a file of at most MAX_UNPACKED_BYTES, uncompressed if its name ends in .gz, .bz2 or .xz."""
    return content_of(existing_file(path))


def content_of(path: Path) -> bytes:
    """Return the bytes of a file that exists as `read_bytes` does."""
    begin, name = b"", str(path) if len(str(path)) <= MAX_QUOTED_LENGTH else shorten(path)
    try:
        with path.open("rb") as stored:
            begin = stored.read(LENGTH_OF_BEGIN)
            stored.seek(0)
            refuse_packed(name, begin)
            ending, module = packing_of(begin)
            is_named = path.suffix.lower() in PACKED_SUFFIXES
            if is_named and path.suffix.lower() != ending:
                kind = path.suffix.lower()
                raise InputError(f"{name} is named {kind} but is not compressed so: rename or compress it.")
            with module.open(stored) if is_named else stored as stream:
                content = stream.read(MAX_UNPACKED_BYTES + 1)
    except DAMAGED:
        raise InputError(f"{name} is cut short or damaged inside its compression: copy it again.") from None
    except OSError as error:
        if is_named and error.errno is None:  # of bz2
            raise InputError(f"{name} is damaged inside its compression: copy it again.") from None
        raise _unreadable(path, error) from None
    if len(content) > MAX_UNPACKED_BYTES:
        raise InputError(
            f"{name} holds more than {MAX_UNPACKED_BYTES // 2**20} MB (uncompressed): give a smaller file."
        )
    if is_named and packing_of(content)[1]:
        raise InputError(
            f"{name} is compressed twice: uncompress it, and name it {packing_of(content)[0]} if it is still compressed then."
        )
    return content


def decode_text(content: bytes) -> str:
    """Decode a text file, UTF-8 with or without a byte-order mark, else Latin-1; every line ends in a line feed."""
    if packing := packing_of(content)[0]:
        raise InputError(f"{FILE} is compressed: add {packing} to its name, or uncompress it.")
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise InputError(f"{FILE} is stored as UTF-16: store it as UTF-8.")
    if b"\0" in content:
        raise InputError(f"{FILE} is damaged or not a text file: it contains null bytes; copy it again.")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.removeprefix(codecs.BOM_UTF8).decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_text(path: str | os.PathLike[str]) -> str:
    """Return the text of a file, see `read_bytes` and `decode_text`."""
    with naming_file(path):
        return decode_text(read_bytes(path))


def ends_within_a_row(text: str, split: Callable[[str], Sequence[str]] = str.split) -> bool:
    """Return whether the end of a text cuts the last row of its table, as where a copy was interrupted.

    The row has no line feed and, unlike those before, which agree, fewer words, an empty last word, or fewer decimals in it.
    """
    text = text.rstrip(" \t")
    rows = [split(line) for line in text.rsplit("\n", N_ROWS_TO_COMPARE)[1:]]
    if text.endswith("\n") or len(rows) < N_ROWS_TO_COMPARE or not all(rows):
        return False
    *before, last = rows
    lengths, ends = {len(row) for row in before}, [row[-1] for row in before]
    decimals = {len(end.partition(".")[2]) for end in ends}
    return (
        (len(lengths) == 1 and len(last) < lengths.pop())
        or (all(ends) and not last[-1])
        or (len(decimals) == 1 and len(last[-1].partition(".")[2]) < decimals.pop())
    )


def read_archive(content: bytes, problem: str) -> dict[str, np.ndarray]:
    """Read all arrays of an npz by name; `problem` follows the name of a file that is damaged or something else."""
    import numpy as np  # here: a config is read without it

    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as archive:
            if sum(member.file_size for member in archive.zip.infolist()) > MAX_UNPACKED_BYTES:
                raise InputError(
                    f"{FILE} unpacks to more than {MAX_UNPACKED_BYTES // 2**20} MB: give a smaller file."
                )
            arrays = {name: archive[name] for name in archive.files}
    except InputError:
        raise
    except Exception:  # zipfile and numpy answer damaged bytes with nearly every exception
        raise InputError(f"{FILE} {problem}.") from None
    if not all(isinstance(array, np.ndarray) for array in arrays.values()):
        raise InputError(f"{FILE} {problem}.")
    return arrays


def import_pyarrow() -> Any:
    """Return pyarrow with its module `parquet`, or say that it is not installed."""
    try:
        importlib.import_module("pyarrow.parquet")
        return importlib.import_module("pyarrow")
    except ImportError:
        raise InputError("Parquet files need pyarrow: run pip install pyarrow.") from None
