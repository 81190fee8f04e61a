"""SIGTERM ends a study at once, and so does a closed terminal.

By itself, Snakemake would wait until the running jobs have finished, for hours, or leave them running without it.
"""

import os
import signal
import sys
import threading
import time
from contextlib import suppress
from types import FrameType
from typing import NoReturn

import psutil

from sparsurf_study.workflow.signals import on_stop

SIGNALLED = threading.Event()  # It is set by SIGTERM, SIGHUP or Ctrl-C.
# A job is killed so long after the signal, which a kernel that computes for minutes does not notice.
SECONDS_TO_KILL = 5.0
SECONDS_TO_END = 12.0  # of Snakemake, which on Slurm sleeps for up to three minutes before it asks again which jobs have ended
NOTICE = "\nStopped. Finished results stay; the same command continues where it was."


def end_jobs_on_sigterm() -> None:
    """Let SIGTERM and SIGHUP end the running jobs, and Snakemake as Ctrl-C does; called when Snakemake has set its handler."""
    on_stop(_stop)
    if (
        signal.getsignal(signal.SIGINT) is signal.default_int_handler
    ):  # a shell lets its background ignore Ctrl-C
        signal.signal(signal.SIGINT, _interrupt)


def _interrupt(number: int, frame: FrameType | None) -> NoReturn:
    """Note Ctrl-C, which no log tells where the running jobs have just finished; a second one ends Snakemake at once."""
    if SIGNALLED.is_set():
        os._exit(128 + number)  # the terminal has sent it to the jobs as well
    SIGNALLED.set()
    signal.default_int_handler(number, frame)


def _stop(_number: int, _: FrameType | None) -> NoReturn:
    on_stop(lambda *_: None)  # Python would print a traceback of a signal that waits and is ignored
    # `scancel`, which Snakemake starts now, inherits this and is not ended.
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
    SIGNALLED.set()
    threading.Thread(target=_end_jobs).start()  # no daemon: this process waits for the last of them
    raise KeyboardInterrupt


def _end_jobs() -> None:
    """End all processes below Snakemake, also those that it starts meanwhile, until it has come to its own end."""
    begin, jobs, signalled = time.monotonic(), set[psutil.Process](), set[psutil.Process]()
    while jobs or threading.main_thread().is_alive():
        seconds = time.monotonic() - begin
        jobs |= {*psutil.Process().children(recursive=True)}  # those found before may have lost their parent
        jobs = {job for job in jobs if _runs(job)}
        for job in jobs if seconds > SECONDS_TO_KILL else jobs - signalled:
            with suppress(psutil.NoSuchProcess):
                job.send_signal(signal.SIGKILL if seconds > SECONDS_TO_KILL else signal.SIGTERM)
        signalled |= jobs
        if seconds > SECONDS_TO_END and not jobs:
            with suppress(OSError):  # of a closed terminal
                print(NOTICE, file=sys.stderr, flush=True)
            os._exit(128 + signal.SIGTERM)
        time.sleep(0.1)


def _runs(job: psutil.Process) -> bool:
    """Return whether a process has not ended; whoever has started it asks for its exit code, and nobody else may."""
    try:
        return job.is_running() and job.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False
