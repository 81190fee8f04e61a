"""Snakemake as another process: one study at a time per checkout, signals passed on, its errors kept and reported."""

import fcntl
import getpass
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import IO

import psutil

from sparsurf.errors import InputError
from sparsurf.kernel_cache import can_write_cache
from sparsurf_study import catalogue
from sparsurf_study.batches.assignment import batched_structures
from sparsurf_study.report.finished import Finished
from sparsurf_study.workflow.config import needed_conformations, sampled_proteins
from sparsurf_study.workflow.conformations import first_column, without_zeros
from sparsurf_study.workflow.job_logs import FAILED_JOBS, FULL_DISK_BYTES, failure, place_of_log
from sparsurf_study.workflow.local_jobs import wait_here

# Jobs that lead to the conformations of a protein: without one of them there are none
BEFORE_CONFORMATIONS = ("choose_frames", "fetch_", "prepare_system", "simulate_", "judge_")
SNAKEMAKES_PROFILE = "SNAKEMAKE_PROFILE"  # environment variable, as --profile
SNAKEMAKES_GREETING = "Using workflow specific profile"


@contextmanager
def locked(root: Path) -> Iterator[None]:
    """Hold the operating system's lock of a checkout, which ends with the process and with Snakemake, which inherits it."""
    path = root / ".snakemake" / "study.lock"
    try:
        path.parent.mkdir(exist_ok=True)
        lock = path.open("a", encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"{path.parent} cannot be written ({error.strerror}): a study needs its folder."
        ) from None
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(_words_about(path)) from None
        os.set_inheritable(lock.fileno(), True)
        yield


def _words_about(lock: Path) -> str:
    """Return the sentence that refuses a second study; it names the process of the first where it is of this user and machine."""
    path, notice = str(lock.resolve()), "Another study runs in this folder"
    for process in psutil.process_iter():  # in the order of their numbers
        with suppress(psutil.Error):
            pid, files = process.pid, process.open_files()
            if pid != os.getpid() and path in [file.path for file in files]:
                return f"{notice} (process {pid}). Wait for it to end, or end it with `kill {pid}`."
    return f"{notice}; wait for it to end."


def run_snakemake(
    root: Path,
    configs: Sequence[Path],
    *options: str,
    errors: Path | None = None,
    wait: Callable[[subprocess.Popen, list[int]], int | None] = wait_here,
) -> int:
    """Run Snakemake in a checkout and return its exit code; a config stands before an earlier one.

    The terminal sends Ctrl-C to it directly; SIGTERM is passed on, also for a closed terminal. `errors` is a file for standard
    error, and `wait` takes the process and the signals received so far, after which it ends the jobs; where it returns None,
    Snakemake is started again.
    """
    # --nolock: `locked` holds the checkout instead. The lock of Snakemake is a file, which stays after a kill.
    where = ["--snakefile", str(root / "Snakefile"), "--directory", str(root), "--nolock"]
    command = [sys.executable, "-m", "snakemake", *where, "--configfile", *map(str, configs), *options]
    received: list[int] = []
    _complete_account(root)

    def pass_on(number: int, _: FrameType | None) -> None:
        received.append(number)
        if number != signal.SIGINT:
            process.terminate()

    with open(errors or os.devnull, "a", encoding="utf-8") as stream:
        process = _start(command, stream if errors else None)
        numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # the last is ignored under nohup
        heard = [number for number in numbers if signal.getsignal(number) != signal.SIG_IGN]
        handlers = {number: signal.signal(number, pass_on) for number in heard}
        while (code := wait(process, received)) is None:
            process = _start(command, stream if errors else None)
    for number, handler in handlers.items():
        signal.signal(number, handler)
    if received and code:
        raise KeyboardInterrupt(received[0])
    return code


def _complete_account(root: Path) -> None:
    """Name a home and a user where the account has none, as in a container; Snakemake ends without them."""
    if not can_write_cache():
        os.environ |= {"HOME": str(root / ".snakemake"), "XDG_CACHE_HOME": ""}
    try:
        getpass.getuser()
    except (KeyError, OSError):  # the latter from Python 3.13 on
        os.environ["LOGNAME"] = str(os.getuid())


def _start(command: Sequence[str], errors: IO[str] | None) -> subprocess.Popen:
    """Start Snakemake, which inherits the lock of the checkout."""
    return subprocess.Popen(command, close_fds=False, stderr=errors)


