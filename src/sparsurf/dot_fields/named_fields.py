"""Fields by name: a number at each dot, from the molecule.

`registry` lists them. A field is a function (molecule, points) -> (N,) float64 of the molecule's first frame, NaN where there is
no value. One that follows from where the dots were placed or from the atom of each dot is a function (dots) -> (N,).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from sparsurf import registry
from sparsurf.arguments import checked_result
from sparsurf.dot_fields.charges import pdb2pqr_charges, pqr_charges, table_charges
from sparsurf.dot_fields.columns import TableOfAtoms
from sparsurf.dot_fields.curvature import principal_curvatures
from sparsurf.dot_fields.depth import depth_of_origin
from sparsurf.dot_fields.hydrogen_bonds import balance_of_atoms
from sparsurf.dot_fields.maps import is_map, name_of_map, values_of_map
from sparsurf.dot_fields.potential import potential_of_charges
from sparsurf.dot_fields.smoothing import gaussian_mean
from sparsurf.errors import InputError, argument
from sparsurf.molecules.residues import standard_name

if TYPE_CHECKING:
    from sparsurf.molecules.molecule import Molecule
    from sparsurf.surfaces.surface import Surface

FieldLike: TypeAlias = "str | Callable[..., np.ndarray]"
SAME_PLACE = 2e-3  # Å, of dots that were placed on atoms rounded to 0.001 Å
# Kyte & Doolittle, J. Mol. Biol. 157:105, 1982
HYDROPATHY = {
    "ILE": 4.5, "VAL": 4.2, "LEU": 3.8, "PHE": 2.8, "CYS": 2.5, "MET": 1.9, "MSE": 1.9, "ALA": 1.8, "GLY": -0.4,
    "THR": -0.7, "SER": -0.8, "TRP": -0.9, "TYR": -1.3, "PRO": -1.6, "HIS": -3.2, "GLU": -3.5, "GLN": -3.5,
    "ASP": -3.5, "ASN": -3.5, "LYS": -3.9, "ARG": -4.5,
}  # fmt: skip


def label_and_unit(name: str) -> tuple[str, str]:
    """Return the name of a field for people and its unit; those of a column of a table are its own."""
    choice = registry.choice_of("field", name)
    return (choice.label, choice.unit) if choice else (name.replace("_", " "), "")


def label_with_unit(name: str) -> str:
    """Return the name of a field for people, with its unit if it has one."""
    label, unit = label_and_unit(name)
    return f"{label} ({unit.replace('^2', '²')})" if unit else label


def hydropathy(molecule: Molecule, points: np.ndarray) -> np.ndarray:
    """Average Kyte and Doolittle's hydropathy of nearby amino acids, 4.5 (hydrophobic) to -4.5."""
    return mean_of_residues(HYDROPATHY, molecule, points)


def mean_of_residues(scale: dict[str, float], molecule: Molecule, points: np.ndarray) -> np.ndarray:
    """Turn a scale of residues into a smooth field; residues that are not in the scale do not count."""
    names, inverse = np.unique(molecule.residue_name, return_inverse=True)
    of_name = np.array([scale.get(standard_name(str(name)), np.nan) for name in names])
    return gaussian_mean(of_name[inverse], molecule.xyz[0], points)


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


def bfactor(
    molecule: Molecule, points: np.ndarray, dots: Surface | None = None, smooth: float | None = None
) -> np.ndarray:
    """Return the B factor of the atom of each dot; there is no value if all are 0."""
    values = np.where(molecule.b_factor.any(), molecule.b_factor, np.nan)
    return values_at_dots(values, molecule, points, dots, smooth)


def values_at_dots(
    values: np.ndarray, molecule: Molecule, points: np.ndarray, dots: Surface | None, smooth: float | None
) -> np.ndarray:
    """Return the value (N,) of the atom that each dot belongs to, or a mean of values (A,) of atoms with the width `smooth`, Å.

    Where that atom has no value, the nearest one of its residue that has one counts. Dots whose atom is unknown belong to the
    atom whose centre is nearest. It is known of dots that carry their molecule, and of those that face away from their atoms, as
    all of the accessible surface do.
    """
    values, xyz = np.asarray(values, float), molecule.xyz[0]
    if smooth is not None:
        return gaussian_mean(values, xyz, points, smooth)
    is_known = dots is not None and 0 <= dots.atom.min() <= dots.atom.max() < len(values)
    if dots is not None and is_known and dots.origin is None:
        away = dots.points - xyz[dots.atom]
        is_known = np.allclose(np.linalg.norm(away, axis=1)[:, None] * dots.normals, away, atol=SAME_PLACE)
    if dots is not None and is_known:
        atom = dots.atom
    else:
        from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

        atom = np.asarray(cKDTree(xyz).query(points)[1])
    out, finite = values[atom], np.isfinite(values)
    lacking = np.flatnonzero(np.isnan(out) & finite.any())
    for residue in np.unique(molecule.residue_index[atom[lacking]]):
        members = np.flatnonzero(finite & (molecule.residue_index == residue))
        if len(members):
            rows = lacking[molecule.residue_index[atom[lacking]] == residue]
            distance = np.linalg.norm(points[rows, None] - xyz[members], axis=2)
            out[rows] = values[members[distance.argmin(axis=1)]]
    return out


