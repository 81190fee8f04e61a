"""What a run says on the terminal: a line for each job, its warnings, and a bar while a long one works.

Snakemake hands its events to `Terminal`; all that it says itself goes to .snakemake/log/. What a job says is in its log.
"""

import errno
import logging
import os
import shutil
import sys
import threading
import time
from pathlib import Path

from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent

from sparsurf.workflow.job_logs import failure, progress, warnings_in
from sparsurf.workflow.partial_runs import FAILED_JOBS as FAILED

LONG = 10  # seconds from which on a job has a bar
WIDTH = 24  # letters of the bar
ECHOES = (  # of what is told elsewhere: in the line of the job, on a full disk at the end
    "Exiting because a job execution failed",
    "At least one job did not complete",
    "RuleException",
    f"[Errno {errno.ENOSPC}]",
)


class Terminal(LogHandlerBase):
    """Handler of Snakemake's events."""

    writes_to_stream = True
    writes_to_file = False
    has_filter = True
    has_formatter = True
    needs_rulegraph = False

    def __post_init__(self):
        self._jobs, self._finished, self._steps, self._said = {}, [], "", set()
        self._lock, self._ends, self._bar = threading.Lock(), threading.Event(), ""
        if sys.stdout.isatty() and not self.common_settings.dryrun:
            threading.Thread(target=self._watch, daemon=True).start()

    def emit(self, record):
        """Say what an event means; a terminal that is gone is no mistake of the run."""
        does = {
            LogEvent.JOB_INFO: self._begin,
            LogEvent.JOB_FINISHED: self._finish,
            LogEvent.PROGRESS: self._count,
            LogEvent.JOB_ERROR: self._fail,
            LogEvent.GROUP_ERROR: self._fail_group,
        }.get(getattr(record, "event", None), self._other)
        try:
            with self._lock:
                does(record)
        except OSError:
            pass

    def close(self):
        """End the bar."""
        self._ends.set()
        with self._lock:
            self._flush()
            self._show("")
        super().close()

    def _begin(self, record):
        self._jobs[record.jobid] = (record, time.monotonic())
        if self.common_settings.dryrun and record.rule_msg:
            self._say(record.rule_msg)

    def _finish(self, record):
        self._finished.append(self._jobs.pop(record.job_id, None))

    def _count(self, record):
        self._steps = f"{record.done} of {record.total}"
        self._flush()

    def _flush(self):
        for record, begin in filter(None, self._finished):
            if record.log:  # marks have none
                self._say(f"{self._steps:>10}  {record.rule_msg} ({time.monotonic() - begin:.0f} s)")
                for sentence in warnings_in(record.log[0]):
                    self._say(f"{'':>10}  Warning: {sentence}")
        self._finished = []

    def _fail(self, record):
        known = self._jobs.pop(record.jobid, None)
        self._failed(known[0].rule_msg if known else record.rule_name, record.log)

    def _fail_group(self, record):
        for job in record.job_error_info:
            if job["log"] and failure(job["log"][0]) is not None:
                self._failed(job["rule_name"], job["log"])

    def _failed(self, what, logs):
        self._say(f"{'Failed':>10}  {what}: {failure(logs[0]) if logs else 'see .snakemake/log'}")
        if logs and (path := os.environ.get(FAILED)):
            with open(path, "a", encoding="utf-8") as stream:
                stream.write(f"{logs[0]}\n")

    def _other(self, record):
        text = record.getMessage()
        if (
            record.levelno >= logging.ERROR
            and not any(echo in text for echo in ECHOES)
            and text not in self._said
        ):
            self._said.add(text)
            self._say(text)

    def _say(self, line):
        shown, self._bar = self._bar, ""
        print("\r\033[K" * bool(shown) + line, flush=True)

    def _show(self, bar):
        if bar or self._bar:
            print(f"\r\033[K{bar}", end="", flush=True)
        self._bar = bar

    def _watch(self):
        """Draw the bar of the job that works longest, every second."""
        while not self._ends.wait(1):
            with self._lock:
                longest = min(self._jobs.values(), key=lambda job: job[1], default=None)
                long = longest and time.monotonic() - longest[1] > LONG
                self._show(self._bar_of(*longest)[: shutil.get_terminal_size().columns - 1] if long else "")

    def _bar_of(self, record, begin):
        done, of, left = (
            progress(record.log[0]) if record.log and Path(record.log[0]).is_file() else (0, 0, 0)
        )
        seconds = f"{time.monotonic() - begin:.0f} s"
        if not of:
            return f"{self._steps:>10}  {record.rule_msg}, {seconds}"
        full = round(WIDTH * done / of)
        return f"{self._steps:>10}  {'█' * full}{'░' * (WIDTH - full)} {record.rule_msg}, {seconds}, {left:.0f} s to go"
