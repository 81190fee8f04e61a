"""Conformations that an entry of `sites` in the config names."""

from __future__ import annotations

from sparsurf import InputError


def require_conformation(path: str | None, site: str) -> str:
    """Return the file of a conformation that a site names; raise InputError where the study does not have it."""
    if not path:
        raise InputError(
            f"sites.{site} names a conformation that this study does not have; frames.csv of its protein lists them."
        )
    return path
