"""Run the script of one job in this process, so that a debugger stops in it: `python -m sparsurf_study.debug OUTPUT`.

pypsa-eur's mock_snakemake is the model: https://github.com/PyPSA/pypsa-eur, scripts/_helpers.py.
"""

import argparse
import bdb
import os
import pdb
import runpy
import shutil
import sys
from collections.abc import Iterable, Sequence
from contextlib import redirect_stdout
from pathlib import Path
from types import FrameType, SimpleNamespace
from typing import Any

from snakemake.api import SnakemakeApi
from snakemake.exceptions import MissingRuleException, RuleException, WorkflowError
from snakemake.io import is_callable
from snakemake.settings.types import ConfigSettings, DAGSettings, OutputSettings, Quietness, ResourceSettings

from sparsurf_study.workflow.jobs import RAISE
from sparsurf.errors import InputError
from sparsurf.files import shorten
from sparsurf.threads import available_cores
from sparsurf_study.config.conformations import first_column

STUDY_ROOT = Path(__file__).parents[2]  # The folder of the checkout.


def main() -> int:
    """Run the job of the output that the command line names; return the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m sparsurf_study.debug", description=__doc__.split(":")[0] + "."
    )
    parser.add_argument(
        "output", help="a file or folder that a rule writes, such as results/default/tdp43/c1/grid.csv"
    )
    parser.add_argument(
        "--configfile",
        nargs="+",
        type=Path,
        default=[],
        help="config of the study, by default that of the default study",
    )
    args = parser.parse_args()
    try:
        job = job_of(args.output, args.configfile)
        print(f"Running {script_of(job).relative_to(STUDY_ROOT)}; its log is {job.log[0]}.", flush=True)
        run_job(job)
    except InputError as error:
        print(f"\n  {error}\n", file=sys.stderr)
        return 1
    except Exception as error:
        if sys.gettrace() or isinstance(error, bdb.BdbQuit):  # a debugger shows where it was raised
            raise
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        print(
            f"\n  {shorten(args.output)}: {script_of(job).name} failed ({reason}). Its traceback is in {job.log[0]}. "
            "If the inputs of this job are older than the code, run the study up to there first.\n",
            file=sys.stderr,
        )
        return 1
    print(f"Wrote {', '.join(map(str, job.output))}.")
    return 0


def job_of(output: str, configs: Sequence[Path]) -> Any:
    """Return Snakemake's job that writes an output of a study whose results lie in the current folder."""
    output = os.path.relpath(output)
    if not (STUDY_ROOT / "Snakefile").is_file():
        raise InputError("The installed package has no scripts of rules: run this module of a clone.")
    for path in configs:
        if not path.is_file():
            raise InputError(f"{shorten(path)} does not exist: check the path of the config.")
    quiet = OutputSettings(quiet={Quietness.ALL}, enable_file_logging=False)
    with SnakemakeApi(quiet) as api, open(os.devnull, "w", encoding="utf-8") as nowhere:
        workflow = api.workflow(
            resource_settings=ResourceSettings(cores=available_cores()),
            config_settings=ConfigSettings(configfiles=[path.absolute() for path in configs]),
            snakefile=STUDY_ROOT / "Snakefile",
        )
        try:
            with redirect_stdout(
                nowhere
            ):  # the call that builds the graph and leaves it is the one that prints it
                workflow.dag(DAGSettings(targets={output})).printfilegraph()
        except MissingRuleException:
            raise InputError(
                f"No rule of this study writes {shorten(output)}; check the path, and name the config of its study "
                "by --configfile."
            ) from None
        except (RuleException, WorkflowError) as error:
            reason = " ".join(str(error).split())
            raise InputError(f"{shorten(output)} cannot be made: {reason}") from None
        for job in workflow._workflow.dag.jobs:
            if output in map(str, job.output) and job.rule.script:
                _require_inputs(output, job)
                return job
    raise InputError(
        f"{shorten(output)} is not written by the script of a rule; name a file that a script writes."
    )


def _require_inputs(output: str, job: Any) -> None:
    """Raise InputError for inputs that are missing, or known only when a checkpoint has run."""
    _require_conformation(output, job)
    missing = [str(path) for path in job.input if not os.path.exists(path)]
    if missing:
        further = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
        raise InputError(
            f"{shorten(output)} is made from {shorten(missing[0])}{further}, which does not exist; "
            "run the study up to there first."
        )
    fixed = {str(path.apply_wildcards(job.wildcards)) for path in job.rule.input if not is_callable(path)}
    for other in job.dag.dependencies[job]:
        # Snakemake gives a job the outputs of a checkpoint that it runs again, in place of the inputs that follow from it
        stand_ins = {*map(str, job.input)} & {*map(str, other.output)} - fixed
        is_pending = job.dag.needrun(other) or not all(map(os.path.exists, other.output))
        if other.is_checkpoint and is_pending and stand_ins:
            raise InputError(
                f"{shorten(output)} follows from the conformations in {shorten(min(stand_ins))}, which are chosen again, "
                "since their code, config or files have changed; run the study up to there first."
            )


def _require_conformation(output: str, job: Any) -> None:
    """Raise InputError for a conformation that the table of the frames does not name, such as f0 in place of f00."""
    if not {"protein", "conformation"} <= {*job.wildcards.keys()}:
        return
    protein, conformation = job.wildcards.protein, job.wildcards.conformation
    frames = Path(f"results/{job.wildcards.run}/{protein}/frames.csv")
    if frames.is_file() and conformation not in (listed := first_column(frames)):
        raise InputError(
            f"{shorten(output)}: {protein} has no conformation {conformation}; it has {shorten(', '.join(listed))}."
        )


def script_of(job: Any) -> Path:
    """Return the script of a job in this checkout."""
    return STUDY_ROOT / "scripts" / Path(job.rule.script).name


def run_job(job: Any) -> None:
    """Run the script of a job as Snakemake does: its former outputs are deleted first, and half of them if it fails."""
    files = {name: getattr(job, name)._plainstrings() for name in ("input", "output", "log")}
    given = SimpleNamespace(
        **files,
        params=job.params,
        wildcards=job.wildcards,
        threads=job.threads,
        resources=job.resources,
        config=job.rule.workflow.config,
        rule=job.rule.name,
    )
    _remove(job.output)
    for path in (*job.output, *job.log):
        Path(path).parent.mkdir(parents=True, exist_ok=True)
    try:
        run_script(script_of(job), given)
    except BaseException:  # also a debugger that is left
        _remove(job.output)
        raise


def _remove(paths: Iterable[str]) -> None:
    """Delete files and folders, where they exist."""
    for path in map(Path, paths):
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)


def run_script(script: Path, snakemake: Any) -> None:
    """Run a script of a rule in this process; its error is raised once it stands in the log."""
    hook = sys.breakpointhook
    setattr(snakemake, RAISE, True)
    sys.breakpointhook = _stop_here
    try:
        runpy.run_path(str(script), {"snakemake": snakemake})
    finally:
        sys.breakpointhook = hook


def _stop_here(*_: Any, **__: Any) -> None:
    """Open the debugger at the terminal: what a job prints goes to its log, and so would the prompt."""
    frame: FrameType | None = sys._getframe(1)
    pdb.Pdb(stdin=sys.__stdin__, stdout=sys.__stdout__).set_trace(frame)


if __name__ == "__main__":
    sys.exit(main())
