"""Run a study and write its report: `python scripts/study.py [config.yaml] [--cluster slurm] [compare] [snakemake options]`.

Without a config, that is the default study, config.yaml, on all cores. A run that was stopped or killed continues where it was.
"""

import os
import re
import signal
import sys
import time
from functools import partial
from pathlib import Path

from sparsurf import InputError
from sparsurf.workflow import cluster, ending, results
from sparsurf.workflow.config import check, completed, with_comparison
from sparsurf.workflow.jobs import DISK
from sparsurf.workflow.needs import limit, memory_of_grid
from sparsurf.workflow.running import locked, plans_only, snakemake
from sparsurf.workflow.yaml_file import read_config

ROOT = Path(__file__).resolve().parents[1]
COMPARE = ROOT / "studies" / "compare.yaml"
HELP = {"-h", "--help"}
OF_CONFIG = {"--config", "-C", "--configfile", "--configfiles"}
ODD = re.compile(r"""[\s()'"&;$`\\|<>*?{}]""")  # means something to a shell
TELL = 2**30  # bytes of memory from which on a grid's need is told


def main(path_to_config="config.yaml", *options):
    """Run Snakemake, then its report; returns the exit code."""
    if path_to_config in HELP:
        print(__doc__.strip())
        return 0
    if path_to_config == "compare" or path_to_config.startswith("-"):
        path_to_config, options = str(ROOT / "config.yaml"), (path_to_config, *options)
    path, options = Path(path_to_config).resolve(), cluster.parted(options)
    os.chdir(ROOT)
    try:
        here = not {"--cluster", "--executor"} & set(options)
        options = (limit() if here else []) + cluster.replaced(options, ROOT / "profiles")
        refuse(options, path_to_config)
        config = checked_config(path, path_to_config, here, "compare" in options)
        folder = Path("results", config["run"])
        kept_up = (folder / "compare.csv").is_file() and config["sampling"]["run"] and config["proteins"]
        asked = read_config(path).get("compare")
        kept_up = kept_up and not isinstance(asked, bool) and "run" not in (asked or {})
        if kept_up and "compare" not in options:
            print(f"{folder} keeps up its comparison of samplers. `compare: {{run: false}}` ends that.")
        files = [path, *([COMPARE] if "compare" in options or kept_up else [])]
        options = [option for option in options if option != "compare"]
        with locked(ROOT):
            if plans_only(options):
                return snakemake(ROOT, files, *options)
            return study(config, folder, files, options)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        if error.errno not in DISK:
            raise
        where = error.filename or "results/"
        print(f"{where}: {error.strerror}. Free or repair the disk and run again.", file=sys.stderr)
        return 2
    except KeyboardInterrupt as stop:
        print("\nStopped. What was made stays; the same command continues where it was.", file=sys.stderr)
        return 128 + (stop.args[0] if stop.args else signal.SIGINT)


def refuse(options, given):
    """Refuse what Snakemake would take and a study cannot."""
    for option in options:
        if option.partition("=")[0] in OF_CONFIG:
            raise InputError(f"{option}: a study has one config file. Write into {given} what is to change.")
    if odd := ODD.search(sys.executable):
        raise InputError(
            f"{sys.executable}: Snakemake starts no job by a path with {odd[0]!r}. Move the checkout."
        )


def checked_config(path, given, here=True, compare=False):
    """The config in a file, checked before anything starts; says what memory a large grid will need."""
    if not path.is_file():
        raise InputError(f"There is no config file {given!r}; give one with CONFIG=my_config.yaml.")
    asked = with_comparison(read_config(path)) if compare else read_config(path)
    config = check(completed(asked, ROOT), home=ROOT, here=here)
    if (needed := memory_of_grid(config)) > TELL:
        print(f"The grid of one surface will need about {needed / 2**30:.1f} GB of memory.")
    return config


def study(config, folder, files, options):
    """Run what is out of date, then the report; where jobs fail, both of the rest. Returns the exit code."""
    begin, logs = time.time(), folder / results.LOGS
    ending.make_writable(logs)
    results.refuse_unknown(ROOT, logs, options)
    errors = logs / "snakemake.err"
    errors.unlink(missing_ok=True)  # of an earlier run
    for path in results.damaged(logs):
        print(f"{path} is not what the study wrote: it is regenerated.")
        Path(path).unlink()
    begun = cluster.watch if "--workflow-profile" in options else None
    run = partial(snakemake, ROOT, errors=errors, begun=begun)
    with ending.failed_jobs() as failed:
        code = rest = run(files, "--logger", "sparsurf", *options)
    if code:
        without = ending.left_out(config, folder, failed)
        if failed and ending.something_is_left(config, folder, without):
            files = [*files, ending.write_without(without, ROOT / ".snakemake" / "without.yaml")]
            print("What can be made without what failed:")
            rest = run(files, "--logger", "sparsurf", *options)
    if rest or not ending.is_complete(folder):
        return ending.incomplete(folder, code, failed)
    report = folder / ending.REPORT
    torn = ending.is_older(report, folder) and run(files, "--quiet", "all", "--report", report)
    return ending.summary(config, folder, code, failed, begin, torn)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
