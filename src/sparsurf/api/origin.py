"""Where a page is from: its files with their checksums, the chains and the frame, the date, the version and the command."""

from __future__ import annotations

import os
from collections.abc import Sequence
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any

from sparsurf.files import checksum_of_file
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.source import Source
from sparsurf.version import __version__

NAMED_CHAINS = 20  # that are named

OriginRow = tuple[str, str]  # what it is, and its value


def rows_of_origin(
    files: Sequence[Any] = (), molecule: Molecule | None = None, frame: int | None = None, command: str = ""
) -> tuple[OriginRow, ...]:
    """Return the rows of the block of origin of a page.

    `files` are the paths that were read, first the structure or the dots, then the trajectory; anything else, such as arrays, is
    left out. `frame` is the position of the frame that is shown, None for all frames.
    """
    rows: list[OriginRow] = []
    paths = [_path(file) for file in files]
    for label, path in zip(("file", "trajectory"), paths, strict=False):
        if path is not None and path.is_file():
            rows.append((label, f"{path.name}, SHA-256 {checksum_of_file(path)}"))
    if molecule is not None:
        chains = list(dict.fromkeys(map(str, molecule.chain.tolist())))
        named = ", ".join(name or "without a name" for name in chains[:NAMED_CHAINS])
        rows.append(
            (
                "chains",
                named + (f" and {len(chains) - NAMED_CHAINS} more" if len(chains) > NAMED_CHAINS else ""),
            )
        )
        if molecule.n_frames > 1 or (frame is not None and len(paths) > 1):
            last = int(molecule.frame_number[-1])
            shown = f"0 to {last}" if frame is None else f"{molecule.frame_number[frame]} of 0 to {last}"
            rows.append(("frame" if frame is not None else "frames", shown))
    rows += [("date", today().isoformat()), ("version", f"sparsurf {__version__}")]
    return (*rows, ("command", command)) if command else tuple(rows)


def today() -> date:
    """Return the date, or that of SOURCE_DATE_EPOCH, with which builds that can be repeated fix it."""
    seconds = os.environ.get("SOURCE_DATE_EPOCH", "")
    return datetime.fromtimestamp(int(seconds), UTC).date() if seconds.isdecimal() else date.today()


def _path(file: Any) -> Path | None:
    """Return the path of a file that was given; None for anything else."""
    if isinstance(file, Source):
        return Path(str(file))
    return Path(file) if isinstance(file, str | os.PathLike) else None
