"""Scripts that open results in PyMOL (.pml) and ChimeraX (.cxc)."""

from pathlib import Path

SCENE_SCRIPTS = ("open.pml", "open.cxc", "open_pair.pml", "open_pair.cxc")


def script_text(name: str) -> str:
    """Return the text of one of `SCRIPTS`."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")
