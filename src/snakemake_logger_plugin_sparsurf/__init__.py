"""Snakemake's logger of a study: a line for each job, its warnings, and how far a long job is (`--logger sparsurf`)."""

import os
import re
import shutil
import sys
import threading
import time
from contextlib import suppress
from logging import WARNING
from typing import Any

from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent

from sparsurf.errors import printable
from sparsurf_study.workflow import job_logs

SECONDS_BEFORE_BAR, SECONDS_BETWEEN_LINES, BAR_WIDTH = 10, 30, 24  # the lines where no terminal shows the bar
TOLD = re.compile("Nothing to be done|Terminating processes|Trying to restart")  # beside warnings
REPEATED = re.compile("Exiting because|At least one job|RuleException|CalledProcessError")  # about a job


class LogHandler(LogHandlerBase):
    """Print events; Snakemake's own words are in .snakemake/log/, and here with `-n` or `--verbose`."""

    writes_to_stream = writes_to_file = has_filter = has_formatter = needs_rulegraph = False

    def __post_init__(self) -> None:
        self.writes_to_stream = not (self.common_settings.dryrun or self.common_settings.verbose)
        self.addFilter(lambda _: self.writes_to_stream)
        self._running: dict[int, tuple[Any, float]] = {}  # event and begin of a job
        self._finished: list[tuple[Any, float]] = []
        self._steps, self._bar, self._told, self._lock = "", "", set[str](), threading.Lock()
        os.environ[job_logs.SHOWN] = "1"
        threading.Thread(target=self._watch, daemon=True).start()

    def emit(self, record: Any) -> None:
        """Print what an event means; a closed terminal does not fail the run."""
        event = getattr(record, "event", LogEvent.ERROR)
        with self._lock, suppress(OSError):
            if event == LogEvent.JOB_INFO:
                self._running[record.jobid] = record, time.monotonic()
            elif event == LogEvent.JOB_FINISHED and record.job_id in self._running:
                self._finished.append(self._running.pop(record.job_id))
            elif event == LogEvent.PROGRESS:
                self._steps = f"{record.done} of {record.total}"
                while self._finished:
                    self._finish(*self._finished.pop())
            elif event == LogEvent.JOB_ERROR and record.jobid in self._running:
                job, _ = self._running.pop(record.jobid)
                reason = job_logs.reason_of(job.log[0]) if job.log else job_logs.NO_REASON
                self._say(f"{'Failed':>10}  {job.rule_msg or job.rule_name}: {reason}")
            elif event == LogEvent.ERROR:
                text = record.getMessage()
                if text.startswith("ProtectedOutputException"):  # its first file says which disk or folder
                    path = text.partition("affected files:")[2].split()[0]
                    text = f"{path} cannot be written. Make it and its folder writable and run again."
                if TOLD.match(text) or (record.levelno >= WARNING and not REPEATED.search(text)):
                    self._say(text)
                if text.startswith("Terminating"):
                    self._running.clear()

    def _finish(self, job: Any, begin: float) -> None:
        """Say that a job has ended, with its warnings and the first picture; a job without a log is a mark."""
        for log in job.log:
            self._say(f"{self._steps:>10}  {job.rule_msg} ({time.monotonic() - begin:.0f} s)")
            self._say(*(f"{'':>10}  Warning: {sentence}" for sentence in job_logs.warnings_in(log)))
        # A workflow that imports this one may put a word before the name of the rule
        if job.rule_name.endswith("draw_roughness") and "picture" not in self._told:
            self._told.add("picture")
            self._say(f"First picture  {job.output[0]}")

    def _say(self, *lines: str, bar: str = "") -> None:
        """Print lines in place of the bar, and then the next bar."""
        text = "".join(f"{printable(line)}\n" for line in lines) + printable(bar)
        print("\r\033[K" * bool(self._bar) + text, end="", flush=True)
        self._bar = bar

    def _watch(self) -> None:
        """Show every second, or every half minute, how far the longest job is."""
        while True:
            time.sleep(1)
            with self._lock, suppress(OSError):
                job, begin = next(iter(self._running.values()), (None, 0))
                bar = self._far(job, time.monotonic() - begin) if job else ""
                if sys.stdout.isatty():
                    self._say(bar=bar[: shutil.get_terminal_size().columns - 1])
                elif bar and int(time.monotonic()) % SECONDS_BETWEEN_LINES == 0:
                    self._say(bar)

    def _far(self, job: Any, seconds: float) -> str:
        """Return how far a long job is, with a bar where its log counts steps; say once that kernels are compiled."""
        log, bar, left = str(*job.log[:1]), "", ""
        if job_logs.COMPILING not in self._told and job_logs.lines_after(log, job_logs.COMPILING):
            self._told.add(job_logs.COMPILING)
            self._say(f"{'':>10}  {job_logs.COMPILING}")
        for line in job_logs.lines_after(log, job_logs.PROGRESS)[-1:]:
            done, total, spent = map(int, re.findall(r"(\d+) of (\d+) .*?(\d+) s", line)[-1])
            bar = f"{'█' * round(BAR_WIDTH * done / total):░<{BAR_WIDTH}} "
            left = f", about {spent * (total - done) / done:.0f} s to go" if 0 < done < total else ""
        text = f"{self._steps:>10}  {bar}{job.rule_msg}, {seconds:.0f} s{left}"
        return text if seconds >= SECONDS_BEFORE_BAR else ""
