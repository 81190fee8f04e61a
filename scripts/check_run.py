"""Compare the files of a run with the checksums in its crate: `python scripts/check_run.py [config.yaml]`."""

import json
import sys
from pathlib import Path
from urllib.parse import unquote

from sparsurf.errors import InputError
from sparsurf.files import checksum, open_closed_streams
from sparsurf_study.workflow.models import Config
from sparsurf_study.workflow.yaml_file import read_config

RESULTS = Path(__file__).resolve().parents[1] / "results"


def main(path_to_config: str = "config.yaml") -> int:
    """Print a sentence for each file that differs or is missing; return the exit code."""
    open_closed_streams()
    try:
        run = RESULTS / str(read_config(path_to_config).get("run", Config.model_fields["run"].default))
        checksums = checksums_in(run / "ro-crate-metadata.json")
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    place, wrong = Path(RESULTS.name, run.name), 0
    for name, expected in checksums.items():
        if problem := problem_of(run / name, expected):
            print(f"{place / name} {problem}. Delete it, and `make run` writes it again.")
            wrong += 1
    print(f"{len(checksums) - wrong} of {len(checksums)} files in {place}/ are as the run wrote them.")
    return int(wrong > 0)


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
    """Return what is wrong with a file; an empty string if it has the expected SHA-256."""
    try:
        return "" if checksum(path) == expected else "differs from what the run wrote"
    except FileNotFoundError:
        return "is missing"
    except OSError as error:
        return f"cannot be read ({error.strerror})"


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
