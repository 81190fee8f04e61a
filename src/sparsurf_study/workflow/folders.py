"""The folder in which a study runs, and the one with the default study."""

import fcntl
import os
from pathlib import Path

from sparsurf.errors import InputError

# The package: where it was installed from a wheel, it has config.yaml, data/ and studies/compare.yaml of the default study
INSTALLED = Path(__file__).parents[1]
CHECKOUT = INSTALLED.parents[1]


def study_folder() -> Path:
    """Return the current folder if a workflow lies in it, else the checkout of this package; paths of a study start there."""
    for folder in (Path.cwd(), CHECKOUT):
        if any((folder / name).is_file() for name in ("Snakefile", "workflow/Snakefile")):
            return folder
    raise InputError("There is no Snakefile here: type this command in the folder of the deployed workflow.")


def default_config(folder: Path) -> Path:
    """Return the config that a study has if none is named."""
    path = folder / "config.yaml"
    return path if path.is_file() else folder / "config" / path.name


def home_of(folder: Path) -> Path:
    """Return where the default study lies: in a checkout itself, for a deployed workflow in the installed package."""
    return folder if (folder / "src" / "sparsurf_study").is_dir() else INSTALLED


def hold_folder() -> bool:
    """Hold the system's lock of the current folder until this process ends; return False if another study holds it."""
    path = Path(".snakemake", "study.lock")
    path.parent.mkdir(exist_ok=True)
    try:
        fcntl.flock(os.open(path, os.O_RDWR | os.O_CREAT, 0o666), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
