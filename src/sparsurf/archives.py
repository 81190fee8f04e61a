"""Structures inside a tar or zip archive, read one by one; nothing is unpacked.

A member has the path of a file in a folder: 'models.tar/AF-P69905.cif.gz'.
"""

from __future__ import annotations

import os
import tarfile
import zipfile
import zlib
from collections import Counter
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from sparsurf import InputError

ARCHIVES = (".tar", ".zip")
COMPRESSED_TARS = (".tar.gz", ".tgz", ".tar.bz2", ".tbz2", ".tar.xz", ".txz", ".tar.zst")
BLOCK = 512  # bytes of a block of a tar archive, which ends in blocks of zeros
KEPT_LISTS = 8  # archives whose lists of members stay in memory


@dataclass(frozen=True)
class Member:
    """A file inside an archive.

    Attributes
    ----------
    stored_name : str, as the archive has it
    size : int, bytes; those of a zip's member uncompressed
    start : int, where its bytes begin in a tar; 0 in a zip
    """

    stored_name: str
    size: int
    start: int = 0


def split_path(path: str | os.PathLike[str]) -> tuple[str, str] | None:
    """Split the path of a member into that of its archive and its name inside; None for any other path."""
    path = Path(path)
    for parent in path.parents:
        if parent.suffix.lower() in ARCHIVES and parent.is_file():
            return str(parent), str(path.relative_to(parent))
    return None


def is_file(path: str | os.PathLike[str]) -> bool:
    """Return whether a path is that of a file, or of a member of an archive."""
    if os.path.isfile(path):
        return True
    found = split_path(path)
    return found is not None and found[1] in members(found[0])


def members(path: str | os.PathLike[str]) -> dict[str, Member]:
    """List the files inside an archive.

    Parameters
    ----------
    path : file whose name ends in .tar or .zip

    Returns
    -------
    dict, Member by name, in the order of the archive; folders, links and devices are left out

    Raises
    ------
    InputError
        No such file, another kind of file, cut short, damaged, encrypted, two members of one name, or names that lead outside.
    """
    name = os.fspath(path)
    if name.lower().endswith(COMPRESSED_TARS):
        raise InputError(
            f"{name} is compressed as a whole, so that single structures cannot be read: uncompress it to a .tar file."
        )
    if not name.lower().endswith(ARCHIVES):
        raise InputError(f"{name} is not an archive: name a .tar or .zip file, or use `folder`.")
    if not os.path.isfile(name):
        raise InputError(f"{name} does not exist: check the path of the archive.")
    return _members(name, os.stat(name).st_mtime_ns)


def read_member(path: str, name: str, limit: int) -> bytes:
    """Read a member of an archive.

    Raises
    ------
    InputError
        There is no such member, it is damaged, or it holds more than `limit` bytes.
    """
    member = members(path).get(name)
    if member is None:
        raise InputError(f"{path} holds no {name}: check the name.")
    if member.size > limit:
        raise InputError(f"{path}/{name} holds more than {limit // 2**20} MB: give a smaller file.")
    try:
        if member.start:
            with open(path, "rb") as stream:
                stream.seek(member.start)
                return stream.read(member.size)
        with _opened_zip(path, os.stat(path).st_mtime_ns).open(member.stored_name) as packed:
            return packed.read(limit)  # the size that a zip announces may be wrong
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError) as error:
        raise InputError(f"{path}/{name} is damaged inside its archive ({error}): copy it again.") from None


@lru_cache(KEPT_LISTS)
def _members(path: str, stamp: int) -> dict[str, Member]:
    """List the members of an archive; `stamp` changes with the file."""
    try:
        stored = _members_of_zip(path, stamp) if path.lower().endswith(".zip") else _members_of_tar(path)
    except InputError:
        raise
    except (zipfile.BadZipFile, tarfile.TarError, EOFError, ValueError) as error:
        raise InputError(f"{path} is cut short, damaged or no archive ({error}): copy it again.") from None
    names = [os.path.normpath(member.stored_name) for member in stored]
    outside = next((name for name in names if name.startswith((os.sep, os.pardir))), None)
    if outside is not None:
        raise InputError(f"{path} holds {outside!r}, which leads outside of the archive: pack it again.")
    name, count = Counter(names).most_common(1)[0] if names else ("", 0)
    if count > 1:
        raise InputError(f"{path} holds {name!r} {count} times: pack it again with one of them.")
    return dict(zip(names, stored, strict=True))


@lru_cache(KEPT_LISTS)
def _opened_zip(path: str, _stamp: int) -> zipfile.ZipFile:
    """Open a zip archive once: each opening reads the list of its members."""
    return zipfile.ZipFile(path)


def _members_of_zip(path: str, stamp: int) -> list[Member]:
    """List the files of a zip archive."""
    infos = _opened_zip(path, stamp).infolist()
    if any(info.flag_bits & 1 for info in infos):
        raise InputError(f"{path} is encrypted: give an archive without a password.")
    return [Member(info.filename, info.file_size) for info in infos if not info.is_dir()]


def _members_of_tar(path: str) -> list[Member]:
    """List the files of a tar archive, which must end as one."""
    with tarfile.open(path, "r:") as archive:
        stored = [
            Member(info.name, info.size, info.offset_data)
            for info in archive
            if info.isreg() and not info.issparse()
        ]
        end = archive.offset
    with open(path, "rb") as stream:
        stream.seek(end)
        if stream.read(BLOCK) != bytes(BLOCK):
            raise EOFError("it lacks its end")
    return stored
