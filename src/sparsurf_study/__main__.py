"""Run a study, or compare its results with their checksums.

python -m sparsurf_study run [config.yaml] [compare] [Snakemake's options]
python -m sparsurf_study check [config.yaml]

The config is that of the default study if none is named.
"""

import sys

from sparsurf_study import check_run, run_study

MAINS = {"run": run_study.main, "check": check_run.main}


def main() -> int:
    """Run the command that the command line names; return the exit code."""
    name, *arguments = sys.argv[1:] or ["--help"]
    if name in MAINS and not {"-h", "--help"} & {*arguments}:
        return MAINS[name](*arguments)
    print(__doc__, file=sys.stdout if "-h" in name else sys.stderr)
    return 0 if "-h" in name else 2


if __name__ == "__main__":
    sys.exit(main())
