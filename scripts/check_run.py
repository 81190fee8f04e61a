"""Replay the records of a run and compare its files with the checksums in its crate: `check_run.py [config.yaml]`."""

import json
import os
import re
import sys
from contextlib import chdir
from pathlib import Path
from urllib.parse import unquote

from sparsurf.errors import InputError
from sparsurf.files import checksum_of_file, open_closed_streams
from sparsurf_study.workflow.code_version import code_of
from sparsurf_study.workflow.ledger import broken_links, read_records
from sparsurf_study.workflow.models import NAME_OF_FOLDER
from sparsurf_study.workflow.yaml_file import read_config, run_of_config

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "results"


def main(path_to_config: str = str(ROOT / "config.yaml")) -> int:
    """Print the first link from inputs to page that differs, and a sentence for each file that does; return the exit code."""
    open_closed_streams()
    try:
        run = RESULTS / name_of_run(path_to_config)
        with chdir(RESULTS.parent):  # where the paths of records start
            broken = first_broken_link(Path(RESULTS.name, run.name))
        checksums = checksums_in(run / "ro-crate-metadata.json")
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    place, wrong = Path(RESULTS.name, run.name), 0
    for name, expected in checksums.items():
        if problem := problem_of(run / name, expected):
            print(f"{place / name} {problem}")
            wrong += 1
    print(f"{len(checksums) - wrong} of {len(checksums)} files in {place}/ are as the run wrote them.")
    return int(wrong > 0 or broken)


def first_broken_link(run: Path) -> bool:
    """Print whether all results of a run follow from their inputs, or which is the first that does not; return the latter."""
    n_jobs = len(read_records(run))
    if not n_jobs:
        print(f"{run}/ has no records of its jobs; the next `make run` writes them.")
        return False
    codes = {code_of(path.stem) for path in (ROOT / "scripts").glob("*.py")}
    sentence = next(broken_links(run, codes), None)
    if sentence is None:
        print(f"The {n_jobs} jobs of {run}/ agree with their inputs, code and results.")
        return False
    print(f"The first link that differs: {sentence} `make run` computes again what follows from it.")
    return True


def name_of_run(path_to_config: str) -> str:
    """Return the name of the run of a config; raise InputError if it is no name of a folder in results/."""
    name = read_config(path_to_config).get("run", run_of_config(path_to_config))
    if not isinstance(name, str) or not re.fullmatch(NAME_OF_FOLDER, name):
        raise InputError(
            f"{path_to_config}: run is {name!r}; it must be a name of letters, digits, '_', '.' and '-'."
        )
    return name


def checksums_in(crate: Path) -> dict[str, str]:
    """Return the SHA-256 of each file that a crate lists."""
    try:
        graph = json.loads(crate.read_text(encoding="utf-8"))["@graph"]
        return {unquote(part["@id"]): part["sha256"] for part in graph if part["@type"] == "File"}
    except OSError:
        raise InputError(f"There is no {crate}: `make run` writes it at the end of a study.") from None
    except (ValueError, LookupError, TypeError):
        raise InputError(f"{crate} is damaged. Delete it, and `make run` writes it again.") from None


def problem_of(path: Path, expected: str) -> str:
    """Return what is wrong with a file and what to do; an empty string if it has the expected SHA-256."""
    try:
        if checksum_of_file(path) == expected:
            return ""
        return "differs from what the run wrote: `make run` writes it again."
    except FileNotFoundError:
        return "is missing: `make run` writes it again."
    except OSError as error:
        return f"cannot be read ({error.strerror}). Make it readable, or delete it, and `make run` writes it again."


if __name__ == "__main__":
    try:
        code = main(*sys.argv[1:])
        sys.stdout.flush()
    except BrokenPipeError:  # the reader, `head` say, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 1
    sys.exit(code)
