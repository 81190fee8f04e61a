"""What a run prints on the terminal: a line for each job, its warnings, and a bar while a long one works.

Snakemake hands its events to `Terminal`. Its own messages are in .snakemake/log/, those of a job in the job's log.
"""

import errno
import logging
import os
import shutil
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent

from sparsurf.errors import printable
from sparsurf_study.workflow.job_logs import FAILED_JOBS, STOPPED, failure, progress, warnings_in

SECONDS_BEFORE_BAR = 10
BAR_WIDTH = 24  # characters
REPEATED_ELSEWHERE = (  # in the line of the job, or at the end of the run
    "Exiting because a job execution failed",
    "At least one job did not complete",
    "RuleException",
    f"[Errno {errno.ENOSPC}]",
)
STOPPING = ("Terminating processes on user request", "Will exit after finishing")  # Ctrl-C, SIGTERM


class Terminal(LogHandlerBase):
    """Handler of Snakemake's events."""

    writes_to_stream = True
    writes_to_file = False
    has_filter = True
    has_formatter = True
    needs_rulegraph = False

    def __post_init__(self) -> None:
        self._running: dict[int, tuple[Any, float]] = {}  # record and begin of a job
        self._finished: list[tuple[Any, float]] = []
        self._messages: set[str] = set()
        self._lock, self._ends = threading.Lock(), threading.Event()
        self._steps = self._bar = ""
        self._stopping = False
        if sys.stdout.isatty() and not self.common_settings.dryrun:
            threading.Thread(target=self._watch, daemon=True).start()

    def emit(self, record: logging.LogRecord) -> None:
        """Print what an event means; a closed terminal does not fail the run."""
        handlers: dict[Any, Callable[[Any], None]] = {
            LogEvent.JOB_INFO: self._begin,
            LogEvent.JOB_FINISHED: self._finish,
            LogEvent.PROGRESS: self._count,
            LogEvent.JOB_ERROR: self._fail,
            LogEvent.GROUP_ERROR: self._fail_group,
        }
        handle = handlers.get(getattr(record, "event", None), self._other)
        try:
            with self._lock:
                handle(record)
        except OSError:
            pass

    def close(self) -> None:
        """End the bar."""
        self._ends.set()
        with self._lock:
            self._flush()
            self._show("")
        super().close()

    def _begin(self, record: Any) -> None:
        self._running[record.jobid] = (record, time.monotonic())
        if self.common_settings.dryrun and record.rule_msg:
            self._say(record.rule_msg)

    def _finish(self, record: Any) -> None:
        if record.job_id in self._running:
            self._finished.append(self._running.pop(record.job_id))

    def _count(self, record: Any) -> None:
        self._steps = f"{record.done} of {record.total}"
        self._flush()

    def _flush(self) -> None:
        for record, begin in self._finished:
            if record.log:  # marks have none
                self._say(f"{self._steps:>10}  {record.rule_msg} ({time.monotonic() - begin:.0f} s)")
                for sentence in warnings_in(record.log[0]):
                    self._say(f"{'':>10}  Warning: {sentence}")
        self._finished = []

    def _fail(self, record: Any) -> None:
        known = self._running.pop(record.jobid, None)
        self._failed(known[0].rule_msg if known else record.rule_name, record.log)

    def _fail_group(self, record: Any) -> None:
        for job in record.job_error_info:
            if job["log"] and failure(job["log"][0]) is not None:
                self._failed(job["rule_name"], job["log"])

    def _failed(self, what: str, logs: list[str]) -> None:
        reason = failure(logs[0]) if logs else "see .snakemake/log"
        if self._stopping or reason == STOPPED:
            self._say(f"{'Stopped':>10}  {what}")
        else:
            self._say(f"{'Failed':>10}  {what}: {reason}")
        if logs and (path := os.environ.get(FAILED_JOBS)):
            with open(path, "a", encoding="utf-8") as stream:
                stream.write(f"{logs[0]}\n")

    def _other(self, record: Any) -> None:
        text = record.getMessage()
        if text.startswith(STOPPING) and not self._stopping:
            self._stopping = True
            self._say(f"{self._steps or 'Nothing':>10}  done. Stopping ...")
        known = text in self._messages or any(part in text for part in REPEATED_ELSEWHERE)
        if record.levelno >= logging.ERROR and not known:
            self._messages.add(text)
            self._say(text)

    def _say(self, line: str) -> None:
        shown, self._bar = self._bar, ""
        print("\r\033[K" * bool(shown) + printable(line), flush=True)

    def _show(self, bar: str) -> None:
        if bar or self._bar:
            print(f"\r\033[K{bar}", end="", flush=True)
        self._bar = bar

    def _watch(self) -> None:
        """Draw the bar of the job that works longest, every second."""
        while not self._ends.wait(1):
            with self._lock:
                oldest = min(self._running.values(), key=lambda job: job[1], default=None)
                if oldest and time.monotonic() - oldest[1] > SECONDS_BEFORE_BAR:
                    self._show(self._bar_of(*oldest)[: shutil.get_terminal_size().columns - 1])
                else:
                    self._show("")

    def _bar_of(self, record: Any, begin: float) -> str:
        has_log = record.log and Path(record.log[0]).is_file()
        done, total, left = progress(record.log[0]) if has_log else (0, 0, 0)
        seconds = f"{time.monotonic() - begin:.0f} s"
        if not total:
            return f"{self._steps:>10}  {record.rule_msg}, {seconds}"
        full = round(BAR_WIDTH * done / total)
        return f"{self._steps:>10}  {'█' * full}{'░' * (BAR_WIDTH - full)} {record.rule_msg}, {seconds}, {left:.0f} s to go"
