"""What a surface format is."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Format:
    """A kind of file that holds a surface.

    Attributes
    ----------
    name : what people call it
    suffixes : endings of its files, in lower case; a file may also be packed (.gz)
    sniff : first bytes of a file, unpacked -> whether it is of this format
    read : (bytes of the file, unpacked; path for messages) -> Surface; None for a format that is only written
    write : (path, surface, and what else the format shows); None for a format that is only read
    """

    name: str
    suffixes: tuple
    sniff: Callable
    read: Callable | None = None
    write: Callable | None = None