def make_writable(folder: Path) -> None:
    """Create a folder; raise InputError if it cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(FULL_DISK_BYTES // 10))
    except OSError as error:
        raise InputError(
            f"{folder}/ cannot be written ({error.strerror}). Make it writable or free some space, and run again."
        ) from None


@contextmanager
def failed_jobs() -> Iterator[list[str]]:
    """Yield a list that receives the logs of the failed jobs on exit."""
    failed: list[str] = []
    with tempfile.NamedTemporaryFile("r", encoding="utf-8") as file:
        os.environ[FAILED_JOBS] = file.name
        yield failed
        logs = dict.fromkeys(file.read().splitlines())
        failed += [log for log in logs if failure(log) is not None]  # a second attempt may have finished


def say_what_failed(run: Path, failed: list[str], code: int) -> None:
    """Print on standard error why some results are missing, after Snakemake has ended with an exit code."""
    folders = [folder for folder in (run, Path(".snakemake")) if folder.is_dir()]
    for folder in folders:
        if shutil.disk_usage(folder).free < FULL_DISK_BYTES:
            message = f"The disk of {folder}/ is full. Free some space and run again: finished results stay."
            print(message, file=sys.stderr)
            break
    reasons = [f"- {Path(log).relative_to(run / 'logs').with_suffix('')}: {failure(log)}" for log in failed]
    if code < 0:
        name = signal.Signals(-code).name
        reasons.append(
            f"Snakemake was killed ({name}), by someone or for want of memory; the same command continues where it was."
        )
    if not reasons:
        errors = run / "logs" / "snakemake.err"
        lines = errors.read_text(encoding="utf-8", errors="replace").splitlines() if errors.is_file() else []
        reasons = [line for line in lines if line.strip() and not line.startswith(SNAKEMAKES_GREETING)][-1:]
        reasons.append(f"See {errors} and the newest file of .snakemake/log/.")
    message = f"\nSome results could not be computed. Finished results are in {run}/."
    print(message, *reasons, sep="\n", file=sys.stderr)


def finished_parts(config: dict, run: Path, failures: Mapping[str, str]) -> Finished:
    """Return what is finished of a run without the places in `failures`, see `failed_places`."""
    folders = finished_conformations(config, run, failures)
    pairs = {name: run / "pairs" / name for name in config["pairs"] if f"pairs/{name}" not in failures}
    pairs = {
        name: pair
        for name, pair in pairs.items()
        if has_all(pair, "pairs/<pair>", catalogue.conditions_of_pair(config, name))
    }
    files = [*files_of_proteins(config, run, failures, folders)]
    for name in config["changes"]:
        if f"changes/{name}" not in failures:
            files += stored_files(run / "changes" / name, catalogue.outputs_in("changes/<comparison>"))
    if run / config.get("paper", "") / "c1" in folders:
        files += stored_files(run, catalogue.requested("", {"paper"}))
    for pair in pairs.values():
        files += stored_files(pair, catalogue.outputs_in("pairs/<pair>"))
    return Finished(folders, [*pairs.values()], sampled_proteins(config), files)


def files_of_proteins(
    config: dict, run: Path, failures: Mapping[str, str], folders: Sequence[Path]
) -> Iterator[Path]:
    """Yield the files of the proteins that are finished, and of their finished conformations, `folders`."""
    for protein in proteins_with_folders(config):
        if not {protein, f"{protein}/*"} & failures.keys():
            yield from stored_files(run / protein, catalogue.outputs_in("<protein>"))
        for folder in folders:
            if folder.parent.name == protein:
                yield from stored_files(folder, catalogue.outputs_in("<protein>/<conformation>"))


def stored_files(folder: Path, outputs: Iterable[catalogue.Output]) -> Iterator[Path]:
    """Yield the files of a folder that are outputs, or that lie in a folder which is one, without hidden files."""
    for output in outputs:
        path = folder / output.name
        if path.is_dir():
            yield from sorted(file for file in path.rglob("[!.]*") if file.is_file())
        elif path.is_file():
            yield path


def has_all(folder: Path, part: str, conditions: Collection[str]) -> bool:
    """Return whether a folder has all outputs that a study asks for under these conditions, see `catalogue.requested`."""
    return all((folder / output.name).exists() for output in catalogue.requested(part, conditions))


def failed_places(config: dict, run: Path, failed: list[str]) -> dict[str, str]:
    """Return what a checked config excludes, the places of jobs with failed logs, and what needs them, with their reasons."""
    places = dict(config["exclude"])
    whole = "/*" if batched_structures(config) else ""  # the page of a structure failed; its batch keeps it
    for log in failed:
        protein, conformation, job = place_of_log(log, run / "logs")
        over_frames = protein in config["proteins"] and not job.startswith(BEFORE_CONFORMATIONS)
        place = "/".join(filter(None, (protein, conformation or ("*" if over_frames else ""))))
        place += whole if place and place == protein else ""
        if place:  # a job over all proteins has no place
            places[place] = f"{job}: {failure(log)}"
    for place, needed in needed_conformations(config).items():
        for name in needed:
            protein, _, conformation = name.partition("/")
            first = next(iter(chosen_conformations(config, run, protein)), "c1")
            if is_in(places, protein, conformation or first):
                places.setdefault(place, f"{name} could not be finished.")
    return places


def finished_conformations(config: dict, run: Path, failures: Mapping[str, str]) -> list[Path]:
    """Return the folders of the conformations that have all of their outputs and are not among `failures`."""
    folders = []
    for protein in proteins_with_folders(config):
        conditions = catalogue.conditions_of_protein(config, protein)
        for conformation in chosen_conformations(config, run, protein):
            folder = run / protein / conformation
            failed = is_in(failures, protein, conformation)
            if not failed and has_all(folder, "<protein>/<conformation>", conditions):
                folders.append(folder)
    return folders


def proteins_with_folders(config: dict) -> list[str]:
    """Return the names of the proteins whose files lie in folders of their own."""
    return config.get("pages", []) if batched_structures(config) else [*config["proteins"]]


def chosen_conformations(config: dict, run: Path, protein: str) -> list[str]:
    """Return the conformations of a protein, none where its frames are not chosen yet."""
    if "surface" in config["proteins"][protein]:
        return ["c1"]
    frames = run / protein / "frames.csv"
    return first_column(frames) if frames.is_file() else []


def is_in(places: Mapping[str, str], protein: str, conformation: str) -> bool:
    """Return whether a conformation, by any way to write its name, or its protein is among some places."""
    return not {protein, without_zeros(f"{protein}/{conformation}")}.isdisjoint(map(without_zeros, places))
