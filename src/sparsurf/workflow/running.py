"""Snakemake as another process: one study at a time per checkout, signals passed on, its errors kept and reported."""

import fcntl
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from sparsurf.errors import InputError
from sparsurf.workflow.job_logs import FAILED_JOBS, FULL_DISK_BYTES, failure

SNAKEMAKES_GREETING = "Using workflow specific profile"


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
    wait: Callable[[subprocess.Popen, list[int]], int] = lambda process, _: process.wait(),
) -> int:
    """Run Snakemake in a checkout and return its exit code; a config stands before an earlier one.

    The terminal sends Ctrl-C to it directly; SIGTERM is passed on, also for a closed terminal. Both wait until it has ended its
    jobs. `errors` is a file for what processes write to standard error, such as tracebacks of jobs that are stopped. `wait` takes
    the process and a list of the signals received so far, and returns its exit code.
    """
    where = ["--snakefile", str(root / "Snakefile"), "--directory", str(root), "--nolock"]
    command = [sys.executable, "-m", "snakemake", *where, "--configfile", *map(str, configs), *options]
    received: list[int] = []

    def pass_on(number: int, _: FrameType | None) -> None:
        received.append(number)
        if number != signal.SIGINT:
            process.terminate()

    with open(errors or os.devnull, "a", encoding="utf-8") as stream:
        process = subprocess.Popen(command, close_fds=False, stderr=stream if errors else None)
        numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # the last is ignored under nohup
        heard = [number for number in numbers if signal.getsignal(number) != signal.SIG_IGN]
        handlers = {number: signal.signal(number, pass_on) for number in heard}
        code = wait(process, received)
    for number, handler in handlers.items():
        signal.signal(number, handler)
    if received and code:
        raise KeyboardInterrupt(received[0])
    return code


def make_writable(folder: Path) -> None:
    """Create a folder; raise InputError if it cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(FULL_DISK_BYTES // 10))
    except OSError as error:
        raise InputError(f"{folder}/ cannot be written ({error.strerror}). Repair that first.") from None


@contextmanager
def failed_jobs() -> Iterator[list[str]]:
    """Yield a list that receives the logs of the failed jobs on exit."""
    failed: list[str] = []
    with tempfile.NamedTemporaryFile("r", encoding="utf-8") as file:
        os.environ[FAILED_JOBS] = file.name
        yield failed
        logs = dict.fromkeys(file.read().splitlines())
        failed += [log for log in logs if failure(log) is not None]  # a second attempt may have finished


def say_what_failed(run: Path, failed: list[str]) -> None:
    """Print on standard error why some results are missing."""
    folders = [folder for folder in (run, Path(".snakemake")) if folder.is_dir()]
    for folder in folders:
        if shutil.disk_usage(folder).free < FULL_DISK_BYTES:
            print(
                f"The disk of {folder}/ is full. Free some space and run again: finished results stay.",
                file=sys.stderr,
            )
            break
    reasons = [f"- {Path(log).relative_to(run / 'logs').with_suffix('')}: {failure(log)}" for log in failed]
    if not reasons:
        errors = run / "logs" / "snakemake.err"
        lines = errors.read_text(encoding="utf-8", errors="replace").splitlines() if errors.is_file() else []
        reasons = [line for line in lines if line.strip() and not line.startswith(SNAKEMAKES_GREETING)][-1:]
        reasons.append(f"See {errors} and the newest file of .snakemake/log/.")
    print(
        f"\nSome results could not be computed. Finished results are in {run}/.",
        *reasons,
        sep="\n",
        file=sys.stderr,
    )
