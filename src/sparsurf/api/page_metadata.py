"""What a page or a picture says besides its dots: names, files, notes, and what was left out when the molecule was read."""

from __future__ import annotations

import importlib.util
import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sparsurf.errors import InputError, printable
from sparsurf.messages import listening

if TYPE_CHECKING:
    import numpy as np

    from sparsurf.settings import PatchesSettings
    from sparsurf.surfaces.surface import Surface

LEFT_OUT = "left out "  # how the message on residues that are not part of a molecule begins


@dataclass
class Heard:
    """What reading a molecule said: names of residues that were left out, and further sentences."""

    left_out: list[str] = field(default_factory=list)
    sentences: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class About:
    """What a page or picture says besides the dots.

    Attributes
    ----------
    name : of the molecule or file
    heard : what reading the molecule said; None where it was not read here
    patches : radius and link of the patches of the roughness; by default those of the paper, or a link that suits the dots
    roughness : (N,) R_i of the dots if it is known
    whole : the surface that kept dots were chosen from
    kept : the dots of `whole`, or of the surface that is shown, that a subset keeps; these are shown first
    is_whole : whether the dots are known to be all dots of a surface, though they do not know where they were placed
    links : address and words of other pages on the same surface
    files : the file that was read, and that of its trajectory; their checksums are on the page
    model : number of the only model of the file that was read, if it was chosen
    command : the command, or the call, that made the page
    notes : further sentences
    answer : the sentence that the page begins with, where something was asked of the surface
    is_dated : whether the page says its date; the pages of a study follow from its inputs alone
    """

    name: str = ""
    heard: Heard | None = None
    patches: PatchesSettings | None = None
    roughness: np.ndarray | None = None
    whole: Surface | None = None
    kept: Sequence[int] | np.ndarray = ()
    is_whole: bool = False
    links: tuple[tuple[str, str], ...] = ()
    files: tuple[Any, ...] = ()
    model: int | None = None
    command: str = ""
    notes: Sequence[str] = ()
    answer: str = ""
    is_dated: bool = True


@contextmanager
def heard(path: Any) -> Iterator[Heard]:
    """Collect what the library says of a file while it is read, its notes included; warnings are shown as always."""
    found, name = Heard(), printable(Path(str(path)).name)

    def hear(record: logging.LogRecord) -> None:
        # the filter of the log has replaced what cannot be printed
        text = (
            printable(record.getMessage()).removeprefix(f"{printable(path)}: ").replace(printable(path), name)
        )
        if text.startswith(LEFT_OUT):
            found.left_out += text.removeprefix(LEFT_OUT).split(", ")
        elif record.levelno >= logging.WARNING:
            begin = text if text.startswith(name) else f"{text[:1].upper()}{text[1:]}"
            found.sentences.append(begin + ("" if begin.endswith(("?", ".")) else "."))

    with listening(hear, logging.INFO, pass_on=True):
        yield found


def refuse_missing_matplotlib(name: str) -> None:
    """Raise InputError if no picture can be drawn."""
    if importlib.util.find_spec("matplotlib") is None:
        raise InputError(
            f"{name}: a picture needs matplotlib; run pip install matplotlib, or name a file that ends in .html."
        )
