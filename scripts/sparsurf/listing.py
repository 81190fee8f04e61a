"""Proteins listed in a table or lying in a folder, as the config's mapping of proteins."""

import csv
import re
from pathlib import Path

from sparsurf import InputError

STRUCTURES = (".pdb", ".ent", ".cif", ".mmcif")  # also .gz
TOPOLOGIES = (".gro", ".h5", ".hdf5", ".psf", ".parm7", ".prmtop", ".top")
TRAJECTORIES = (".xtc", ".trr", ".dcd", ".nc", ".netcdf", ".ncdf", ".xyz", ".lammpstrj", ".mdcrd")
SURFACES = (".dms", ".csv", ".npz")  # the first two also .gz
LISTS = ("chains", "ligands")  # columns of a table that hold several values, parted by blanks
NUMBERS = ("model",)


def from_table(path):
    """Proteins of a CSV table: a column `name` and any keys of a protein; empty cells are left out.

    Parameters
    ----------
    path : str

    Returns
    -------
    dict of name to the protein's keys; files are sought beside the table.

    Raises
    ------
    InputError
    """
    if not Path(path).is_file():
        raise InputError(f"config: proteins is {path!r}, but there is no such table.")
    try:
        with open(path, newline="", encoding="utf-8-sig") as stream:
            rows = list(csv.DictReader(stream, strict=True))
    except (csv.Error, UnicodeDecodeError) as error:
        raise InputError(f"config: {path} is no CSV table ({error}).") from None
    if not rows or "name" not in rows[0]:
        raise InputError(f"config: {path} needs a header with the column name and at least one row.")
    proteins = {}
    for number, row in enumerate(rows, 2):
        if None in row or None in row.values():
            raise InputError(f"config: line {number} of {path} has not as many cells as the header.")
        cells = {key.strip(): value.strip() for key, value in row.items() if value.strip()}
        name = cells.pop("name", "")
        if not name or name in proteins:
            raise InputError(
                f"config: line {number} of {path} has {'a name given before' if name else 'no name'}."
            )
        proteins[name] = {key: _cell(key, value, Path(path).parent) for key, value in cells.items()}
    return proteins


def _cell(key, value, folder):
    if key in ("structure", "trajectory", "surface"):
        return str(folder / value)
    if key in NUMBERS and value.isdigit():
        return int(value)
    if key == "ligands" and value.lower() in ("true", "false"):
        return value.lower() == "true"
    return value.split() if key in LISTS else value


def from_folder(path):
    """Every structure, surface and trajectory of a folder as a protein, named after its file.

    A trajectory belongs to the topology or structure whose name it begins with; that file is then no protein of its
    own. Files of other kinds and hidden ones are passed over.

    Returns
    -------
    dict of name to the protein's keys

    Raises
    ------
    InputError : no such folder, or nothing in it
    """
    folder = Path(path)
    if not folder.is_dir():
        raise InputError(f"config: proteins.folder is {path!r}, but there is no such folder.")
    files = sorted(f for f in folder.iterdir() if f.is_file() and not f.name.startswith(".") and _kind(f))
    if not files:
        known = " ".join(STRUCTURES + TOPOLOGIES + TRAJECTORIES + SURFACES)
        raise InputError(f"config: the folder {path!r} holds no file that ends in one of {known}.")
    owners = {f: _topology_of(f, files) for f in files if _kind(f) == "trajectory"}
    proteins = {}
    for file in files:
        if file in owners.values():
            continue
        entry = {"surface" if _kind(file) == "surface" else "structure": str(file)}
        if owners.get(file):
            entry = {"structure": str(owners[file]), "trajectory": str(file)}
        name = _name(file, files)
        while name.lower() in map(str.lower, proteins):
            name += "_"
        proteins[name] = entry
    return proteins


def _suffix(file):
    return Path(file.name.lower().removesuffix(".gz")).suffix


def _kind(file):
    suffix = _suffix(file)
    for kind, suffixes in (
        ("structure", STRUCTURES + TOPOLOGIES),
        ("trajectory", TRAJECTORIES),
        ("surface", SURFACES),
    ):
        if suffix in suffixes:
            return kind
    return None


def _stem(file):
    return file.name[: len(file.name.lower().removesuffix(".gz")) - len(_suffix(file))]


def _topology_of(trajectory, files):
    """The structure or topology whose name the trajectory's begins with, the longest one; None without."""
    fitting = [f for f in files if _kind(f) == "structure" and _stem(trajectory).startswith(_stem(f))]
    return max(fitting, key=lambda f: len(_stem(f)), default=None)


def _name(file, files):
    """A name for results/: the file's stem, with its ending where another file has the same stem."""
    twins = [f for f in files if _stem(f).lower() == _stem(file).lower() and _kind(f) != "trajectory"]
    name = _stem(file) if len(twins) < 2 else f"{_stem(file)}_{_suffix(file)[1:]}"
    return re.sub(r"[^A-Za-z0-9_.-]", "_", name).lstrip(".-_") or "protein"
