"""Signals that stop a study from outside: SIGTERM, and SIGHUP of a terminal that was closed."""

import signal
from collections.abc import Callable
from types import FrameType
from typing import Any


def on_stop(handler: Callable[[int, FrameType | None], Any]) -> None:
    """Let a handler hear that this process is to stop; under `nohup`, it goes on without its terminal."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, handler)
