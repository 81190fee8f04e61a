"""Where a page is from: its files with their checksums, the atoms, the frame, the settings, the date, version and command."""

from __future__ import annotations

import os
from datetime import UTC, date, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sparsurf.errors import printable
from sparsurf.files import checksum_of_file, pluralise
from sparsurf.molecules.source import Source
from sparsurf.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sparsurf.api.page_metadata import About
    from sparsurf.molecules.molecule import Molecule
    from sparsurf.surfaces.surface import Rules, Surface

NAMED_CHAINS = 20  # At most so many chains are named.
KINDS_OF_FILES = "file", "trajectory"

OriginRow = tuple[str, str]  # what it is, and its value


def rows_of_surface(about: About, surface: Surface) -> tuple[OriginRow, ...]:
    """Return the rows of the origin of a page of dots, which may know the atoms that they were placed on."""
    origin = surface.origin
    if origin is None:
        return rows_of_origin(about)
    return rows_of_origin(about, origin.molecule, origin.frame, origin.rules)


def rows_of_origin(
    about: About, molecule: Molecule | None = None, frame: int | None = None, rules: Rules | None = None
) -> tuple[OriginRow, ...]:
    """Return the rows of the origin of a page, in pairs of what it is and its value.

    `molecule` has the atoms that the page shows, `frame` is the position of the one frame that it shows, None for all frames,
    and `rules` say how dots were placed.
    """
    rows = [*_rows_of_files(about)]
    if molecule is not None:
        rows += _rows_of_atoms(about, molecule, frame)
    if rules is not None:
        rows.append(("surface", _words_of_rules(rules, of_molecule=molecule is not None)))
    if about.is_dated:
        rows.append(("date", today().isoformat()))
    rows.append(("version", f"sparsurf {__version__}"))
    return (*rows, ("command", printable(about.command))) if about.command else tuple(rows)


def shown_part(about: About, surface: Surface) -> str:
    """Return what a heading adds to the name of a file with several models or frames: the number of the one that is shown."""
    origin, model = surface.origin, "" if about.model is None else f", model {about.model}"
    if (
        origin is None
        or origin.molecule is None
        or not _is_one_of_several(about, origin.molecule, origin.frame)
    ):
        return model
    return f"{model}, frame {int(origin.molecule.frame_number[origin.frame])}"


def _is_one_of_several(about: About, molecule: Molecule, frame: int) -> bool:
    """Return whether a frame is one of several of its file, and not the only model that was read."""
    return molecule.n_frames > 1 or (about.model is None and molecule.frame_number[frame] > 0)


def _rows_of_files(about: About) -> Iterator[OriginRow]:
    """Yield a row for each file that was read; anything else that was given, such as arrays, is left out."""
    for kind, file in zip(KINDS_OF_FILES, about.files, strict=False):
        path = _path(file)
        if path is not None and path.is_file():
            yield kind, f"{printable(path.name)}, SHA-256 {checksum_of_file(path)}"
    if about.model is not None:
        yield "model", str(about.model)


def _rows_of_atoms(about: About, molecule: Molecule, frame: int | None) -> Iterator[OriginRow]:
    """Yield the chains, the number of atoms, and the frames that are shown, by their numbers in the file."""
    chains = list(dict.fromkeys(map(str, molecule.chain.tolist())))
    unnamed = f" and {len(chains) - NAMED_CHAINS} more" if len(chains) > NAMED_CHAINS else ""
    yield "chains", ", ".join(name or "without a name" for name in chains[:NAMED_CHAINS]) + unnamed
    yield "atoms", f"{molecule.n_atoms:,} atoms of {pluralise(molecule.n_residues, 'residue')}"
    numbers = molecule.frame_number
    if frame is None:
        yield "frames", f"{int(numbers[0])} to {int(numbers[-1])}"
    elif _is_one_of_several(about, molecule, frame):
        time = float(molecule.time_ps[frame])
        shown = f"{int(numbers[frame])} of {int(numbers[0])} to {int(numbers[-1])}"
        yield "frame", shown + ("" if time != time else f", {time:,.10g} ps")


def _words_of_rules(rules: Rules, of_molecule: bool) -> str:
    """Say how dots were placed."""
    table = f", atomic radii {rules.radii}" if of_molecule else ""
    cavities = {"keep": "kept", "remove": "removed"}[rules.cavities]
    return f"probe radius {rules.probe_radius:g} Å{table}, walls of cavities {cavities}"


def today() -> date:
    """Return the date, or that of SOURCE_DATE_EPOCH, with which builds that can be repeated fix it."""
    seconds = os.environ.get("SOURCE_DATE_EPOCH", "")
    return datetime.fromtimestamp(int(seconds), UTC).date() if seconds.isdecimal() else date.today()


def _path(file: Any) -> Path | None:
    """Return the path of a file that was given; None for anything else."""
    if isinstance(file, Source):
        return Path(str(file))
    return Path(file) if isinstance(file, str | os.PathLike) else None
