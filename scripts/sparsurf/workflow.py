"""What the Snakefile and the scripts share: logs of jobs, digests of code, names of conformations."""

import ast
import errno
import hashlib
import logging
import os
import re
import shutil
import sys
import time
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path

from sparsurf import InputError

SCRIPTS = Path(__file__).parents[1]
DISK = (
    errno.ENOSPC,
    errno.EDQUOT,
    errno.EACCES,
    errno.EROFS,
)  # a full disk, a folder that may not be written


@cache
def digest(script):
    """Digest of a script and of every library module that it imports, directly or not.

    Passed to the rules as a parameter, so that editing a module reruns exactly the steps that use it.
    """
    files, waiting = set(), [SCRIPTS / script]
    while waiting:
        path = waiting.pop()
        if path not in files:
            files.add(path)
            waiting += _imports(path)
    content = b"\0".join(path.name.encode() + path.read_bytes() for path in sorted(files))
    return hashlib.sha256(content).hexdigest()[:16]


def _imports(path):
    """Files of the library modules that a Python file imports."""
    names = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module == "sparsurf":
            names += ["__init__", *(alias.name for alias in node.names)]
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("sparsurf."):
            names.append(node.module.removeprefix("sparsurf."))
    candidates = (SCRIPTS / "sparsurf" / f"{name}.py" for name in names)
    return [candidate for candidate in candidates if candidate.is_file()]


@contextmanager
def job(snakemake):
    """The frame of a script's work.

    What it prints and logs goes to the rule's log. Its outputs are written under other names, given as a dict of
    paths by name, and take their own names when all are complete: a killed job leaves no half a file. An InputError,
    a full disk or a file that may not be written ends it with one sentence.
    """
    outputs = {name: _paths(value) for name, value in snakemake.output.items()}
    parts = {
        name: [path.parent / f".part-{snakemake.rule}" / path.name for path in paths]
        for name, paths in outputs.items()
    }
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
        except (InputError, OSError) as error:
            if isinstance(error, OSError) and error.errno not in DISK:
                raise
            sentence = error if isinstance(error, InputError) else _unwritten(error, snakemake)
            print(f"ERROR {sentence}", file=log)
            print(f"\n  {sentence}\n", file=sys.__stderr__, flush=True)
            sys.exit(1)
        finally:
            for folder in {part.parent for paths in parts.values() for part in paths}:
                shutil.rmtree(folder, ignore_errors=True)


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


def made(config, protein):
    """How the dots of a protein come about, in words."""
    own = config["proteins"][protein]
    if "surface" in own:
        return f"the dots of {Path(own['surface']).name}, as they are"
    rules = config["surface"]
    if rules["method"] == "dms":
        return "dots of the program DMS"
    return f"our own analytic dots, re-entrant part `{rules['reentrant']}`, density {rules['density']} (dots per Å^2)"


def one_of(names):
    """Regular expression for a wildcard that is one of `names`; without names it matches nothing."""
    return "|".join(map(re.escape, names)) or "(?!)"
