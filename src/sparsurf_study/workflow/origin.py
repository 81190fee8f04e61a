"""What a run was started with, for its first page; planning a study imports this, so it needs no numpy."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from sparsurf_study.config.protein_keys import FILE_KEYS
from sparsurf_study.report.provenance import RunOrigin

MAX_INPUTS = 50  # files with a checksum; more are only counted
DEFAULT_CONFIG = "config.yaml"


def origin_of(config: Mapping[str, Any], configs: Sequence[Path | str], is_clone: bool = True) -> RunOrigin:
    """Return the origin of a run with a checked config, the first of the files `configs`; paths start in the working folder."""
    inputs: list[str] = []
    for protein in config["proteins"].values():
        inputs += [protein[key] for key in FILE_KEYS if protein.get(key)]
    for pair in config["pairs"].values():
        inputs += [*([pair["complex"]] if pair.get("complex") else []), *(pair.get("files") or ())]
    paths = [*dict.fromkeys(map(_shown, inputs))]
    named = [path for path in map(_shown, configs[:1]) if path != DEFAULT_CONFIG]
    start, option = ("make run", "CONFIG=") if is_clone else ("snakemake --cores all", "--configfile ")
    command = " ".join([start, *(f"{option}{path}" for path in named)])
    return RunOrigin(command, paths if len(paths) <= MAX_INPUTS else [], len(paths))


def note_config(run: Path, config: Path) -> str:
    """Note the config file of a run; return a sentence if the last run was that of another one.

    An edited or moved config is the same one, and a copy of it differs in nothing: only a file that is still there and has
    another content is another config, whose results this run replaces.
    """
    note = run / "logs" / "config"
    former = Path(note.read_text(encoding="utf-8")) if note.is_file() else config
    note.parent.mkdir(parents=True, exist_ok=True)
    note.write_text(str(config), encoding="utf-8")
    with suppress(OSError, ValueError):
        if former.read_bytes() != config.read_bytes():
            return (
                f"{run}/ contains the results of {_shown(former)}, and this run of {_shown(config)} replaces them. To keep both, "
                "write another `run` into one of these configs."
            )
    return ""


def _shown(path: Path | str) -> str:
    """Return a path from the working folder if it lies there, else as it is."""
    absolute = Path(path).absolute()
    return absolute.relative_to(Path.cwd()).as_posix() if absolute.is_relative_to(Path.cwd()) else str(path)
