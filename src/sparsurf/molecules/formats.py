"""File formats of molecules, by the extensions of their files."""

from __future__ import annotations

from sparsurf.files import StrPath, as_path

PDB = (".pdb", ".ent")
MMCIF = (".cif", ".mmcif")
STRUCTURES = PDB + MMCIF  # each also compressed (.gz)
SELF_CONTAINED = (".gro", ".h5", ".hdf5")  # names and coordinates in one file
AMBER = (".prmtop", ".parm7", ".prm7")
TOPOLOGIES = (".psf", *AMBER)  # names without coordinates
ONE_FRAME = (".rst7", ".restrt", ".inpcrd", ".ncrst")
TRAJECTORIES = (
    ".xtc", ".trr", ".dcd", ".nc", ".ncdf", ".netcdf", ".mdcrd", ".crd", ".lammpstrj", ".xyz", *ONE_FRAME,
)  # fmt: skip
TIMED = (".xtc", ".trr", ".nc", ".ncdf", ".netcdf", ".h5", ".hdf5", ".gro")  # trajectories with times
IN_NM = (".xtc", ".trr", *SELF_CONTAINED)  # formats whose lengths are nanometres


def suffix(path: StrPath) -> str:
    """Return the extension of a file name, in lower case and without .gz."""
    name = as_path(path).name.lower().removesuffix(".gz")
    dot = name.rfind(".")
    return name[dot:] if 0 < dot < len(name) - 1 else ""  # as Path does, without parsing again


def stem(path: StrPath) -> str:
    """Return the name of a file without .gz and its extension, as it is written."""
    name = as_path(path).name
    return name[: len(name.lower().removesuffix(".gz")) - len(suffix(path))]
