"""Run a study: `python scripts/study.py [config.yaml] [--cluster slurm | --profile FOLDER] [compare] [snakemake options]`.

Without a config, that is the default study, config.yaml, on all cores. A run that was stopped or killed continues where it was.
"""

import csv
import json
import os
import signal
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace

from sparsurf_study.workflow.jobs import DISK_ERRORS, job
from sparsurf.errors import InputError
from sparsurf.files import open_closed_streams, pluralise
from sparsurf.threads import ignore_numba_threads
from sparsurf_study.batches.assignment import BATCH_FOLDERS, batched_structures, batches_of
from sparsurf_study.workflow import adoption, ledger
from sparsurf_study.workflow.config import check_config, read_config
from sparsurf_study.workflow.job_logs import collected_warnings
from sparsurf_study.workflow.memory import memory_of_grid, memory_of_machine
from sparsurf_study.workflow.origin import origin_of
from sparsurf_study.workflow.running import (
    SNAKEMAKES_PROFILE,
    failed_jobs,
    failed_places,
    finished_parts,
    locked,
    make_writable,
    run_snakemake,
    say_what_failed,
)
from sparsurf_study.workflow.slurm import JOB_PREFIX, slurm_options, wait_on_slurm
from sparsurf_study.workflow.staging import remove_leftovers

ROOT = Path(__file__).resolve().parents[1]
COMPARE = ROOT / "studies" / "compare.yaml"
METADATA = Path(".snakemake", "metadata")  # of Snakemake, in the checkout
CONFIG_OPTIONS = {"--config", "-C", "--configfile", "--configfiles"}
PLANNING_OPTIONS = {"-n", "-np", "--dry-run", "--dryrun", "-h", "--help"}
SECONDS_OF_SILENCE = 2.0
MAX_CONTRADICTIONS = 10  # on the terminal; all are in checks.csv
REPORTED_MEMORY = 2**30  # bytes that a grid needs before the terminal says so


def main(*arguments: str) -> int:
    """Run Snakemake and print a summary; return the exit code. The first argument may name a config, the others are options."""
    if arguments and arguments[0] in ("-h", "--help"):
        print((__doc__ or "").strip())
        return 0
    is_named = bool(arguments) and arguments[0] != "compare" and not arguments[0].startswith("-")
    path_to_config, *options = arguments if is_named else (str(ROOT / "config.yaml"), *arguments)
    open_closed_streams()
    ignore_numba_threads()
    here, path = Path.cwd(), Path(path_to_config).resolve()
    os.chdir(ROOT)  # paths of rules and results start at the checkout
    try:
        for option in options:
            if option.partition("=")[0] in CONFIG_OPTIONS:
                raise InputError(f"{option}: a study has one config file. Change {path_to_config} instead.")
        if not path.is_file():
            raise InputError(
                f"There is no config file {path_to_config!r}; give one with CONFIG=my_config.yaml."
            )
        files = [path, COMPARE] if "compare" in options else [path]
        if not any(option.partition("=")[0] == "--profile" for option in options):
            os.environ.pop(SNAKEMAKES_PROFILE, None)  # of a login file, for other workflows
        options = cluster_options([option for option in options if option != "compare"], here)
        on_cluster = {"--workflow-profile", "--executor"} & set(options)
        if PLANNING_OPTIONS & set(options):  # also beside a study that runs
            checked_config(files, here=not on_cluster)
            return run_snakemake(ROOT, files, *options)
        with locked(ROOT):
            config = checked_config(files, here=not on_cluster)
            if not on_cluster:  # jobs run side by side as far as the memory reaches
                options = [f"--resources=mem_mb={memory_of_machine() / 1e6:.0f}", *options]
            return run_study(config, files, options)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        if error.errno not in DISK_ERRORS:
            raise
        place = error.filename or "results/"
        print(f"{place}: {error.strerror}. Free or repair the disk and run again.", file=sys.stderr)
        return 2
    except KeyboardInterrupt as stop:
        print("\nStopped. Finished results stay; the same command continues where it was.", file=sys.stderr)
        return 128 + (stop.args[0] if stop.args else signal.SIGINT)


def cluster_options(options: Sequence[str], here: Path) -> list[str]:
    """Return the options with `--cluster NAME` (profiles/NAME) or `--profile FOLDER` replaced by Snakemake's for that profile.

    A relative FOLDER starts where the command was given, `here`.
    """
    tokens: list[str] = []
    for option in options:
        tokens += option.split("=", 1) if option.startswith(("--cluster=", "--profile=")) else [option]
    choice = next((word for word in tokens if word in ("--cluster", "--profile")), None)
    if choice is None:
        return tokens
    position = tokens.index(choice)
    name = "".join(tokens[position + 1 : position + 2])
    profile = ROOT / "profiles" / name if choice == "--cluster" else (here / name).resolve()
    if not name or not any((profile / f"config{version}.yaml").is_file() for version in ("", ".v8+", ".v9+")):
        wanted = (
            "the name of a folder in profiles/, such as slurm"
            if choice == "--cluster"
            else "a folder with the config.yaml of a Snakemake profile"
        )
        raise InputError(f"{choice} needs {wanted}, but has {name or 'none'}.")
    found = slurm_options(profile) if choice == "--cluster" and name == "slurm" else []
    return ["--workflow-profile", str(profile), *found, *tokens[:position], *tokens[position + 2 :]]


