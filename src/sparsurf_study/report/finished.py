"""What a run in which jobs failed can be closed with; planning a study imports this, so it needs no numpy."""

from pathlib import Path
from typing import NamedTuple


class Finished(NamedTuple):
    """What is finished of a run in which jobs failed."""

    conformations: list[Path]  # folders, as `pairs`
    pairs: list[Path]
    sampled: list[str]  # names of the proteins with a grid
    files: list[Path]  # of these, of their proteins and of the changes, in the order of the first page
