"""Fields by name: a number at each dot, from the molecule.

To add a field, write one function (molecule, points) -> (N,) and put `@field(...)` above it.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.dot_fields.charges import pdb2pqr_charges, pqr_charges, table_charges
from sparsurf.dot_fields.columns import column_of_atoms, columns_of
from sparsurf.dot_fields.potential import potential_of_charges
from sparsurf.dot_fields.smoothing import gaussian_mean
from sparsurf.molecules.residues import standard_name

FIELDS = {}
# Kyte & Doolittle, J. Mol. Biol. 157:105, 1982
HYDROPATHY = {
    "ILE": 4.5, "VAL": 4.2, "LEU": 3.8, "PHE": 2.8, "CYS": 2.5, "MET": 1.9, "MSE": 1.9, "ALA": 1.8, "GLY": -0.4,
    "THR": -0.7, "SER": -0.8, "TRP": -0.9, "TYR": -1.3, "PRO": -1.6, "HIS": -3.2, "GLU": -3.5, "GLN": -3.5,
    "ASP": -3.5, "ASN": -3.5, "LYS": -3.9, "ARG": -4.5,
}  # fmt: skip

# Volume of a residue inside proteins, Å^3: Zamyatnin, Prog. Biophys. Mol. Biol. 24:107, 1972
VOLUME = {
    "ALA": 88.6, "ARG": 173.4, "ASN": 114.1, "ASP": 111.1, "CYS": 108.5, "GLN": 143.8, "GLU": 138.4, "GLY": 60.1,
    "HIS": 153.2, "ILE": 166.7, "LEU": 166.7, "LYS": 168.6, "MET": 162.9, "MSE": 162.9, "PHE": 189.9, "PRO": 112.7,
    "SER": 89.0, "THR": 116.1, "TRP": 227.8, "TYR": 193.6, "VAL": 140.0,
}  # fmt: skip
RINGS = {"PHE": 1.0, "TYR": 1.0, "TRP": 1.0, "HIS": 0.6}  # aromatic residues; histidine's ring is polar
CHARGES = {"LYS": 1.0, "ARG": 1.0, "ASP": -1.0, "GLU": -1.0}  # of side chains at pH 7


class Field(NamedTuple):
    """A field.

    function : (molecule, points, **options) -> (N,) float64, from the molecule's first frame; NaN where it says nothing
    words, unit : str, what figures and pages call it
    """

    function: Callable
    words: str
    unit: str


def field(words, unit):
    """Register the function below under its name."""

    def register(function):
        FIELDS[function.__name__] = Field(function, words, unit)
        return function

    return register


@field("hydropathy", "Kyte-Doolittle")
def hydropathy(molecule, points):
    """Kyte and Doolittle's hydropathy of the residues around, 4.5 (oily) to -4.5; other residues have none."""
    return _of_residues(HYDROPATHY, molecule, points)


@field("residue volume", "Å^3")
def volume(molecule, points):
    """Volume of the residues around."""
    return _of_residues(VOLUME, molecule, points)


@field("aromaticity", "share")
def aromaticity(molecule, points):
    """Share of aromatic residues around."""
    return _of_residues(dict.fromkeys(VOLUME, 0.0) | RINGS, molecule, points)


@field("charge of side chains", "e")
def charge(molecule, points):
    """Mean charge of the side chains around: less detailed than the potential, and moves less with the atoms."""
    return _of_residues(dict.fromkeys(VOLUME, 0.0) | CHARGES, molecule, points)


def _of_residues(scale, molecule, points):
    """A scale of residues as a smooth field."""
    names, place = np.unique(molecule.residue_name, return_inverse=True)
    of_name = np.array([scale.get(standard_name(str(name)), np.nan) for name in names])
    return gaussian_mean(of_name[place], molecule.xyz[0], points)


@field("electrostatic potential", "kT/e")
def potential(molecule, points, charges="table"):
    """Screened Coulomb potential; `charges`: 'table', 'pdb2pqr' or the path of a PQR file."""
    if charges == "table":
        found = table_charges(molecule)
    else:
        found = pdb2pqr_charges(molecule) if charges == "pdb2pqr" else pqr_charges(charges, molecule)
    return potential_of_charges(*found, points)


@field("B factor", "Å^2")
def bfactor(molecule, points):
    """B factors of the atoms around, as the file has them; none where all are 0."""
    return gaussian_mean(
        np.where(molecule.b_factor.any(), molecule.b_factor, np.nan), molecule.xyz[0], points
    )


def values(names, molecule, points, charges="table", table=None):
    """Fields at dots.

    Parameters
    ----------
    names : sequence of str
        Names in `FIELDS`, or columns of `table`.
    molecule : Molecule
        Its first frame.
    points : (N, 3) float64, Å
    charges : str
        See `potential`.
    table : path, optional
        CSV with a value for each residue or atom, see `columns.column_of_atoms`.

    Returns
    -------
    DataFrame, (N, F), one column per name

    Raises
    ------
    InputError : a field that neither has, or both, or one that says nothing at any dot
    """
    out, own = {}, columns_of(table) if table is not None else ()
    for name in names:
        if name in FIELDS and name in own:
            raise InputError(
                f"{table} has the column {name!r}, which is a field without it; rename the column."
            )
        if name in FIELDS:
            options = {"charges": charges} if name == "potential" else {}
            out[name] = FIELDS[name].function(molecule, points, **options)
        elif table is not None:
            out[name] = gaussian_mean(column_of_atoms(table, name, molecule), molecule.xyz[0], points)
        else:
            raise InputError(f"fields: there is no field {name!r}; the fields are {', '.join(FIELDS)}.")
        if not np.isfinite(out[name]).any():
            raise InputError(f"fields: {name} has no value at any dot; leave it out.")
    return pd.DataFrame(out)