def mean_curvature(dots: Surface | None) -> np.ndarray:
    """Return the mean of the two principal curvatures, positive where the surface is convex."""
    larger, smaller = _curvatures(dots)
    return (larger + smaller) / 2


def gaussian_curvature(dots: Surface | None) -> np.ndarray:
    """Return the product of the two principal curvatures, negative on saddles."""
    larger, smaller = _curvatures(dots)
    return larger * smaller


def shape_index(dots: Surface | None) -> np.ndarray:
    """Return the shape index, 1 on a convex sphere, 0 on an even saddle, -1 on a concave sphere.

    Koenderink & van Doorn, Image Vision Comput. 10:557, 1992, with the sign of the outward normal.
    """
    larger, smaller = _curvatures(dots)
    return 2 / np.pi * np.arctan2(larger + smaller, larger - smaller)


def hbond(dots: Surface | None) -> np.ndarray:
    """Return 1 at dots of atoms that only donate hydrogen bonds, -1 of those that only accept, 0 of those that do neither.

    An atom that does both has (donated - accepted) / (donated + accepted) hydrogen bonds: a hydroxyl -1/3.
    """
    origin = None if dots is None else dots.origin
    if dots is None or origin is None or origin.molecule is None or dots.atom.min() < 0:
        raise InputError(
            f"{argument('fields')}: hbond follows from the names of residues and atoms; give dots, points or a mesh "
            "of a structure."
        )
    return balance_of_atoms(origin.molecule.frame(origin.frame))[dots.atom]


def depth_of_dots(dots: Surface | None) -> np.ndarray:
    """Return the depth below the surface, without cavities, of the residue that each dot belongs to: the mean of its atoms."""
    if dots is None or dots.origin is None or dots.atom.min() < 0:
        raise InputError(
            "fields: depth follows from the atoms that the dots were placed on; give dots from surface() or points()."
        )
    return depth_of_origin(dots.origin)[dots.atom]


def _curvatures(dots: Surface | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the principal curvatures of dots of which it is known where they were placed."""
    if dots is None or dots.origin is None or dots.atom.min() < 0:
        raise InputError(
            f"{argument('fields')}: curvature follows from the atoms that the dots were placed on; give dots from "
            "surface() or points()."
        )
    return principal_curvatures(dots, dots.origin)


def compute_fields(
    fields: Sequence[FieldLike],
    molecule: Molecule | None,
    points: np.ndarray,
    charges: str | os.PathLike[str] = "table",
    table: str | os.PathLike[str] | None = None,
    dots: Surface | None = None,
    smooth: float | None = None,
) -> dict[str, np.ndarray]:
    """Compute fields of a molecule's first frame at points (Å), by name: of names, functions, maps, or columns of a CSV `table`.

    `dots` are the points as they were placed, which fields of dots need. `smooth`, Å, averages B factors and columns over the
    atoms nearby, and adds _smooth to their names.
    """
    if not isinstance(charges, str | os.PathLike):
        raise InputError(
            f"{argument('charges')} is {type(charges).__name__}; it must be table, pdb2pqr or the path of a PQR file."
        )
    if "potential" not in fields and charges != "table":
        raise InputError(
            f"{argument('charges')} are those of the field potential; add it to the fields, or leave them out."
        )
    out: dict[str, np.ndarray] = {}
    rows = None if table is None or molecule is None else TableOfAtoms.read(table, molecule)
    for field in fields:
        if is_map(field):
            name = name_of_map(field)
            if name in out:
                raise InputError(
                    f"{argument('fields')}: two maps are called {name}; rename one of the files."
                )
            out[name] = values_of_map(field, points)
        elif rows is not None and isinstance(field, str) and not registry.has("field", field):
            assert molecule is not None  # of the table
            name = field if smooth is None else f"{field}_smooth"
            out[name] = values_at_dots(rows.field(field), molecule, points, dots, smooth)
        else:
            choice, function = registry.load("field", field, "fields")
            name = choice.name
            if rows is not None and name in rows.cells.columns:
                raise InputError(
                    f"{table} has the column {name!r}, which names {registry.origin('field', choice)}; rename the column."
                )
            options: dict[str, Any] = {"charges": charges} if name == "potential" else {}
            if name == "bfactor":
                options = {"dots": dots, "smooth": smooth}
            values = function(dots) if choice.takes_dots else function(molecule, points, **options)
            if not choice.is_built_in:
                values = checked_result(values, f"the field {name!r}", (len(points),), allow_nan=True)
            name = f"{name}_smooth" if name == "bfactor" and smooth is not None else name
            out[name] = values
        if not np.isfinite(out[name]).any():
            raise InputError(f"{argument('fields')}: {name} has no value at any dot; leave it out.")
    if smooth is not None and not any(name.endswith("_smooth") for name in out):
        raise InputError(
            f"{argument('smooth')} averages B factors and columns of a table; ask for one of these, or leave it out."
        )
    return out


def names_of_fields(fields: Sequence[FieldLike]) -> list[str]:
    """Return the names of fields that a user gave, by name or as functions."""
    return [registry.name_of("field", field, "fields") for field in fields]


def takes_dots(field: FieldLike) -> bool:
    """Return whether a field follows from the dots as they were placed; not a column of a table."""
    is_field = callable(field) or registry.has("field", field)
    return is_field and registry.load("field", field, "fields")[0].takes_dots
