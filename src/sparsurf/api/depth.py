"""Depth of atoms and residues below the surface of their molecule."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sparsurf.api.inputs import MoleculeLike, as_spheres
from sparsurf.api.surfaces import placement
from sparsurf.arguments import Cavities, RadiiLike, public
from sparsurf.surfaces.radii import PROBE_RADIUS

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike


@public()
def depth(
    molecule: MoleculeLike | tuple[ArrayLike, ArrayLike],
    *,
    frame: int = 0,
    probe_radius: float = PROBE_RADIUS,
    radii: RadiiLike = "dms",
    cavities: Cavities = "remove",
) -> pd.DataFrame:
    """Measure how far below the solvent-excluded surface each atom and each residue lies.

    The depth of an atom is the distance of its centre from the nearest point of the surface, and the depth of a residue is the
    mean of its atoms (Chakravarty & Varadarajan, Structure 7:723, 1999), as in Biopython's ResidueDepth.

    Parameters
    ----------
    molecule : path, Molecule, atoms of another library, or pair (xyz, radii)
        The molecule, as for `surface`.
    frame : int
        Position of the frame, from 0 (default 0).
    probe_radius : float
        Radius of the probe, Å (default 1.4; Biopython calls MSMS with 1.5).
    radii : {'dms', 'bondi'}, dict, or path
        Atomic radii, as for `surface` (default 'dms').
    cavities : {'keep', 'remove'}
        Whether the walls of closed cavities belong to the surface (default 'remove').

    Returns
    -------
    DataFrame, one row per atom
        chain, residue, residue_name, atom_name, atom (its index, from 0), `depth` (Å) of the atom, and `residue_depth` (Å).
        Spheres have only `atom` and `depth`.

    Raises
    ------
    InputError
        The molecule cannot be read, or an argument is outside of its limits.

    Examples
    --------
    >>> import sparsurf
    >>> table = sparsurf.depth("data/tdp43/topology.pdb")
    >>> list(table)
    ['chain', 'residue', 'residue_name', 'atom_name', 'atom', 'depth', 'residue_depth']
    >>> bool(table["residue_depth"].max() > 2)
    True
    """
    import pandas as pd  # here: it takes long to load

    from sparsurf.dot_fields.depth import depth_of_atoms, depth_of_residues

    rules = placement(probe_radius, "auto", radii, cavities)
    atoms, xyz, atom_radii = as_spheres(molecule, frame, radii)
    values = depth_of_atoms(xyz, atom_radii, rules.probe_radius, rules.cavities)
    if atoms is None:
        return pd.DataFrame({"atom": np.arange(len(xyz)), "depth": values})
    table = atoms.labels(np.arange(len(xyz))).assign(depth=values)
    return table.assign(residue_depth=depth_of_residues(atoms, values)[atoms.residue_index])
