"""Fields by name: a number at each dot, from the molecule.

To add a field, write a function (molecule, points) -> (N,) with the decorator `@field(label, unit)`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd

from sparsurf.dot_fields.charges import pdb2pqr_charges, pqr_charges, table_charges
from sparsurf.dot_fields.columns import column_of_atoms, columns_of
from sparsurf.dot_fields.potential import potential_of_charges
from sparsurf.dot_fields.smoothing import gaussian_mean
from sparsurf.errors import InputError
from sparsurf.molecules.residues import standard_name

if TYPE_CHECKING:
    from sparsurf.molecules.molecule import Molecule

FIELDS: dict[str, Field] = {}
# Kyte & Doolittle, J. Mol. Biol. 157:105, 1982
HYDROPATHY = {
    "ILE": 4.5, "VAL": 4.2, "LEU": 3.8, "PHE": 2.8, "CYS": 2.5, "MET": 1.9, "MSE": 1.9, "ALA": 1.8, "GLY": -0.4,
    "THR": -0.7, "SER": -0.8, "TRP": -0.9, "TYR": -1.3, "PRO": -1.6, "HIS": -3.2, "GLU": -3.5, "GLN": -3.5,
    "ASP": -3.5, "ASN": -3.5, "LYS": -3.9, "ARG": -4.5,
}  # fmt: skip


class Field(NamedTuple):
    """A field.

    Attributes
    ----------
    function : callable
        (molecule, points, **options) -> (N,) float64, from the molecule's first frame; NaN where there is no value.
    label, unit : str
        For figures and pages.
    """

    function: Callable[..., np.ndarray]
    label: str
    unit: str


def field(label: str, unit: str) -> Callable[[Callable[..., np.ndarray]], Callable[..., np.ndarray]]:
    """Register a function as a field under its name."""

    def register(function: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
        FIELDS[function.__name__] = Field(function, label, unit)
        return function

    return register


@field("hydropathy", "Kyte-Doolittle")
def hydropathy(molecule: Molecule, points: np.ndarray) -> np.ndarray:
    """Average Kyte and Doolittle's hydropathy of nearby amino acids, 4.5 (hydrophobic) to -4.5."""
    return mean_of_residues(HYDROPATHY, molecule, points)


def mean_of_residues(scale: dict[str, float], molecule: Molecule, points: np.ndarray) -> np.ndarray:
    """Turn a scale of residues into a smooth field; residues that are not in the scale do not count."""
    names, inverse = np.unique(molecule.residue_name, return_inverse=True)
    of_name = np.array([scale.get(standard_name(str(name)), np.nan) for name in names])
    return gaussian_mean(of_name[inverse], molecule.xyz[0], points)


@field("electrostatic potential", "kT/e")
def potential(
    molecule: Molecule, points: np.ndarray, charges: str | os.PathLike[str] = "table"
) -> np.ndarray:
    """Compute the screened Coulomb potential; `charges` is 'table', 'pdb2pqr' or the path of a PQR file."""
    if charges == "table":
        positions, values = table_charges(molecule)
    elif charges == "pdb2pqr":
        positions, values = pdb2pqr_charges(molecule)
    else:
        positions, values = pqr_charges(charges, molecule)
    return potential_of_charges(positions, values, points)


@field("B factor", "Å^2")
def bfactor(molecule: Molecule, points: np.ndarray) -> np.ndarray:
    """Average the B factors of nearby atoms; there is no value if all are 0."""
    return gaussian_mean(
        np.where(molecule.b_factor.any(), molecule.b_factor, np.nan), molecule.xyz[0], points
    )


def compute_fields(
    names: Sequence[str],
    molecule: Molecule,
    points: np.ndarray,
    charges: str | os.PathLike[str] = "table",
    table: str | os.PathLike[str] | None = None,
) -> pd.DataFrame:
    """Compute fields of a molecule's first frame at dots (Å), one column per name of `FIELDS` or of the CSV `table`."""
    if not isinstance(charges, str | os.PathLike):
        raise InputError(
            f"charges is {type(charges).__name__}; it must be table, pdb2pqr or the path of a PQR file."
        )
    out, columns = {}, columns_of(table) if table is not None else []
    for name in names:
        if name in FIELDS and name in columns:
            raise InputError(
                f"{table} has the column {name!r}, which is the name of a built-in field; rename the column."
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
