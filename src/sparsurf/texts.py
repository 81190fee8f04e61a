"""Files that a user gives, packed or not, in memory: within a limit, so that no file fills it."""

import codecs
import gzip
import logging
import os
import stat
import zlib
from contextlib import contextmanager
from pathlib import Path

from sparsurf import InputError

MOST_BYTES = 2**30  # unpacked; the largest structures of the PDB have half of it
LONGEST = 200  # characters of a text that a message quotes whole


def short(text):
    """A text as a message quotes it: cut in the middle where it is longer than LONGEST characters."""
    text = str(text)
    return text if len(text) <= LONGEST else f"{text[:100]}...{text[-60:]} ({len(text)} characters)"


def counted(number, noun):
    """'1 residue', '2 residues'."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def as_path(given):
    """A Path of a string or a path; raises InputError for anything else."""
    if not isinstance(given, str | os.PathLike):
        raise InputError(f"a path is a string or a Path, not {type(given).__name__}: name the file.")
    if not os.fspath(given):
        raise InputError("a path is empty: name the file.")
    return Path(given)


def as_file(given):
    """A Path of what can be read to its end; InputError for a folder, a pipe, a device, and where nothing is."""
    path = as_path(given)
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        raise InputError(f"{short(path)} does not exist: check the path.") from None
    except (OSError, ValueError) as error:  # a name with a byte of zero is a ValueError
        raise _unreadable(path, error) from None
    if stat.S_ISDIR(mode):
        raise InputError(
            f"{short(path)} is a folder: give one file, or let a study take all, `proteins: {{folder: {short(path)}}}`."
        )
    if not stat.S_ISREG(mode):
        raise InputError(
            f"{short(path)} is a pipe or a device: store what it gives in a file, and give that."
        )
    return path


def _unreadable(path, error):
    return InputError(f"{short(path)} cannot be read: {getattr(error, 'strerror', None) or error}.")


def read_bytes(path):
    """Bytes of a file, unpacked if its name ends in .gz."""
    path = as_file(path)
    name = short(path)
    try:
        with gzip.open(path) if path.suffix.lower() == ".gz" else path.open("rb") as stream:
            content = stream.read(MOST_BYTES + 1)
    except gzip.BadGzipFile as error:
        if "Not a gzipped file" in str(error) and not _begins_as_gzip(path):
            raise InputError(f"{name} is named .gz but is not gzip: rename or compress it.") from None
        raise InputError(f"{name} is damaged inside its gzip: copy it again.") from None
    except (EOFError, zlib.error):
        raise InputError(f"{name} is cut short or damaged inside its gzip: copy it again.") from None
    except OSError as error:
        raise _unreadable(path, error) from None
    if len(content) > MOST_BYTES:
        raise InputError(f"{name} holds more than {MOST_BYTES // 2**20} MB (unpacked): give a smaller file.")
    return content


def _begins_as_gzip(path):
    with path.open("rb") as stream:
        return stream.read(2) == b"\x1f\x8b"


def text_of(content, path):
    """Text of the bytes of a file: UTF-8 with or without a byte-order mark, or else Latin-1; lines end in '\\n'; `path` is
    named in messages."""
    if content.startswith(b"\x1f\x8b"):
        raise InputError(
            f"{path} holds a gzip file within: unpack it, and name it .gz if it stays packed once."
        )
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise InputError(f"{path} is stored as UTF-16: store it as UTF-8.")
    if b"\0" in content:
        raise InputError(f"{path} is damaged or no text file: it contains bytes of zero; copy it again.")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.removeprefix(codecs.BOM_UTF8).decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_text(path):
    """Text of a file, see `read_bytes` and `text_of`."""
    return text_of(read_bytes(path), path)


@contextmanager
def said_before():
    """Warn of nothing: of what a study wrote itself, it was said of the file that it came from."""
    log = logging.getLogger("sparsurf")
    before, log.disabled = log.disabled, True
    try:
        yield
    finally:
        log.disabled = before
