"""What a user sees of work that takes long: progress bars of loops, and a word before kernels are compiled."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from typing import TypeVar

DELAY = 2.0  # s; a shorter loop shows no bar
Item = TypeVar("Item")
# The command line and the functions of `sparsurf` turn the bars on. The jobs of a study share a terminal and leave them off.
enabled = False
before_compiling: Callable[[], None] | None = None  # called before each kernel that is not stored


def progress_bar(items: Iterable[Item], description: str, total: int | None = None) -> Iterable[Item]:
    """Iterate over items and show how many are done, of `total` if they have no length, on a terminal or in a notebook."""
    if not enabled or not ("ipykernel" in sys.modules or sys.stderr.isatty()):
        return items
    from tqdm import tqdm  # only where a bar is shown

    return tqdm(items, description, total, leave=False, delay=DELAY)
