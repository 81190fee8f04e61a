"""Kill a study, or a call of the library, within a write, and run it again.

`sitecustomize.py` on PYTHONPATH puts an audit hook into each process: what is killed has no code for it.
"""

import json
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import NamedTuple

import yaml

import warm_python
from conftest import ROOT
from peptides import peptide, write
from small_study import SEQUENCE, SETTINGS

VARIABLE = "KILL"
HOOK = """
import json, os, re, signal, sys, time

def arm(plan):
    here, busy = os.getcwd(), []
    path_of = lambda name: os.path.abspath(os.fsdecode(name)) if isinstance(name, (str, bytes, os.PathLike)) else ""
    with open(os.path.join(plan["notes"], f"{os.getpid()}.pid"), "w") as note:
        note.write("snakemake" if "snakemake" in [*sys.argv, *sys.orig_argv] else "job")

    def is_the_one(path):
        if not re.search(plan["path"], path):
            return False
        seen = os.path.join(plan["notes"], "seen")
        with open(seen, "a") as note:
            note.write(path + chr(10))
        with open(seen) as note:
            return len(note.readlines()) == plan["nth"]

    def kill(whom):
        for name in os.listdir(plan["notes"]):
            number, _, suffix = name.partition(".")
            if suffix == "pid" and int(number) != os.getpid():
                with open(os.path.join(plan["notes"], name)) as note:
                    role = note.read()
                if whom == "tree" or (whom, role) == ("snakemake", "snakemake"):
                    try:
                        os.kill(int(number), signal.SIGKILL)
                    except ProcessLookupError:
                        pass
        if whom == "tree":
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(plan["seconds"])

    def hook(event, arguments):
        if busy or event != {"write": "open", "rename": "os.rename"}[plan["moment"]]:
            return
        if event == "open" and not (isinstance(arguments[2], int) and arguments[2] & (os.O_WRONLY | os.O_RDWR)):
            return
        busy.append(event)
        path = path_of(arguments[event == "os.rename"])
        if is_the_one(path):
            if event == "open" and plan["whom"] in ("job", "tree"):
                known = path.replace(here, plan["known"], 1)
                half = b"hal"
                if path.startswith(here) and os.path.isfile(known):
                    with open(known, "rb") as stream:
                        half = stream.read()
                    half = half[: len(half) // 2]
                with open(path, "wb") as stream:
                    stream.write(half)
            if plan["whom"] == "job":
                os.kill(os.getpid(), signal.SIGKILL)
            kill(plan["whom"])
        busy.clear()

    sys.addaudithook(hook)

if os.environ.get("KILL"):
    arm(json.loads(os.environ["KILL"]))
"""
# What two undisturbed runs differ in
VOLATILE = re.compile(
    rb'\d+ min|\d+(\.\d+)? s\b|20\d\d-\d\d-\d\d|"time": [\d.]+|[0-9a-f]{64}|"contentSize": "\d+"'
)


class Kill(NamedTuple):
    """A kill: `whom`, at the n-th write, or renaming, of a file whose path a pattern matches."""

    path: str
    whom: str = "tree"  # or job, snakemake, nobody
    moment: str = "write"  # or rename
    nth: int = 1
    seconds: float = 0.0  # that the job of a killed Snakemake waits there, so that it meets the next run


def checkout(folder: Path) -> Path:
    """Make a checkout in a folder with two studies of peptides: one.yaml with a grid, two.yaml with frames and a pair."""
    folder.mkdir()
    for name in ("src", "rules", "envs", "data", "profiles", "Snakefile", "config.yaml", "studies", ".cache"):
        (folder / name).symlink_to(ROOT / name)
    shutil.copytree(ROOT / "scripts", folder / "scripts", ignore=shutil.ignore_patterns("__pycache__"))
    models = [peptide(SEQUENCE, origin=(0, y, 0)) for y in (0, 1)]
    write(folder / "one.pdb", models[0] + "END\n")
    text = "".join(f"MODEL {k:8}\n{model}ENDMDL\n" for k, model in enumerate(models, 1))
    write(folder / "two.pdb", text + "END\n")
    still = {"frames": {}, "proteins": {"one": {"structure": "one.pdb"}}}
    grid = {"alpha": [1.0], "beta": [0.4], "gamma": [6], "delta": [0]}
    (folder / "one.yaml").write_text(yaml.safe_dump(SETTINGS | still | {"run": "one", "sampling": grid}))
    proteins = {name: {"structure": f"{name}.pdb"} for name in ("one", "two")}
    moving = {"run": "two", "sampling": False, "frames": {"selection": "all"}, "proteins": proteins}
    moving |= {"pairs": {"both": {"proteins": ["one", "two"]}}}
    (folder / "two.yaml").write_text(yaml.safe_dump(SETTINGS | moving))
    return folder


def run(
    command: list, folder: Path, kill: Kill | None = None, known: Path | None = None, **variables: str
) -> subprocess.CompletedProcess:
    """Run a command of Python in a folder, undisturbed or killed; `known` is a folder with what it writes, whole."""
    with tempfile.TemporaryDirectory() as own:
        Path(own, "sitecustomize.py").write_text(HOOK)
        environment = os.environ | {"PYTHONPATH": f"{own}{os.pathsep}{ROOT / 'src'}"} | variables
        if kill:
            plan = kill._asdict() | {"notes": own, "known": str(known or folder)}
            environment[VARIABLE] = json.dumps(plan)
        call = [warm_python.interpreter(), *map(str, command)]
        # files, as the job of a killed Snakemake would keep a pipe open
        texts = [Path(own, name) for name in ("stdout", "stderr")]
        with texts[0].open("w") as stdout, texts[1].open("w") as stderr:
            streams = {"stdout": stdout, "stderr": stderr}
            process = subprocess.run(call, cwd=folder, env=environment, check=False, timeout=600, **streams)
        process.stdout, process.stderr = (path.read_text() for path in texts)
        seen = Path(own, "seen")
        assert kill is None or (seen.is_file() and len(seen.read_text().splitlines()) >= kill.nth), process
        return process


def study(name: str, *options: str) -> list:
    """Return the command of a study of a checkout, as `make run` calls it."""
    return ["-m", "sparsurf_study", "run", f"{name}.yaml", "--cores", "2", *options]


def content(folder: Path) -> dict[str, bytes]:
    """Return the results of a run, hidden files too, without logs and without times."""
    files = [path for path in folder.rglob("*") if path.is_file() and folder / "logs" not in path.parents]
    return {
        path.relative_to(folder).as_posix(): VOLATILE.sub(b"", path.read_bytes())
        if path.suffix in (".html", ".json")
        else path.read_bytes()
        for path in files
        if path.name != "SHA256SUMS"  # of pages with times
    }
