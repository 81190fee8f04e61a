"""Scripts that open results in PyMOL (.pml) and ChimeraX (.cxc)."""

from pathlib import Path


def script_text(name: str) -> str:
    """Return the text of one of the scripts in this folder."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")
