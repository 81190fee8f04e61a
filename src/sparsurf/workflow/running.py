"""Snakemake as another process: one study at a time per checkout, signals passed on, what it says kept apart."""

import fcntl
import os
import re
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

from sparsurf import InputError


def plans_only(options):
    """Whether Snakemake is asked for nothing but a plan or its help, by any of the names that it knows for that."""
    return any(
        option in ("--dry-run", "--dryrun", "--help") or re.fullmatch("-[A-Za-z]*[nh][A-Za-z]*", option)
        for option in options
    )


@contextmanager
def locked(root):
    """Hold the lock of a checkout.

    It is the operating system's, so that a killed run leaves nothing to unlock; Snakemake holds it, too, and may outlive this
    process.
    """
    lock = root / ".snakemake" / "study.lock"
    try:
        lock.parent.mkdir(exist_ok=True)
        held = lock.open("w", encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"{lock.parent} cannot be written ({error.strerror}): a study needs its folder."
        ) from None
    with held:
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError("Another study runs in this folder; wait for it to end.") from None
        os.set_inheritable(held.fileno(), True)
        yield


def snakemake(root, configs, *options, errors=None, begun=None):
    """Run Snakemake in a checkout to its end; returns its exit code.

    Ctrl-C reaches it by itself, SIGTERM is passed on; how long it takes to end its jobs is waited for.

    Parameters
    ----------
    root : path of the checkout
    configs : paths of config files, a later one before an earlier
    options : words
    errors : path of the file that takes what processes say beside their logs, such as tracebacks of jobs that are stopped
    begun : function of the process, called once it runs
    """
    command = [
        sys.executable,
        "-m",
        "snakemake",
        "--snakefile",
        root / "Snakefile",
        "--directory",
        root,
        "--nolock",
    ]
    command = [*map(str, [*command, "--configfile", *configs, *options])]
    path = os.pathsep.join(filter(None, [str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH")]))
    asked = []

    def passed_on(number, _):
        asked.append(number)
        if number == signal.SIGTERM:
            process.terminate()

    with open(errors or os.devnull, "a", encoding="utf-8") as said:
        process = subprocess.Popen(
            command, close_fds=False, env=os.environ | {"PYTHONPATH": path}, stderr=said if errors else None
        )
        before = {number: signal.signal(number, passed_on) for number in (signal.SIGINT, signal.SIGTERM)}
        if begun:
            begun(process)
        code = process.wait()
    for number, handler in before.items():
        signal.signal(number, handler)
    if asked and code:
        raise KeyboardInterrupt(asked[0])
    return code
