"""What a run prints: a line for each job, its warnings, the first picture, and how far a long job is.

On a terminal, that is a bar that is drawn every second; in a file or pipe, it is a line every half minute.

Snakemake hands its events to `Terminal`. Its own messages are in .snakemake/log/, those of a job in the job's log.
"""

import errno
import json
import logging
import os
import shutil
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent

from sparsurf.errors import printable
from sparsurf_study.workflow.job_logs import FAILED_JOBS, STOPPED, failure, progress, warnings_in
from sparsurf_study.workflow.ledger import TO_MAKE_AGAIN

SECONDS_BEFORE_BAR = 10
SECONDS_BETWEEN_LINES = 30  # where there is no terminal to draw a bar on
BAR_WIDTH = 24  # characters
FIRST_PICTURES = "draw_roughness"  # end of the name of the rule that draws them, which a workflow that imports it may extend
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
        self._reasons: dict[str, str] = {}  # by result: why it is computed again
        with suppress(OSError, KeyError):
            self._reasons = json.loads(Path(os.environ[TO_MAKE_AGAIN]).read_text(encoding="utf-8"))
        self._steps = self._bar = ""
        self._stopping = self._has_picture = False
        if not self.common_settings.dryrun:
            watch = self._watch if sys.stdout.isatty() else self._report
            threading.Thread(target=watch, daemon=True).start()

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
        for reason in [self._reasons.pop(path, "") for path in record.output or ()]:  # once
            if reason:
                self._say(f"{'':>10}  {reason}")
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
                self._name_picture(record)
        self._finished = []

    def _name_picture(self, record: Any) -> None:
        """Name the picture of a job and the page around it, if they are the first of the run."""
        pictures = [path for path in record.output if path.endswith(".png")]
        if record.rule_name.endswith(FIRST_PICTURES) and pictures and not self._has_picture:
            self._has_picture = True
            self._say(f"First picture  {pictures[0]}")
            for page in [path for path in record.output if path.endswith(".html")]:
                self._say(f"First view     {page}")

    def _fail(self, record: Any) -> None:
        job = self._running.pop(record.jobid, None)
        self._failed(job[0].rule_msg if job else record.rule_name, record.log)

    def _fail_group(self, record: Any) -> None:
        for job in record.job_error_info:
            if job["log"] and failure(job["log"][0]) is not None:
                self._failed(job["rule_name"], job["log"])

    def _failed(self, title: str, logs: list[str]) -> None:
        reason = failure(logs[0]) if logs else "see .snakemake/log"
        if self._stopping or reason == STOPPED:
            self._say(f"{'Stopped':>10}  {title}")
        else:
            self._say(f"{'Failed':>10}  {title}: {reason}")
        if logs and (path := os.environ.get(FAILED_JOBS)):
            with open(path, "a", encoding="utf-8") as stream:
                stream.write(f"{logs[0]}\n")

    def _other(self, record: Any) -> None:
        text = record.getMessage()
        if text.startswith(STOPPING) and not self._stopping:
            self._stopping = True
            self._say(f"{self._steps or 'Nothing':>10}  done. Stopping ...")
        is_told = text in self._messages or any(part in text for part in REPEATED_ELSEWHERE)
        if record.levelno >= logging.ERROR and not is_told:
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
                oldest = self._longest(SECONDS_BEFORE_BAR)
                self._show(self._bar_of(*oldest)[: shutil.get_terminal_size().columns - 1] if oldest else "")

    def _report(self) -> None:
        """Say every half minute how far the job is that works longest; a closed pipe does not fail the run."""
        while not self._ends.wait(SECONDS_BETWEEN_LINES):
            with self._lock, suppress(OSError):
                if oldest := self._longest(SECONDS_BEFORE_BAR):
                    self._say(self._words_of(*oldest))

    def _longest(self, least: float) -> tuple[Any, float] | None:
        """Return the job that works longest, with its begin, if it has worked for `least` seconds."""
        oldest = min(self._running.values(), key=lambda job: job[1], default=None)
        return oldest if oldest and time.monotonic() - oldest[1] > least else None

    def _words_of(self, record: Any, begin: float) -> str:
        """Say how far a job is: what it does, steps done of all if its log has them, and seconds."""
        done, total, left = self._progress_of(record)
        steps = f", {done} of {total}" if total else ""
        return f"{self._steps:>10}  {record.rule_msg}{steps}, {time.monotonic() - begin:.0f} s{_to_go(done, total, left)}"

    def _progress_of(self, record: Any) -> tuple[int, int, int]:
        """Return (done, total, seconds to go) of a job; zeros where its log has none."""
        has_log = record.log and Path(record.log[0]).is_file()
        return progress(record.log[0]) if has_log else (0, 0, 0)

    def _bar_of(self, record: Any, begin: float) -> str:
        """Return the bar of a job that works, or its seconds where it does not say how far it is."""
        done, total, left = self._progress_of(record)
        if not total:
            return self._words_of(record, begin)
        full, seconds = round(BAR_WIDTH * done / total), f"{time.monotonic() - begin:.0f} s"
        bar = "█" * full + "░" * (BAR_WIDTH - full)
        return f"{self._steps:>10}  {bar} {record.rule_msg}, {seconds}{_to_go(done, total, left)}"


def _to_go(done: int, total: int, left: float) -> str:
    """Say about how long a job takes yet; nothing after its last counted step, as what follows is not counted."""
    return f", about {left:.0f} s of this job to go" if done < total else ""
