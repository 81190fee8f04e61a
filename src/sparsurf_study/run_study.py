"""Run a study by Snakemake, close the run where jobs failed, and say what it found."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from sparsurf.errors import InputError
from sparsurf.files import open_closed_streams
from sparsurf_study import manifest
from sparsurf_study.config.check import check_config, read_config
from sparsurf_study.config.memory import memory_of_machine
from sparsurf_study.workflow.ends import answers_of_run, failed_places
from sparsurf_study.workflow.folders import default_config, home_of, study_folder
from sparsurf_study.workflow.signals import on_stop

PLANNING_OPTIONS = {"-n", "--dry-run", "--dryrun"}


def main(*arguments: str) -> int:
    """Run Snakemake, once more without what failed, and print the answers; return the exit code."""
    is_named = bool(arguments) and arguments[0] != "compare" and not arguments[0].startswith("-")
    options = [*arguments[is_named:]]
    open_closed_streams()
    try:
        root = study_folder()
        home, path = home_of(root), Path(arguments[0]).resolve() if is_named else default_config(root)
        os.chdir(root)  # paths of rules and results start there
        files = [path, *([home / "studies" / "compare.yaml"] if "compare" in options else [])]
        options = [option for option in options if option != "compare"]
        if "--workflow-profile" in options:  # Snakemake ignores one that is not there
            profile = "".join(options[options.index("--workflow-profile") + 1 :][:1])
            if profile != "none" and not any(Path(profile).glob("config*.yaml")):
                raise InputError(f"{profile} is not a folder with the config.yaml of a Snakemake profile.")
        else:  # jobs run side by side as far as the memory reaches
            options = [f"--resources=mem_mb={memory_of_machine() / 1e6:.0f}", *options]
        config = read_config(path)
        if len(files) > 1:
            section = config.get("compare")
            config |= {"compare": (section if isinstance(section, dict) else {}) | {"run": True}}
        config = check_config(config, [path], home, here="--workflow-profile" not in options)
        Path(".snakemake").mkdir(exist_ok=True)  # the first folder that it needs
        if PLANNING_OPTIONS & {*options}:
            return snakemake(files, *options)[0]
        return run_study(config, files, options, home)
    except InputError as error:
        print(error, file=sys.stderr)
    except OSError as error:
        print(
            f"{error.filename or 'results'}: {error.strerror}. Free or repair the disk and run again.",
            file=sys.stderr,
        )
    return 2


def run_study(config: dict, files: Sequence[Path], options: Sequence[str], home: Path) -> int:
    """Run what is out of date; where jobs fail, close the run without them. Return the exit code."""
    begin, run = time.time(), Path("results", config["run"])
    code, is_stopped = snakemake(files, *options)
    failed = failed_places(config, run, begin) if code == 1 and not is_stopped else {}
    if failed.keys() - config["exclude"].keys():
        without = {"exclude": config["exclude"] | failed}
        try:
            check_config(read_config(files[0]) | without, files[:1], home)
        except InputError:  # nothing is left
            return code
        path = run / "logs" / "exclude.json"  # a file, as an argument has 128 kB at most
        path.write_text(json.dumps(without), encoding="utf-8")
        snakemake([*files, path], *options)
    elif code == 0 and (sums := run / manifest.NAME).exists() and sums.stat().st_mtime < begin:
        print(answers_of_run(run, "paper" in config))  # nothing was to be done, and Snakemake says no more
    return code


def snakemake(files: Sequence[Path], *options: str) -> tuple[int, bool]:
    """Run Snakemake; return its exit code and whether a signal has stopped it.

    SIGTERM and SIGHUP are passed on to it. Its lock stays after a kill; `begin_run` holds one that does not.
    """
    plain = [sys.executable, "-m", "snakemake", "--nolock", "--logger", "sparsurf"]
    command = [*plain, "--configfile", *map(str, files), *options]
    process = subprocess.Popen(command)
    received: list[int] = []

    def pass_on(number: int, _: object) -> None:
        received.append(number)
        if number != signal.SIGINT:
            process.terminate()

    signal.signal(signal.SIGINT, pass_on)
    on_stop(pass_on)
    return process.wait(), bool(received)
