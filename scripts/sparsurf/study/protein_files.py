"""What was measured on one protein, in a folder of its own; complete or not there."""

import json
import os
import shutil
from dataclasses import fields, replace
from pathlib import Path

import pandas as pd

from sparsurf import InputError
from sparsurf.study.summary import Result

TABLES = ("grid", "ranges", "floors", "by_n_s")
OF_RESULT = [
    field.name for field in fields(Result) if field.name not in ("grid", "ranges", "best", "enough")
]  # single values


def save(folder, result, floors, by_n_s, **more):
    """Write a `Result`, its floors and its table by n_S; `more` are single values that go with them."""
    folder = Path(folder)
    work = folder.with_name(folder.name + ".part")
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    tables = {"grid": result.grid, "ranges": result.ranges, "floors": floors, "by_n_s": by_n_s}
    for name, table in tables.items():
        table.to_csv(work / f"{name}.csv", index=False)
    single = {name: getattr(result, name) for name in OF_RESULT} | {"best": result.best} | more
    (work / "protein.json").write_text(json.dumps(single, indent=1) + "\n", encoding="utf-8")
    os.replace(work, folder)


def load(folder):
    """Result, floors, table by n_S and the dict of single values of one protein.

    Raises
    ------
    InputError : the folder does not hold what `save` writes
    """
    folder = Path(folder)
    try:
        single = json.loads((folder / "protein.json").read_text(encoding="utf-8"))
        grid, ranges, floors, by_n_s = (pd.read_csv(folder / f"{name}.csv") for name in TABLES)
        result = Result(
            **{name: single[name] for name in OF_RESULT}, grid=grid, ranges=ranges, best=single["best"]
        )
    except (OSError, KeyError, ValueError) as error:
        raise InputError(
            f"{folder} does not hold what was measured on a protein ({error}): remove it and measure again."
        ) from None
    return replace(result, protein=folder.name), floors, by_n_s, single


def load_all(folder):
    """What `load` returns of every protein of a folder, by the number of dots."""
    paths = sorted(
        path.parent for path in Path(folder).glob("*/protein.json") if path.parent.suffix != ".part"
    )
    if not paths:
        raise InputError(f"{folder} holds no measured protein: run scripts/study_proteins.py first.")
    return sorted((load(path) for path in paths), key=lambda each: (each[0].n_dots, each[0].protein))
