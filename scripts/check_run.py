"""Compare the files of a run with the checksums in its crate: `python scripts/check_run.py [config.yaml]`."""

import json
import os
import re
import sys
from pathlib import Path
from urllib.parse import unquote

from sparsurf.errors import InputError
from sparsurf.files import checksum, open_closed_streams
from sparsurf_study.workflow.models import NAME_OF_FOLDER, Config
from sparsurf_study.workflow.yaml_file import read_config

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "results"


def main(path_to_config: str = str(ROOT / "config.yaml")) -> int:
    """Print a sentence for each file that differs or is missing; return the exit code."""
    open_closed_streams()
    try:
        run = RESULTS / name_of_run(path_to_config)
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
    return int(wrong > 0)


def name_of_run(path_to_config: str) -> str:
    """Return the name of the run of a config; raise InputError if it is no name of a folder in results/."""
    name = read_config(path_to_config).get("run", Config.model_fields["run"].default)
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
        if checksum(path) == expected:
            return ""
        return "differs from what the run wrote. Delete it, and `make run` writes it again."
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
