"""Names that a user may have meant."""

import difflib
from collections.abc import Iterable


def did_you_mean(value: str, names: Iterable[str]) -> str:
    """Return "; did you mean 'name'?" with the nearest of some names, or nothing if none is near."""
    near = difflib.get_close_matches(value, list(names), 1, 0.5)
    return f"; did you mean {near[0]!r}?" if near else ""
