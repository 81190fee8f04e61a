"""Names of conformations, and whether a molecule has only one."""

import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from sparsurf.errors import InputError
from sparsurf.files import read_bytes, shorten
from sparsurf.molecules.formats import MMCIF, PDB, suffix

if TYPE_CHECKING:
    from sparsurf_study.config.models import Protein


def first_column(path: str | Path) -> list[str]:
    """Return the cells of the first column of a CSV table, without its header."""
    lines = Path(path).read_text(encoding="utf-8").splitlines()
    return [line.split(",")[0] for line in lines[1:]]


def without_zeros(name: str) -> str:
    """Return a place of a study without leading zeros in the number of its conformation: p/f0007 is p/f7."""
    return re.sub(r"/([cf])0*(\d+)(?=/|$)", r"/\1\2", name)


def absent_conformation(key: str, place: str, names: list[str]) -> str:
    """Return the sentence that refuses a place in a key of the config which is none of the conformations of its protein."""
    protein = place.partition("/")[0]
    return f"{key}: there is no {place!r}; {protein} has {shorten(', '.join(names))}."


def require_excluded(exclude: Iterable[str], run: Path) -> None:
    """Raise InputError where `exclude` names a conformation that its protein, whose frames are chosen now, does not have."""
    for place in exclude:
        protein, _, conformation = place.partition("/")
        frames = run / protein / "frames.csv"
        if conformation in ("", "*") or not frames.is_file():
            continue
        names = first_column(frames)
        if without_zeros(place) not in [without_zeros(f"{protein}/{name}") for name in names]:
            raise InputError(absent_conformation("exclude", place, names))


def require_conformations(files: Iterable[str]) -> list[Path]:
    """Return files of the conformations of a study, one of each; raise InputError where `exclude` leaves none."""
    paths = [*map(Path, files)]
    if not paths:
        raise InputError("exclude leaves no conformation; keep one, or exclude the proteins as a whole.")
    return paths


def has_one_model(protein: "Protein") -> bool:
    """Return whether a protein is certainly a single structure; False where its frames must be read first."""
    if protein.source or protein.trajectory or protein.simulate is not None or protein.model:
        return False
    return file_has_one_model(protein.structure)


@cache
def file_has_one_model(path: str) -> bool:
    """Return whether a PDB or mmCIF file certainly holds one model; False where that takes a closer look."""
    kind = suffix(path)
    if kind not in PDB + MMCIF:
        return False
    try:
        content = read_bytes(path)
    except InputError:  # choose_frames reports it
        return False
    if kind in PDB:
        end = content.find(b"\nEND")
        models = content.startswith(b"MODEL ") + content.count(b"\nMODEL ")
        return models <= 1 and not (end >= 0 and re.search(rb"^(ATOM|HETATM)", content[end:], re.M))
    columns = re.findall(rb"^_atom_site\.(\w+)", content, re.M)
    rows = re.findall(rb"^(?:ATOM|HETATM)\s.*", content, re.M)
    if columns[-1:] != [b"pdbx_PDB_model_num"] or not rows:
        return False
    first, last = rows[0].split(), rows[-1].split()
    return len(first) == len(last) == len(columns) and first[-1] == last[-1]
