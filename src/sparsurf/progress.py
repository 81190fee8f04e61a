"""What a user sees of work that takes long: progress in a terminal or a log, and a word before kernels are compiled."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeAlias, TypeVar

DELAY = 2.0  # s; a shorter loop shows no bar
SECONDS_PER_LINE = 30.0  # A log, which shows no bar, gets a line so often.
Item = TypeVar("Item")
Report: TypeAlias = Callable[[int, int], None]  # what a loop calls with how much is done, and of how much
# The functions of `sparsurf` turn the bars on, unless the command line has decided. The jobs of a study share a terminal and
# leave them as they are, which is off.
enabled: bool | None = None
before_compiling: Callable[[], None] | None = None  # called before each kernel that is not stored
stage = ""  # what a command does now, and how far it is, for the lines of a log


def unreported(done: int, total: int) -> None:
    """Say nothing of how much is done."""


class Progress:
    """How much of a loop is done: a bar on a terminal or in a notebook, and in a log what its next line tells."""

    def __init__(self, description: str, total: int | None = None, done: int = 0) -> None:
        """Begin a loop over `total` items, of which some may be done before."""
        self.description, self.total, self.done = description, total, done
        self._first, self._start, self._bar = done, time.monotonic(), None
        self._stage_before = stage
        if enabled and ("ipykernel" in sys.modules or sys.stderr.isatty()):
            from tqdm import tqdm  # only where a bar is shown

            self._bar = tqdm(desc=description, total=total, initial=done, leave=False, delay=DELAY)
        self._tell()

    def advance(self, n: int = 1) -> None:
        """Count n more items."""
        self.done += n
        if self._bar is not None:
            self._bar.update(n)
        self._tell()

    def close(self) -> None:
        """Remove the bar, and tell again what is done around the loop."""
        global stage
        stage = self._stage_before
        if self._bar is not None:
            self._bar.close()

    def _tell(self) -> None:
        """Set what a log tells of the loop."""
        global stage
        stage = f"{self.done:,} {self.description}"
        if self.total is not None:
            stage = f"{self.done:,} of {self.total:,} {self.description}"
            if self.done > self._first:
                seconds = time.monotonic() - self._start
                left = seconds * (self.total - self.done) / (self.done - self._first)
                stage += f", about {duration(left)} left"


def progress_bar(items: Sequence[Item], description: str) -> Iterator[Item]:
    """Iterate over items and show how many are done; see `Progress`."""
    shown = Progress(description, len(items))
    try:
        for item in items:
            yield item
            shown.advance()
    finally:
        shown.close()


@contextmanager
def hidden() -> Iterator[None]:
    """Show no bars of what is one item of a loop."""
    global enabled
    shown, enabled = enabled, False
    try:
        yield
    finally:
        enabled = shown


def tell(text: str) -> None:
    """Set what a log tells from now on."""
    global stage
    stage = text


def duration(seconds: float) -> str:
    """Return a time in words: '40 s', '5 min', '2.5 h'."""
    if seconds < 60:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


@contextmanager
def lines_in_log(command: str) -> Iterator[None]:
    """Print every half minute what a command does and how far it is, where no terminal shows it."""
    if not enabled or sys.stderr.isatty():
        yield
        return
    ended, start = threading.Event(), time.monotonic()

    def tell() -> None:
        while not ended.wait(SECONDS_PER_LINE):
            state = stage or "working"
            print(
                f"sparsurf {command}: {state} (after {duration(time.monotonic() - start)})",
                file=sys.stderr,
                flush=True,
            )

    thread = threading.Thread(target=tell, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
