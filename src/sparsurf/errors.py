"""The error of everything that a user gave wrongly."""


class InputError(ValueError):
    """Raised when an input is wrong; the message says what is wrong, where, and what to do."""

    def __init__(self, message: object = "") -> None:
        super().__init__(printable(message))


def printable(message: object) -> str:
    """Return a message in which escape codes stand for control characters, which a file may hold to change a terminal."""
    return "".join(
        letter if letter.isprintable() or letter == "\n" else repr(letter)[1:-1] for letter in str(message)
    )
