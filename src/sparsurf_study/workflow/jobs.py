"""The frame of a job: its log, its error as one sentence, and how far it is."""

from __future__ import annotations

import errno
import logging
import os
import resource
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sparsurf.errors import InputError
from sparsurf.garbage import collect_rarely
from sparsurf.messages import listening
from sparsurf.threads import ignore_numba_threads
from sparsurf_study.settings import StudySettings, name_in_config
from sparsurf_study.workflow.job_logs import ERROR_MARK, PROGRESS, STOPPED, USED_MARK
from sparsurf_study.workflow.ledger import Entry
from sparsurf_study.workflow.staging import Staging, with_final_names

if TYPE_CHECKING:
    from sparsurf.streams import Streams

# A full disk, a folder that may not be written
DISK_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EACCES, errno.EROFS)


collect_rarely()  # here: a script imports this module first, and then numba, pandas and others

RAISE = "raises_errors"  # attribute of the object `snakemake` that sparsurf_study.debug hands to a script


class Job:
    """What a script reads and writes: `input`, `output`, `params`, `wildcards` and `threads` of Snakemake.

    `output` has the paths at which the script writes; they get their final names together, at the end of the job.
    """

    def __init__(self, snakemake: Any, output: Any = None) -> None:
        self.snakemake = snakemake
        if output is not None:
            self.output = output

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


class _FinalNames(logging.Formatter):
    """Name outputs in the log by their final paths."""

    def format(self, record: logging.LogRecord) -> str:
        return with_final_names(super().format(record))


@contextmanager
def job(snakemake: Any) -> Iterator[Job]:
    """Run a script: its output goes to the log of the rule, and an error ends it with one sentence (traceback in the log)."""
    try:
        # another file, as the job of a killed Snakemake may still write into the earlier one
        Path(snakemake.log[0]).unlink(missing_ok=True)
        # by lines, so that the terminal and a reader of the log follow a running job
        log = open(snakemake.log[0], "w", encoding="utf-8", buffering=1)  # noqa: SIM115, closed below
    except OSError as error:
        sys.exit(f"\n  {_sentence(error, snakemake)}\n")
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that it removes its temporary folders
    with redirect_stdout(log), redirect_stderr(log):
        handler = logging.StreamHandler(log)
        handler.setFormatter(_FinalNames("%(levelname)s %(message)s"))
        logging.captureWarnings(True)
        try:
            with (
                listening(handler.handle, logging.INFO, log=logging.getLogger()),
                _outputs_together(snakemake) as work,
            ):
                yield work
            print(f"{USED_MARK}{used()}", file=log)
        except (KeyboardInterrupt, Exception) as error:
            sentence = with_final_names(_sentence(error, snakemake))
            with suppress(OSError):  # the log may lie on the same full disk
                print(f"{ERROR_MARK}{sentence}", file=log)
            if sentence == STOPPED:
                raise KeyboardInterrupt from None
            if getattr(snakemake, RAISE, False):
                raise
            print(f"\n  {sentence}\n", file=sys.__stderr__, flush=True)
            sys.exit(1)
        finally:
            logging.captureWarnings(False)
            with suppress(OSError):
                log.close()


@contextmanager
def _outputs_together(snakemake: Any) -> Iterator[Job]:
    """Let all outputs of a job appear when it has finished, with its record in the ledger; none where it fails."""
    if not hasattr(snakemake, "output"):  # of a script that no rule runs
        yield Job(snakemake)
        return
    entry = Entry(snakemake)
    # Jobs of one rule may write into one folder; the folders of their logs tell them apart
    staging = Staging(snakemake.output, "-".join(Path(snakemake.log[0]).with_suffix("").parts[-4:]))
    # The earlier record goes first and the new one comes last. Killed at any line, the job leaves outputs without a record,
    # which are computed again, and never a record of other outputs than those that lie there.
    entry.begin()
    staging.begin()
    try:
        yield Job(snakemake, staging.outputs)
        entry.finish(staging.written())
        staging.publish()
        entry.publish()
    finally:
        staging.discard()


def let_jobs_import_packages() -> None:
    """Put the packages of this checkout first on the import path of the processes that Snakemake starts."""
    ignore_numba_threads()
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


SECONDS_BETWEEN_REPORTS = 2.0  # of a long step to the log


def reporter(title: str, unit: str = "subsets") -> Callable[[int, int], None]:
    """Return a callback (done, total) that writes the progress of a long step to the log, every few seconds.

    The time to go follows from the steps after the first report: what comes before it, such as loading the code, is done once.
    """
    begin = last = time.monotonic()
    first: tuple[float, int] | None = None

    def report(done: int, total: int) -> None:
        nonlocal first, last
        now = time.monotonic()
        if first is None:
            first = (now, done)
        since, steps = now - first[0], done - first[1]
        if (now - last >= SECONDS_BETWEEN_REPORTS and steps) or done >= total:
            last = now
            left = since * (total - done) / max(steps, 1)
            text = f"{done} of {total} {unit}, {now - begin:.0f} s, {left:.0f} s to go"
            print(f"{PROGRESS}{title}: {text}", file=sys.stderr)

    return report
