"""Files that a user gives, packed or not, in memory: within a limit, so that no file fills it."""

import codecs
import gzip
import os
import zlib
from pathlib import Path

from sparsurf import InputError

MOST_BYTES = 2**30  # unpacked; the largest structures of the PDB have half of it


def as_path(given):
    """A Path of a text or a path; raises InputError for anything else."""
    if not isinstance(given, str | os.PathLike):
        raise InputError(
            f"a path is a text or a Path, not of the type {type(given).__name__}: name the file."
        )
    return Path(given)


def read_bytes(path):
    """Bytes of a file, unpacked if its name ends in .gz."""
    path = as_path(path)
    try:
        with gzip.open(path) if path.suffix.lower() == ".gz" else path.open("rb") as stream:
            content = stream.read(MOST_BYTES + 1)
    except FileNotFoundError:
        raise InputError(f"{path} does not exist: check the path.") from None
    except gzip.BadGzipFile:
        raise InputError(f"{path} is named .gz but is not gzip: rename or compress it.") from None
    except (EOFError, zlib.error):
        raise InputError(f"{path} is cut short or damaged inside its gzip: copy it again.") from None
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}.") from None
    if len(content) > MOST_BYTES:
        raise InputError(f"{path} holds more than {MOST_BYTES // 2**20} MB (unpacked): give a smaller file.")
    return content


def text_of(content, path):
    """Text of the bytes of a file: Latin-1 without a byte-order mark, lines end in '\\n'; `path` is named in messages."""
    if b"\0" in content:
        raise InputError(f"{path} is damaged or no text file: it contains bytes of zero; copy it again.")
    return content.removeprefix(codecs.BOM_UTF8).decode("latin-1").replace("\r\n", "\n").replace("\r", "\n")


def read_text(path):
    """Text of a file, see `read_bytes` and `text_of`."""
    return text_of(read_bytes(path), path)
