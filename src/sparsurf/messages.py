"""The log of the library: its messages, free of control characters, and where they are printed."""

from __future__ import annotations

import logging
import re
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

from sparsurf.errors import InputError

LOG = logging.getLogger("sparsurf")


def _make_printable(record: logging.LogRecord) -> bool:
    """Replace the control characters of a message by escape codes; a filter of the log of the package.

    Its attribute `sentence` names its arguments as an `InputError` does, and its message by the names of a call.
    """
    sentence = InputError(record.getMessage())
    vars(record).update(template=str(record.msg), sentence=sentence, msg=str(sentence), args=())
    return True


def escape_control_characters() -> None:
    """Let no message of the library reach a terminal with control characters, such as those in the name of a file."""
    LOG.addFilter(_make_printable)


@contextmanager
def listening(
    hear: Callable[[logging.LogRecord], object],
    level: int = logging.WARNING,
    *,
    log: logging.Logger = LOG,
    pass_on: bool = False,
) -> Iterator[None]:
    """Let one function hear the messages from a level on, and nobody else; `pass_on` shows them to others as without it."""
    shown = log.getEffectiveLevel()
    unchanged = logging.Logger(log.name)  # the handlers of now, which Python finds by way of a logger
    unchanged.handlers, unchanged.propagate, unchanged.parent = log.handlers, log.propagate, log.parent

    class Listener(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            hear(record)
            if pass_on and record.levelno >= shown:
                unchanged.callHandlers(record)

    own_level = log.level
    log.handlers, log.propagate = [Listener()], False
    log.setLevel(min(shown, level) if pass_on else level)
    try:
        yield
    finally:
        log.handlers, log.propagate = unchanged.handlers, unchanged.propagate
        log.setLevel(own_level)


def no_warnings() -> AbstractContextManager[None]:
    """Silence the log of the package, for files that a study wrote: it has warned about what they came from."""
    return listening(lambda record: None)


def kind_of_warning(record: logging.LogRecord) -> str:
    """Return what warnings of one kind have in common: the template, or the plain words of a sentence that it holds whole."""
    template = str(getattr(record, "template", record.msg))
    if template != "%s: %s":
        return template
    return " ".join(re.findall(r"\b[a-z]+\b", record.getMessage().rpartition(": ")[2]))
