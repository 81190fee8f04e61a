"""Progress bars for loops that take long."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import TypeVar

DELAY = 2.0  # s; a shorter loop shows no bar
Item = TypeVar("Item")
# The command line and the functions of `sparsurf` turn the bars on. The jobs of a study share a terminal and leave them off.
enabled = False


def progress_bar(items: Iterable[Item], description: str) -> Iterable[Item]:
    """Iterate over items and show how many are done, on a terminal or in a notebook."""
    if not enabled or not ("ipykernel" in sys.modules or sys.stderr.isatty()):
        return items
    from tqdm import tqdm  # only where a bar is shown

    return tqdm(items, description, leave=False, delay=DELAY)
