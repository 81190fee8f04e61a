"""Conformations that an entry of `sites` in the config names."""

from __future__ import annotations

from sparsurf import InputError


def refuse_absent(path: str | None, site: str) -> None:
    """Raise InputError if a site names a conformation that the study does not have.

    Parameters
    ----------
    path : an input that every site has whose conformations are all there; None without
    site : name of the entry in `sites`
    """
    if not path:
        raise InputError(
            f"sites.{site} names a conformation that this study does not have; frames.csv of its protein lists them."
        )
