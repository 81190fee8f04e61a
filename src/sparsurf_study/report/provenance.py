"""Where the results of a run come from: the program, the command, and the input files with their checksums."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

from sparsurf.files import checksum_of_file
from sparsurf.version import __version__


@dataclass(frozen=True)
class RunOrigin:
    """What a run was started with: the command, its input files if they are few, and their number; what libraries computed."""

    command: str = ""
    inputs: Sequence[str] = ()
    n_inputs: int = 0
    libraries: Sequence[str] = ()


UNKNOWN_ORIGIN = RunOrigin()


def provenance(origin: RunOrigin) -> dict[str, Any]:
    """Return the version, the date, the command, and the input files with their checksums as far as they are still there."""
    present = [path for path in origin.inputs if Path(path).is_file()]
    return {
        "version": __version__,
        "date": date.today().isoformat(),
        "command": origin.command,
        "n_inputs": origin.n_inputs,
        "libraries": origin.libraries,
        "inputs": [(path, checksum_of_file(path)) for path in present],
    }
