"""What the Snakefile and the scripts share: the frame of a job, its log, names of conformations."""

import errno
import inspect
import logging
import os
import re
import resource
import shutil
import sys
import time
import traceback
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path

from sparsurf import InputError

DISK = (
    errno.ENOSPC,
    errno.EDQUOT,
    errno.EACCES,
    errno.EROFS,
)  # a full disk, a folder that may not be written
# Wildcards that say what a job is about; a stage or a file is none
NAMED = ("protein", "conformation", "pair")
WHOLE = ("protein", "pair")  # those of them that have a mark of their own
COMPLETE = ".complete"  # in the folder of a protein or pair of which everything is there


def run(main, snakemake):
    """Do a script's work: call its `main` with what it asks for by name.

    A `main` may ask for `inputs` and `outputs` (paths by their names in the rule), for any of the rule's params,
    for `name` (protein, protein/conformation, or pair) and for `threads`; what has a default, where the rule gives it.
    """
    named = (value for key, value in snakemake.wildcards.items() if key in NAMED)
    known = {"name": "/".join(named), "threads": snakemake.threads}
    known |= {"inputs": dict(snakemake.input.items())} | dict(snakemake.params.items())
    with job(snakemake) as outputs:
        known["outputs"] = outputs
        asked = inspect.signature(main).parameters.values()
        main(
            **{
                each.name: known[each.name]
                for each in asked
                if each.name in known or each.default is each.empty
            }
        )


def use_this_library():
    """Let the processes of jobs import this library, whatever other version is installed."""
    paths = [str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH")]
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, paths))


@contextmanager
def job(snakemake):
    """The frame of a script's work.

    What it prints and logs goes to the rule's log. Its outputs are written under other names, given as a dict of
    paths by name, and take their own names when all are complete: a killed job leaves no half a file, and its protein or
    pair counts as unfinished until everything is there again. An error ends it with one sentence; of one that is no user's
    mistake the log has the traceback.
    """
    outputs = {name: _paths(value) for name, value in snakemake.output.items()}
    marked = [value for key, value in snakemake.wildcards.items() if key in WHOLE]
    for folder in {folder for paths in outputs.values() for path in paths for folder in path.parents}:
        if folder.name in marked:
            (folder / COMPLETE).unlink(missing_ok=True)
    own = f".part-{Path(snakemake.log[0]).stem}"  # not the rule's: several jobs of one may write into one folder
    parts = {name: [path.parent / own / path.name for path in paths] for name, paths in outputs.items()}
    for folder in {part.parent for paths in parts.values() for part in paths}:
        shutil.rmtree(folder, ignore_errors=True)
    with (
        open(snakemake.log[0], "w", encoding="utf-8", buffering=1) as log,
        redirect_stdout(log),
        redirect_stderr(log),
    ):
        logging.basicConfig(stream=log, level=logging.INFO, format="%(levelname)s %(message)s", force=True)
        logging.captureWarnings(True)
        try:
            for part in (part for paths in parts.values() for part in paths):
                part.parent.mkdir(parents=True, exist_ok=True)
            yield {
                name: [str(part) for part in paths] if len(paths) > 1 else str(paths[0])
                for name, paths in parts.items()
            }
            for name, paths in outputs.items():
                for part, path in zip(parts[name], paths, strict=True):
                    os.replace(part, path)
            print(used(snakemake.input), file=log)
        except Exception as error:
            if isinstance(error, InputError):
                sentence = error
            elif isinstance(error, OSError) and error.errno in DISK:
                sentence = _unwritten(error, snakemake)
            else:
                traceback.print_exc(file=log)
                sentence = (
                    f"a defect of this program ({type(error).__name__}: {error}): please report it with "
                    f"{snakemake.log[0]}; what was made before stays."
                )
            print(f"ERROR {sentence}", file=log)
            print(f"\n  {sentence}\n", file=sys.__stderr__, flush=True)
            sys.exit(1)
        finally:
            for folder in {part.parent for paths in parts.values() for part in paths}:
                shutil.rmtree(folder, ignore_errors=True)


def used(inputs):
    """A line on what a job has used, with the processes that it started: MB of memory, s of CPU time, MB of input."""
    given = sum(os.path.getsize(path) for path in inputs if os.path.isfile(path)) / 1e6
    own, others = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    megabytes = (own.ru_maxrss + others.ru_maxrss) * (1 if sys.platform == "darwin" else 1024) / 1e6
    seconds = sum(each.ru_utime + each.ru_stime for each in (own, others))
    return f"USED {megabytes:.0f} MB {seconds:.1f} s for {given:.2f} MB"


def _unwritten(error, snakemake):
    """What could not be written, and why."""
    what = error.filename or f"the outputs of {snakemake.rule}"
    return f"{what}: {error.strerror}; mend that and run again, what was made before stays."


def _paths(value):
    return [Path(path) for path in ([value] if isinstance(value, str) else value)]


def reporter(what, unit="samplings", every=5.0):
    """Function (done, of) that tells the log and the terminal how far a long step is, every few seconds."""
    begin = last = time.monotonic()

    def report(done, of):
        nonlocal last
        now = time.monotonic()
        if now - last >= every or done >= of:
            last = now
            left = (now - begin) * (of - done) / max(done, 1)
            line = f"{what}: {done} of {of} {unit}, {now - begin:.0f} s, {left:.0f} s to go"
            for stream in (sys.stderr, sys.__stderr__):
                print(line, file=stream, flush=True)

    return report


def conformations_of(path_to_frames):
    """Names in the first column of frames.csv, in its order."""
    with open(path_to_frames, encoding="utf-8") as stream:
        return [line.split(",")[0] for line in stream.read().splitlines()[1:]]


def one_of(names):
    """Regular expression for a wildcard that is one of `names`; without names it matches nothing."""
    return "|".join(map(re.escape, names)) or "(?!)"