def checked_config(paths: Sequence[Path], here: bool) -> dict:
    """Return the config of a study, checked before anything starts; say how much memory a large grid needs."""
    raw = read_config(paths[0])
    if len(paths) > 1:
        section = raw.get("compare")
        raw |= {"compare": (section if isinstance(section, dict) else {}) | {"run": True}}
    patience = threading.Timer(SECONDS_OF_SILENCE, print, ["Checking the config ..."], {"flush": True})
    patience.daemon = True
    patience.start()  # a table of 100,000 proteins takes a minute
    try:
        config = check_config(raw, paths[:1], ROOT, here)
    finally:
        patience.cancel()
    if (needed := memory_of_grid(config)) > REPORTED_MEMORY:
        print(f"The grid of one surface will need about {needed / 2**30:.1f} GB of memory.")
    return config


def run_study(config: dict, files: list[Path], options: Sequence[str]) -> int:
    """Run what is out of date; where jobs fail, close the run without them. Return the exit code."""
    begin, run = time.time(), Path("results", config["run"])
    for folder in (ledger.LOGS, ledger.FOLDER):
        make_writable(run / folder)
    errors = run / "logs" / "snakemake.err"
    errors.unlink(missing_ok=True)
    if replaced := ledger.note_config(run, files[0]):
        print(replaced, flush=True)
    remove_leftovers(run)
    keep_downloads_and_simulations(config, run, files, errors)
    found = ledger.disagreements(run, METADATA)
    for line in found.lines:
        print(line, flush=True)
    wait = {"wait": wait_on_slurm} if JOB_PREFIX in options else {}
    with failed_jobs() as failed, ledger.handed_to_rules(found):
        code = run_snakemake(ROOT, files, "--logger", "sparsurf", *options, errors=errors, **wait)
    finished = code == 0
    if code:
        failures = failed_places(config, run, failed)
        if failures.keys() - config["exclude"].keys():
            finished = closed(config, run, failures, files)
        say_what_failed(run, failed, code)
        config = config | {"exclude": failures}
    say_what_came_out(config, run, time.time() - begin, finished and (run / "index.html").is_file())
    return code


def keep_downloads_and_simulations(config: dict, run: Path, files: list[Path], errors: Path) -> None:
    """Record the downloads and simulations of an earlier version, and let Snakemake take them for up to date."""
    adopted = adoption.adopt(config, run, METADATA)
    if not adopted:
        return
    print(adoption.adopted_in_words(adopted, run), flush=True)
    outputs = [output for kept in adopted for output in kept.outputs]
    # --force: without metadata Snakemake has no reason to run a job, and writes none
    if run_snakemake(ROOT, files, "--quiet", "all", "--touch", "--force", *outputs, errors=errors):
        adoption.forget(adopted, run)
        raise InputError(f"They could not be kept, see {errors}. Nothing was changed.")


def closed(config: dict, run: Path, failures: dict[str, str], files: Sequence[Path]) -> bool:
    """Close a run in which jobs failed; return whether it has a first page.

    A second start of Snakemake with these places in `exclude` would write the same page where all other jobs have ended. Where
    Snakemake was killed or the disk is full, it would compute all that is left, for hours, and retry a batch whose job failed.
    """
    from sparsurf_study.report.closing import close_partial_run  # here, as it imports pandas and matplotlib

    closing = SimpleNamespace(rule="close_run", log=[run / "logs" / "close_run.log"])
    tables = [f"{run}/{name}/{batch}.parquet" for batch in batches_of(config) for name in BATCH_FOLDERS]
    if not all(Path(table).is_file() for table in tables):
        return False  # the job of a batch was killed, and nothing is known of its structures
    warnings_of = partial(collected_warnings, logs=run / "logs", jobs=[""])  # of all jobs
    try:
        with job(closing):
            finished = finished_parts(config, run, failures)
            libraries = ledger.libraries_of(run, [*tables, *map(str, finished.files)])
            origin = replace(origin_of(config, files), libraries=libraries)
            written = close_partial_run(config, run, failures, finished, tables, warnings_of, origin)
            ledger.replace_records(run, written)
            return bool(written)
    except SystemExit:  # with a sentence
        return False


def say_what_came_out(config: dict, run: Path, seconds: float, finished: bool) -> None:
    """Print the time, answers, number of warnings and first page of a run."""
    if not finished:
        print(f"\nThe results so far are in {run}/.")
        return
    print(f"\nTime      {seconds // 60:.0f} min {seconds % 60:.0f} s")
    in_batches = bool(batched_structures(config))
    if in_batches:
        failed = len(rows_of(run / "failures.csv"))
        print(f"Failed    {failed} of {len(config['proteins'])} structures, see {run / 'failures.csv'}")
    for answer in answers_of(run):
        print(f"Answer    {answer}")
    print(f"Warnings  {len(rows_of(run / 'warnings.csv'))} in {run / 'warnings.csv'}")
    broken = rows_of(run / "checks.csv")
    print(
        f"Checks    {pluralise(len(broken), 'contradiction') if broken else 'all results agree with one another'}"
    )
    for row in broken[:MAX_CONTRADICTIONS]:
        print(f"          {run / row['file']}: {row['sentence']}")
    first = (
        run / "verdict.html" if "paper" in config and (run / "verdict.html").is_file() else run / "index.html"
    )
    print(f"Look at   {first}")
    print(f"All       {run}/")


def answers_of(run: Path) -> list[str]:
    """Return what a run found, as its first page says it, from the description of its files."""
    crate = json.loads((run / "ro-crate-metadata.json").read_text(encoding="utf-8"))
    return next(entry["abstract"] for entry in crate["@graph"] if "abstract" in entry)


def rows_of(path: Path) -> list[dict]:
    """Return the rows of a CSV table; none where there is no such file."""
    if not path.is_file():
        return []
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
