"""Snakemake as another process: one study at a time per checkout, signals passed on, its error output kept in a file."""

import fcntl
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from sparsurf import InputError


@contextmanager
def locked(root: Path) -> Iterator[None]:
    """Hold the lock of a checkout.

    It is the operating system's, so that a killed run leaves nothing to unlock; Snakemake inherits it and may outlive this
    process.
    """
    path = root / ".snakemake" / "study.lock"
    try:
        path.parent.mkdir(exist_ok=True)
        lock = path.open("w", encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"{path.parent} cannot be written ({error.strerror}): a study needs its folder."
        ) from None
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError("Another study runs in this folder; wait for it to end.") from None
        os.set_inheritable(lock.fileno(), True)
        yield


def run_snakemake(
    root: Path,
    configs: Sequence[Path],
    *options: str,
    errors: Path | None = None,
    begun: Callable[[subprocess.Popen], None] | None = None,
) -> int:
    """Run Snakemake in a checkout and return its exit code.

    The terminal sends Ctrl-C to it directly, and SIGTERM is passed on. Both wait until it has ended its jobs.

    Parameters
    ----------
    root : path of the checkout
    configs : config files, a later one before an earlier
    options : Snakemake's
    errors : file for what processes write to standard error, such as tracebacks of jobs that are stopped
    begun : called with the process once it runs
    """
    where = ["--snakefile", str(root / "Snakefile"), "--directory", str(root), "--nolock"]
    command = [sys.executable, "-m", "snakemake", *where, "--configfile", *map(str, configs), *options]
    received: list[int] = []

    def pass_on(number: int, _: FrameType | None) -> None:
        received.append(number)
        if number == signal.SIGTERM:
            process.terminate()

    with open(errors or os.devnull, "a", encoding="utf-8") as stream:
        process = subprocess.Popen(command, close_fds=False, stderr=stream if errors else None)
        handlers = {number: signal.signal(number, pass_on) for number in (signal.SIGINT, signal.SIGTERM)}
        if begun:
            begun(process)
        code = process.wait()
    for number, handler in handlers.items():
        signal.signal(number, handler)
    if received and code:
        raise KeyboardInterrupt(received[0])
    return code
