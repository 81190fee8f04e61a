"""File formats of molecules: what a file of each holds, and the extensions that usually belong to it.

`source.open_source` recognises a file by its content. The extensions serve the plan of a study, which opens no file.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from sparsurf.files import PACKED_SUFFIXES, StrPath, as_path


class MoleculeFormat(NamedTuple):
    """A format of files."""

    name: str
    label: str  # for messages
    suffixes: tuple[str, ...] = ()  # extensions of file names, the usual one first
    atoms: bool = False  # the file names its atoms
    places: bool = False  # it has coordinates
    models: bool = False  # its frames are the models of a structure
    text: bool = True
    unit: str = "Å"  # of its lengths
    timed: bool = False  # its frames have times
    refusal: str = ""  # why no file of this format is read, as the end of a sentence


_EVERY_FORMAT = (
    MoleculeFormat("pdb", "PDB", (".pdb", ".ent", ".brk"), atoms=True, places=True, models=True),
    MoleculeFormat("mmcif", "mmCIF", (".cif", ".mmcif"), atoms=True, places=True, models=True),
    MoleculeFormat("gro", "GRO", (".gro",), atoms=True, places=True, unit="nm", timed=True),
    MoleculeFormat("hdf5", "HDF5", (".h5", ".hdf5"), atoms=True, places=True, text=False, unit="nm", timed=True),
    MoleculeFormat("card", "CHARMM CARD", (".cor",), atoms=True, places=True),
    MoleculeFormat("psf", "PSF", (".psf",), atoms=True),
    MoleculeFormat("parm7", "AMBER parm7", (".parm7", ".prmtop", ".prm7"), atoms=True),
    MoleculeFormat("xtc", "XTC", (".xtc",), places=True, text=False, unit="nm", timed=True),
    MoleculeFormat("trr", "TRR", (".trr",), places=True, text=False, unit="nm", timed=True),
    MoleculeFormat("dcd", "DCD", (".dcd",), places=True, text=False),
    MoleculeFormat("netcdf", "NetCDF", (".nc", ".ncdf", ".netcdf"), places=True, text=False, timed=True),
    MoleculeFormat("ncrst", "NetCDF restart", (".ncrst",), places=True, text=False),
    MoleculeFormat("mdcrd", "AMBER mdcrd", (".mdcrd", ".crd"), places=True),
    MoleculeFormat("inpcrd", "AMBER restart", (".rst7", ".restrt", ".inpcrd"), places=True),
    MoleculeFormat("xyz", "XYZ", (".xyz",), places=True),
    MoleculeFormat("lammps dump", "LAMMPS dump", (".lammpstrj",), places=True),
    MoleculeFormat("lammps data", "LAMMPS data", places=True),
    MoleculeFormat(
        "tpr", "GROMACS TPR", (".tpr",),
        refusal="is a run input of GROMACS (TPR), which only GROMACS reads: write its structure by `gmx editconf -f FILE.tpr -o "
        "FILE.gro`, and give that file",
    ),
    MoleculeFormat(
        "cpt", "GROMACS checkpoint", (".cpt",),
        refusal="is a checkpoint of GROMACS, which only GROMACS reads: write its frame by `gmx trjconv -f FILE.cpt -s FILE.tpr "
        "-o FILE.gro`, and give that file",
    ),
    MoleculeFormat(
        "tng", "TNG", (".tng",),
        refusal="is a TNG trajectory, which is not read: convert it by `gmx trjconv -f FILE.tng -o FILE.xtc`, and give that file",
    ),
    MoleculeFormat(
        "g96", "GROMOS96", (".g96",),
        refusal="is a GROMOS96 file (.g96), which is not read: convert it by `gmx editconf -f FILE.g96 -o FILE.gro`, and give "
        "that file",
    ),
    MoleculeFormat(
        "namd", "binary coordinates of NAMD",
        refusal="holds binary coordinates of NAMD, which are not read: write them as PDB or DCD, for example with VMD, and give "
        "that file",
    ),
    MoleculeFormat(
        "desmond", "Desmond", (".cms", ".mae", ".dtr", ".stk"),
        refusal="is a file of Desmond or Maestro, which is not read: write the structure as PDB and the trajectory as DCD or "
        "XTC, for example with VMD, and give these files",
    ),
    MoleculeFormat(
        "cdf5", "CDF-5",
        refusal="is a NetCDF file of the variant CDF-5, which is not read: convert it by `nccopy -k nc6 FILE OTHER`, and give "
        "the other file",
    ),
    MoleculeFormat(
        "netcdf4", "NetCDF-4",
        refusal="is a NetCDF-4 file (HDF5), which is not read: convert it by `nccopy -k nc6 FILE OTHER`, and give the other file",
    ),
    MoleculeFormat(
        "h5md", "H5MD",
        refusal="is an H5MD file, which is not read: convert its frames to XTC, DCD or NetCDF, for example with MDAnalysis",
    ),
    MoleculeFormat("dots", "dots"),
)  # fmt: skip
MOLECULE_FORMATS = {file_format.name: file_format for file_format in _EVERY_FORMAT}
# What stands for any file that is not of a molecule: the reader of surfaces recognises it, or refuses it
FILE_OF_DOTS = "dots"
FORMAT_OF_SUFFIX = {
    suffix: file_format.name for file_format in _EVERY_FORMAT for suffix in file_format.suffixes
}


def _suffixes(*names: str) -> tuple[str, ...]:
    """Return the extensions of some formats."""
    return tuple(suffix for name in names for suffix in MOLECULE_FORMATS[name].suffixes)


def _labels(atoms: bool, places: bool) -> str:
    """Return the labels of the formats that are read and name atoms, have coordinates, or both, as a part of a sentence."""
    *labels, last = (entry.label for entry in _EVERY_FORMAT if (entry.atoms, entry.places) == (atoms, places))
    return f"{', '.join(labels)} or {last}"


STRUCTURE_LABELS, TOPOLOGY_LABELS = _labels(True, True), _labels(True, False)
TRAJECTORY_LABELS = _labels(False, True)
PDB, MMCIF = _suffixes("pdb"), _suffixes("mmcif")
STRUCTURES = PDB + MMCIF  # each also compressed (.gz)
SELF_CONTAINED = _suffixes("gro", "hdf5", "card")  # names and coordinates in one file
TOPOLOGIES = _suffixes("psf", "parm7")  # names without coordinates
TRAJECTORIES = _suffixes("xtc", "trr", "dcd", "netcdf", "mdcrd", "lammps dump", "xyz", "inpcrd", "ncrst")


def suffix(path: StrPath) -> str:
    """Return the extension of a file name, in lower case and without .gz, .bz2 or .xz."""
    name = _unpacked(as_path(path).name.lower())
    dot = name.rfind(".")
    return name[dot:] if 0 < dot < len(name) - 1 else ""  # as Path does, without parsing again


def usual_suffix(path: StrPath) -> str:
    """Return the extension as `suffix` does, without the number of an assembly in those of the PDB, as .pdb1."""
    return re.sub(r"(?<=\.pdb)\d+$", "", suffix(path))


def stem(path: StrPath) -> str:
    """Return the name of a file without its extension, also that of a compression, as it is written."""
    name = as_path(path).name
    return name[: len(_unpacked(name.lower())) - len(suffix(path))]


def _unpacked(name: str) -> str:
    """Return a name in lower case without the suffix of a compression."""
    return next((name.removesuffix(ending) for ending in PACKED_SUFFIXES if name.endswith(ending)), name)


def title(path: StrPath) -> str:
    """Return the stem of a file name for pages and tables, where bytes that are not UTF-8 are replaced."""
    return stem(path).encode("utf-8", "surrogateescape").decode("utf-8", "replace")
