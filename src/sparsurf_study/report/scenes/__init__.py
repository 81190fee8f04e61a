"""Scripts that open results in PyMOL (.pml) and ChimeraX (.cxc)."""

from collections.abc import Sequence
from pathlib import Path

from sparsurf.surfaces.formats.colours import ROUGHNESS_LIMITS


def script_text(name: str, limits: Sequence[float] = ROUGHNESS_LIMITS) -> str:
    """Return the text of one of the scripts in this folder, with the values at the ends of its colours."""
    text = Path(__file__).with_name(name).read_text(encoding="utf-8")
    low, high = (f"{round(value, 3):g}" for value in limits)
    return text.replace("%LOW%", low).replace("%HIGH%", high)
