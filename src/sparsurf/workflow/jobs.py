"""What the Snakefile and the scripts share: the frame of a job, how it tells its progress, names of conformations."""

import errno
import inspect
import logging
import os
import re
import resource
import sys
import time
import traceback
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from pathlib import Path

from sparsurf import InputError
from sparsurf.workflow.job_logs import ERROR, PROGRESS, USED
from sparsurf.workflow.results import damaged, made

# A full disk, a folder that may not be written
DISK = (errno.ENOSPC, errno.EDQUOT, errno.EACCES, errno.EROFS)
# Wildcards that say what a job is about; a stage or a file is none
NAMED = ("protein", "conformation", "pair", "site")


def run(main, snakemake):
    """Do a script's work: call its `main` with what it asks for by name.

    A `main` may ask for `inputs` and `outputs` (paths by their names in the rule), for any of the rule's params,
    for `name` (protein, protein/conformation, or pair) and for `threads`; what has a default, where the rule gives it.
    """
    named = (value for key, value in snakemake.wildcards.items() if key in NAMED)
    known = {"name": "/".join(named), "threads": snakemake.threads} | dict(snakemake.params.items())
    known |= {"inputs": dict(snakemake.input.items()), "outputs": dict(snakemake.output.items())}
    with job(snakemake):
        asked = inspect.signature(main).parameters.values()
        main(
            **{
                each.name: known[each.name]
                for each in asked
                if each.name in known or each.default is each.empty
            }
        )


@contextmanager
def job(snakemake):
    """The frame of a script's work: what it prints and logs goes to the rule's log, an error ends it with one sentence.

    Of an error that is no user's mistake the log has the traceback. Outputs of a job that failed or was killed are Snakemake's to
    remove; of the others the log holds the checksums.
    """
    try:
        log = open(snakemake.log[0], "w", encoding="utf-8", buffering=1)  # noqa: SIM115, closed in the end
    except OSError as error:
        sys.exit(f"\n  {_sentence(error, snakemake)}\n")
    with redirect_stdout(log), redirect_stderr(log):
        logging.basicConfig(stream=log, level=logging.INFO, format="%(levelname)s %(message)s", force=True)
        logging.captureWarnings(True)
        try:
            if found := damaged(Path(snakemake.log[0]), snakemake.input):
                raise InputError(f"{found[0]} is not what the study wrote. Run again: it is regenerated.")
            yield
            print(*made(snakemake.output), used(snakemake.input), sep="\n", file=log)
        except Exception as error:
            sentence = _sentence(error, snakemake)
            with suppress(OSError):  # the log may lie on the same full disk
                print(f"{ERROR}{sentence}", file=log)
            print(f"\n  {sentence}\n", file=sys.__stderr__, flush=True)
            sys.exit(1)
        finally:
            with suppress(OSError):
                log.close()


def _sentence(error, snakemake):
    """What to tell a user about an error."""
    if isinstance(error, InputError):
        return error
    if isinstance(error, OSError) and error.errno in DISK:
        what = error.filename or f"the outputs of {snakemake.rule}"
        return f"{what}: {error.strerror}. Free or repair the disk and run again: what is made stays."
    traceback.print_exc()
    kind = f"{type(error).__name__}: {error}"
    return (
        f"A defect of this program ({kind}). Please report it with {snakemake.log[0]}; what was made stays."
    )


def used(inputs):
    """A line on what a job has used, with the processes that it started: MB of memory, s of CPU time, MB of input."""
    given = sum(os.path.getsize(path) for path in inputs if os.path.isfile(path)) / 1e6
    own, others = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    megabytes = (own.ru_maxrss + others.ru_maxrss) * (1 if sys.platform == "darwin" else 1024) / 1e6
    seconds = sum(each.ru_utime + each.ru_stime for each in (own, others))
    return f"{USED}{megabytes:.0f} MB {seconds:.1f} s for {given:.2f} MB"


def use_this_library():
    """Let the processes of jobs import this library, whatever other version is installed."""
    paths = [str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH")]
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, paths))


def in_one_environment(workflow, home):
    """Give every rule of the Snakefile in `home` that runs a script the environment of envs/study.yaml."""
    for rule in workflow.rules:  # others are of a workflow that imports this one
        if rule.script and Path(rule.snakefile).is_relative_to(home):
            rule.conda_env = str(home / "envs" / "study.yaml")


def reporter(what, unit="samplings", every=2.0):
    """Function (done, of) that tells the log how far a long step is, every few seconds."""
    begin = last = time.monotonic()

    def report(done, of):
        nonlocal last
        now = time.monotonic()
        if now - last >= every or done >= of:
            last = now
            left = (now - begin) * (of - done) / max(done, 1)
            print(
                f"{PROGRESS}{what}: {done} of {of} {unit}, {now - begin:.0f} s, {left:.0f} s to go",
                file=sys.stderr,
            )

    return report


def conformations_of(path_to_frames):
    """Names in the first column of frames.csv, in its order."""
    with open(path_to_frames, encoding="utf-8") as stream:
        return [line.split(",")[0] for line in stream.read().splitlines()[1:]]


def plain(place):
    """A place of a study without zeros before the number of a conformation: p/f0007 is p/f7."""
    return re.sub(r"/([cf])0*(\d+)(?=/|$)", r"/\1\2", place)


def one_of(names):
    """Regular expression for a wildcard that is one of `names`; without names it matches nothing."""
    return "|".join(map(re.escape, names)) or "(?!)"
