"""Compare the files of a run with its SHA256SUMS: `check_run.py [config.yaml]`."""

import sys
from pathlib import Path

from sparsurf.errors import InputError
from sparsurf_study.config.yaml_file import read_config, run_of_config
from sparsurf_study.manifest import differing, read_sums

ROOT = Path(__file__).resolve().parents[1]


def main(path_to_config: str = str(ROOT / "config.yaml")) -> int:
    """Print a sentence for each file that differs; return the exit code."""
    try:
        run = ROOT / "results" / str(read_config(path_to_config).get("run", run_of_config(path_to_config)))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    files, wrong = read_sums(run), [*differing(run)]
    if not files:
        print(
            f"There is no results/{run.name}/SHA256SUMS: the run is unfinished, or of version 5 or earlier. "
            "`make run` continues it, or computes it again, and writes that file at its end.",
            file=sys.stderr,
        )
        return 2
    for name, state in wrong:
        print(f"results/{run.name}/{name} is {state}: `make run` computes it again.")
    print(
        f"{len(files) - len(wrong)} of {len(files)} files in results/{run.name}/ are as the run wrote them."
    )
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
