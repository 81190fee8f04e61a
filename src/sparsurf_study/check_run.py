"""Compare the files of a run with its SHA256SUMS."""

import sys

from sparsurf.errors import InputError
from sparsurf_study.config.yaml_file import read_config, run_of_config
from sparsurf_study.manifest import differing, read_sums
from sparsurf_study.workflow.folders import default_config, study_folder


def main(*arguments: str) -> int:
    """Print a sentence for each file that differs; return the exit code."""
    try:
        root = study_folder()
        path, *_ = *arguments, default_config(root)
        run = root / "results" / str(read_config(path).get("run", run_of_config(path)))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    files, wrong = read_sums(run), [*differing(run)]
    if not files:
        print(
            f"There is no results/{run.name}/SHA256SUMS: the run is unfinished, or of version 5 or earlier. "
            "The next run continues it, or computes it again, and writes that file at its end.",
            file=sys.stderr,
        )
        return 2
    for name, state in wrong:
        print(f"results/{run.name}/{name} is {state}: the next run computes it again.")
    print(
        f"{len(files) - len(wrong)} of {len(files)} files in results/{run.name}/ are as the run wrote them."
    )
    return int(bool(wrong))
