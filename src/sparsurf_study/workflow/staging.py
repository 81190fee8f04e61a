"""Outputs of a job that appear together: written into a folder beside their places, and renamed at its end.

Snakemake and the ledger find what a kill has left half-written. Where Snakemake alone is killed, its jobs go on beside those of
the next run: without a folder for each process, both would write one file, and a job of the next run would read half of it.
"""

import copy
import glob
import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sparsurf.errors import InputError
from sparsurf_study.workflow.ledger import FOLDER


class Staging:
    """The outputs of a job, where this process writes them; `name` differs from those of all other jobs in the same folders."""

    def __init__(self, outputs: Any, name: str) -> None:
        self.final = [str(path) for path in outputs]
        self.name = name
        self.folders = [*dict.fromkeys(self.place_of(path).parent for path in self.final)]
        self.outputs = replaced(outputs, lambda path: str(self.place_of(path)))

    def place_of(self, path: str) -> Path:
        """Return where the job writes an output: a file of the same name."""
        return Path(path).parent / f".{self.name}.{os.getpid()}.new" / Path(path).name

    def begin(self) -> None:
        """Create the folders, without those of an earlier process of this job."""
        for parent in {Path(path).parent for path in self.final}:
            for folder in parent.glob(f".{glob.escape(self.name)}.[0-9]*.new"):
                shutil.rmtree(folder, ignore_errors=True)
        for folder in self.folders:
            folder.mkdir(parents=True, exist_ok=True)

    def written(self) -> dict[str, Path]:
        """Return where the outputs that the job has written lie, by final path; InputError if another process took over."""
        if not all(folder.is_dir() for folder in self.folders):
            raise InputError("The next run computes this job again.")
        places = {path: self.place_of(path) for path in self.final}
        return {path: place for path, place in places.items() if place.exists()}

    def publish(self) -> None:
        """Give the outputs their final names; of an earlier job, nothing stays."""
        for path, place in self.written().items():
            # `os.replace` puts a file in place of another in one step, but a folder only in place of an empty one
            if place.is_dir() and os.path.isdir(path):
                shutil.rmtree(path)
            os.replace(place, path)

    def discard(self) -> None:
        """Remove the folders with what is left in them."""
        for folder in self.folders:
            shutil.rmtree(folder, ignore_errors=True)


def replaced(paths: Any, new_path: Callable[[str], str]) -> Any:
    """Return a copy of named outputs of Snakemake with other paths; a new list of its class would import all of Snakemake."""
    clone = copy.copy(paths)
    clone[:] = map(new_path, paths)
    for name, (first, end) in paths._get_names():
        if end is None:
            setattr(clone, name, clone[first])
        else:
            setattr(clone, name, part := copy.copy(getattr(paths, name)))
            part[:] = clone[first:end]
    return clone


def with_final_names(text: str) -> str:
    """Return a sentence with the final paths of the outputs that it names."""
    return re.sub(r"/\.[^/\s]+\.new(?=/)", "", text)


def remove_leftovers(run: Path) -> None:
    """Remove what killed jobs left beside the places of their outputs and of their records, in the folder of a run."""
    for folder, folders, _ in os.walk(run):
        for left in [name for name in folders if name.startswith(".") and name.endswith(".new")]:
            shutil.rmtree(Path(folder, left), ignore_errors=True)
        folders[:] = [name for name in folders if not name.startswith(".")]
    for path in (run / FOLDER).rglob(".*"):  # unfinished records; the other hidden files are JSON
        if path.is_file() and path.suffix != ".json":
            path.unlink(missing_ok=True)
