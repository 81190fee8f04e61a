"""Compare the files of a run with its SHA256SUMS: `check_run.py [config.yaml]`."""

import sys
from pathlib import Path

from sparsurf.errors import InputError
from sparsurf_study.manifest import differing, read_sums
from sparsurf_study.workflow.yaml_file import read_config, run_of_config

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
        print(f"There is no {run}/SHA256SUMS: `make run` writes it at the end of a study.", file=sys.stderr)
        return 2
    for name, state in wrong:
        print(f"results/{run.name}/{name} is {state}: `make run` computes it again.")
    print(
        f"{len(files) - len(wrong)} of {len(files)} files in results/{run.name}/ are as the run wrote them."
    )
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
