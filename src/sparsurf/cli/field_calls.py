"""`fields` and `residues`: numbers at the dots of a surface, and over its residues."""

import numpy as np

from sparsurf import InputError
from sparsurf.cli.inputs import (
    agreed,
    around_the_same,
    arrays,
    as_array,
    as_molecule,
    as_surface,
    check_frame,
    has_atoms,
    names_of_fields,
    origin_of,
    same_atoms,
    same_frame,
)
from sparsurf.cli.roughness import roughness
from sparsurf.cli.subsets import as_subset
from sparsurf.dot_fields.registry import compute_fields
from sparsurf.study.residues import residue_table
from sparsurf.surfaces.surface import Surface


def fields(molecule, dots=None, names=("hydropathy", "potential"), *, frame=0, charges="table", table=None):
    """Numbers at the dots of a surface that follow from the molecule around them.

    Parameters
    ----------
    molecule : path of a structure, what `read_molecule` gave, or mdtraj.Trajectory
    dots : what `surface` or `read_surface` gave, the path of a file of dots, or the pair (points, normals);
        in place of the molecule, where they know theirs
    names : sequence of str
        hydropathy (Kyte-Doolittle, averaged over 2.5 Å), potential (screened Coulomb, kT/e), bfactor (Å^2, averaged
        over 2.5 Å), or columns of `table`.
    frame : int
        Position of the frame, from 0.
    charges : str
        Of the potential: 'table' (PARSE; hydrogens that a structure lacks are built), 'pdb2pqr', which must be
        installed, or the path of a PQR file.
    table : path, optional
        CSV with a value for each residue or atom in columns residue, chain, atom and those of `names`.

    Returns
    -------
    DataFrame, (N, F), one column per name

    Raises
    ------
    InputError : one sentence on what is wrong

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> fields = sparsurf.fields(dots)
    >>> fields.shape, list(fields)
    ((24600, 2), ['hydropathy', 'potential'])
    """
    if isinstance(molecule, Surface):
        if has_atoms(dots):
            raise InputError("fields: give the molecule first, then its dots.")
        names = names if dots is None else dots
        dots, (molecule, frame, *_) = molecule, agreed(origin_of(molecule, "fields"), "fields", frame=frame)
    molecule, surface = as_molecule(molecule), as_surface(dots)
    check_frame(molecule, frame, "the molecule")
    same_frame(dots, molecule, frame, "fields")
    around_the_same(dots, molecule, frame, "fields")
    names = names_of_fields(names, "names")
    if not names:
        raise InputError("names: there are no fields; give one at least, such as 'potential'.")
    return compute_fields(names, molecule.frame(frame), surface.points, charges, table)


def residues(dots, molecule=None, *, roughness_values=None, kept=(), weight=None):
    """How much of the surface each residue makes, how rough it is there, and how many of its dots are kept.

    Parameters
    ----------
    dots : what `surface` gave for the molecule
    molecule : path of a structure, what `read_molecule` gave, or mdtraj.Trajectory; that of the dots without
    roughness_values : (N,) float, optional
        R_i where they are known.
    kept, weight : (n,) int, optional
        Dots of a subset, and how many dots each stands for.

    Returns
    -------
    DataFrame, one row per residue
        chain, residue, residue_name; area and area_contact, area_saddle, area_concave (Å^2); mean_roughness and
        most_rough (NaN where buried); the mean of each field; dots, kept, and the weight of the kept.

    Examples
    --------
    >>> import sparsurf
    >>> table = sparsurf.residues(sparsurf.surface("data/tdp43/topology.pdb"))
    >>> len(table), list(table)[:4]
    (61, ['chain', 'residue', 'residue_name', 'area'])
    """
    dots = as_surface(dots)
    molecule = origin_of(dots, "residues").molecule if molecule is None else as_molecule(molecule)
    same_atoms(dots, molecule, None, "residues")
    if not 0 <= dots.atom.min() <= dots.atom.max() < molecule.n_atoms:
        raise InputError("residues: these dots do not say which atom of the molecule they belong to.")
    values = (
        roughness(dots) if roughness_values is None else arrays([roughness_values], "roughness_values")[0]
    )
    if values.shape != (len(dots),):
        raise InputError(
            f"residues: roughness_values has the shape {values.shape}; the dots are {len(dots)}."
        )
    kept = as_array(kept, len(dots), "kept")
    kept = as_subset("kept", kept, len(dots)) if len(kept) else kept
    weight = np.ones(len(kept), int) if weight is None else np.asarray(weight)
    if weight.shape != kept.shape:
        raise InputError(f"residues: weight has the shape {weight.shape}; the kept dots are {len(kept)}.")
    return residue_table(dots, values, molecule, kept, weight)
