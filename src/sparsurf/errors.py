"""InputError, the error for every mistake of a user, and the argument or the file that its message names."""

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

ARGUMENT_NAME = re.compile(r"[A-Za-z_][\w.]*")  # The name of an argument, or of a key.
# The name of an argument within a message; neither character occurs in a file of text
MARKED = re.compile("\x02([\\w.]+)\x03")

_name_of_file: ContextVar[str] = ContextVar("name_of_file", default="the file")


class _File:
    """The file that is read at the moment; as a string, its name."""

    def __str__(self) -> str:
        return _name_of_file.get()


# Stands for the name of the file in the messages of readers, of errors and of warnings: f"{FILE} holds no atoms."
FILE = _File()


@contextmanager
def naming_file(name: object) -> Iterator[None]:
    """Let FILE be the name of a file, or of what a user gives in its place, in the messages of what reads it.

    Whatever opens a file names it here, so that readers need not be told its name. It is not for the body of a generator,
    which would leave the name to its caller between two items.
    """
    before = _name_of_file.set(str(name))
    try:
        yield
    finally:
        _name_of_file.reset(before)


class InputError(ValueError):
    """Raised when an input is wrong; the message says what is wrong, where, and what to do.

    Functions, commands and studies raise the same errors, but the user knows an argument by another name in each of them:
    `d_link` in a call, `--d-link` in a command line, `patches.d_link` in a config. A message names its arguments by
    `argument`. As a string, it has the names of a call; commands and studies call `worded`.

    Parameters
    ----------
    message : object, the message; control characters are escaped
    """

    def __init__(self, message: object = "") -> None:
        pieces = MARKED.split(str(message))  # text, name, text, name, ..., text
        super().__init__(
            "".join(argument(piece) if k % 2 else printable(piece) for k, piece in enumerate(pieces))
        )

    def __str__(self) -> str:
        """Return the message with the names that the arguments have in a call."""
        return self.worded(name_in_call)

    @property
    def arguments(self) -> tuple[str, ...]:
        """The arguments that the message names, in its order."""
        return tuple(MARKED.findall(self.args[0]))

    def worded(self, name: Callable[[str], str]) -> str:
        """Return the message with `name(argument)` for each of its arguments."""
        return MARKED.sub(lambda match: name(match[1]), self.args[0])


def argument(name: str) -> str:
    """Return the name of an argument for the message of an `InputError`, such as d_link.

    The key of a config, such as minimal.density, may stand for an argument whose name occurs in several sections. Part of an
    argument, such as "combination: alpha", is called the same everywhere and returned as it is.
    """
    return f"\x02{name}\x03" if ARGUMENT_NAME.fullmatch(name) else name


def name_in_call(argument: str) -> str:
    """Return what an argument is called in Python: the last part of a key."""
    return argument.rpartition(".")[2]


def printable(message: object) -> str:
    """Return a message in which escape codes stand for control characters, which a file may hold to change a terminal."""
    return "".join(
        letter if letter.isprintable() or letter == "\n" else repr(letter)[1:-1] for letter in str(message)
    )
