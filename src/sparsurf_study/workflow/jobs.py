"""The frame of a job: its log, and its error as one sentence."""

from __future__ import annotations

import errno
import fcntl
import logging
import os
import resource
import signal
import sys
import time
import traceback
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from functools import partial
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from sparsurf import progress
from sparsurf.errors import InputError
from sparsurf.garbage_collection import collect_rarely
from sparsurf.messages import listening
from sparsurf_study.settings import StudySettings, name_in_config
from sparsurf_study.workflow.job_logs import COMPILING, ERROR_MARK, PROGRESS, SHOWN, STOPPED, USED_MARK
from sparsurf_study.workflow.signals import on_stop

if TYPE_CHECKING:
    from sparsurf.evaluation.prepared_surface import PreparedSurface
    from sparsurf.streams import Streams

# A full disk, a folder that may not be written
DISK_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EACCES, errno.EROFS)
RAISE = "raises_errors"  # attribute of the object `snakemake` that sparsurf_study.debug hands to a script
SECONDS_BETWEEN_REPORTS = 2.0  # A long step reports to the log so often.

collect_rarely()  # here: a script imports this module first, and then numba, pandas and others


class Job:
    """What a script reads and writes: `input`, `output`, `params`, `wildcards` and `threads` of Snakemake."""

    def __init__(self, snakemake: Any) -> None:
        self.snakemake = snakemake

    def __getattr__(self, name: str) -> Any:
        return getattr(self.snakemake, name)

    @property
    def settings(self) -> StudySettings:
        """The sections of the config among the params."""
        return StudySettings.of(self.params)

    @property
    def run(self) -> Path:
        """The folder of the run, where the logs of its jobs lie in logs/."""
        log = Path(self.snakemake.log[0])
        return next(folder.parent for folder in log.parents if folder.name == "logs")

    @property
    def place(self) -> str:
        """Name of a conformation: protein/conformation."""
        return f"{self.wildcards.protein}/{self.wildcards.conformation}"

    def streams(self, name: str | None = None, *, shared: bool = False) -> Streams:
        """Return the random streams of the conformation, or of another place."""
        from sparsurf.streams import Streams  # here, as it imports numpy

        return Streams(self.params.seed, self.place if name is None else name, shared)

    def prepared(self, streams: Streams) -> PreparedSurface:
        """Return the surface of the inputs `surface` and `roughness`, prepared for evaluations."""
        from sparsurf_study.analysis.tables import read_prepared

        return read_prepared(
            self.input.surface, self.input.roughness, self.settings, streams, self.snakemake.threads
        )


@contextmanager
def job(snakemake: Any) -> Iterator[Job]:
    """Run a script: its output goes to the log of the rule, and an error ends it with one sentence (traceback in the log)."""
    on_stop(signal.default_int_handler)  # so that it removes its temporary folders
    try:
        # by lines, so that a reader of the log follows a running job
        log = open(snakemake.log[0], "w", encoding="utf-8", buffering=1)  # noqa: SIM115, closed below
    except OSError as error:
        sys.exit(f"\n  {_sentence(error, snakemake)}\n")
    with alone(snakemake.log[0]), closed_at_last(log), redirect_stdout(log), redirect_stderr(log):
        handler = logging.StreamHandler(log)
        handler.setFormatter(logging.Formatter("%(levelname)s %(message)s"))
        logging.captureWarnings(True)
        progress.before_compiling = partial(print, COMPILING, file=log)
        try:
            with listening(handler.handle, logging.INFO, log=logging.getLogger()):
                yield Job(snakemake)
            print(f"{USED_MARK}{used()}", file=log)
        except (KeyboardInterrupt, Exception) as error:
            sentence = _sentence(error, snakemake)
            with suppress(OSError):  # the log may lie on the same full disk
                print(f"{ERROR_MARK}{sentence}", file=log)
            if getattr(snakemake, RAISE, False):
                raise
            if (
                sentence == STOPPED
            ):  # what was interrupted while it was made cannot be taken apart, and would say so
                sys.unraisablehook = lambda _: None
            elif SHOWN not in os.environ:
                print(f"\n  {sentence}\n", file=sys.__stderr__, flush=True)
            sys.exit(1)
        finally:
            logging.captureWarnings(False)
            progress.before_compiling = None


@contextmanager
def closed_at_last(log: IO[str]) -> Iterator[None]:
    """Close a log, also on a full disk, where the rest of it is lost and the error of the job counts."""
    try:
        yield
    finally:
        with suppress(OSError):
            log.close()


@contextmanager
def alone(log: str) -> Iterator[IO[bytes]]:
    """Wait for an earlier process of the same job: where Snakemake is killed, its jobs write on beside those of the next run."""
    with open(Path(log).parent / ".jobs", "ab") as lock:
        with suppress(OSError):  # a file system without locks
            fcntl.lockf(lock, fcntl.LOCK_EX, 1, zlib.crc32(log.encode()))  # a byte for each job of the folder
        yield lock


def let_jobs_import_packages(is_clone: bool) -> None:
    """Put the packages of a clone first on the import path of the processes that Snakemake starts.

    Jobs of a deployed workflow import what is installed in their own environment, which conda may have made.
    """
    from sparsurf.threads import ignore_numba_threads

    ignore_numba_threads()
    if is_clone:
        paths = [str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH")]
        os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, paths))


def _sentence(error: BaseException, snakemake: Any) -> str:
    """Return the message of an error for the user."""
    if KeyboardInterrupt in (type(error), type(error.__cause__)):  # numba makes it the cause of its own
        return STOPPED
    if isinstance(error, InputError):
        if error.__cause__ is not None:  # such as the error of a function of a package
            traceback.print_exc()
        return error.worded(name_in_config)
    if isinstance(error, OSError) and error.errno in DISK_ERRORS:
        place = error.filename or f"the outputs of {snakemake.rule}"
        return f"{place}: {os.strerror(error.errno)}. Free or repair the disk and run again: finished results stay."
    traceback.print_exc()
    kind = f"{type(error).__name__}: {error}"
    return (
        f"A defect of this program ({kind}). Please report it with {snakemake.log[0]}; finished results stay."
    )


def used() -> str:
    """Return the memory and CPU time of this process and those that it started."""
    usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    bytes_per_unit = 1 if sys.platform == "darwin" else 1024
    megabytes = sum(usage.ru_maxrss for usage in usages) * bytes_per_unit / 1e6
    seconds = sum(usage.ru_utime + usage.ru_stime for usage in usages)
    return f"{megabytes:.0f} MB {seconds:.1f} s"


def reporter(title: str, unit: str = "subsets") -> progress.Report:
    """Return a callback (done, total) that writes the progress of a long step to the log, every few seconds."""
    begin = last = time.monotonic()

    def report(done: int, total: int) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= SECONDS_BETWEEN_REPORTS or done >= total:
            last = now
            print(f"{PROGRESS}{title}: {done} of {total} {unit}, {now - begin:.0f} s", file=sys.stderr)

    return report
