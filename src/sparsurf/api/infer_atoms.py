"""Infer the atoms under a surface from its dots alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, cast

import numpy as np

from sparsurf.api.inputs import DotsLike, as_dots
from sparsurf.arguments import LENGTH, PROBE_RADIUS, Auto, RadiiTable, public
from sparsurf.errors import InputError
from sparsurf.recovery.spheres.atoms import Atoms, infer
from sparsurf.recovery.spheres.votes import MIN_DOTS, known_model, vote
from sparsurf.surfaces.radii import RADII
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

AUTO_PROBE = "auto"


@public(words={"probe_radius": AUTO_PROBE})
def infer_atoms(
    points: DotsLike | ArrayLike,
    normals: ArrayLike | None = None,
    *,
    probe_radius: float | Auto | None = PROBE_RADIUS,
    radii: RadiiTable | Auto | Sequence[float] | None = "dms",
) -> Atoms:
    """Infer the atoms under a molecular surface from dots with normals alone.

    Parameters
    ----------
    points : path of a file of dots, Surface, Points, Subset, pair (points, normals), or (n, 3) array
        Dots of the surface, or their positions, Å. About a third of a dot for each Å^2 finds nearly all exposed atoms.
    normals : (n, 3) array, optional
        Outward unit normals of the dots, which an array of positions needs.
    probe_radius : float, 'auto' or None
        Radius of the probe with which the surface was made, Å (default 1.4); 'auto' or None lets the dots vote for it.
    radii : {'dms', 'bondi', 'auto'}, sequence of float, or None
        Table of atomic radii (default 'dms'), or the radii, Å; 'auto' or None lets the dots vote for them.

    Returns
    -------
    Atoms
        `centres` (A, 3) and `radii` (A,) in Å, and `touches` (A,), how many distinct probes of the dots touch each atom, those
        found first and with the most support first. Atoms with few touches may be wrong.

    Raises
    ------
    InputError
        A radius is not allowed, or the dots vote for no probe radius: noisy, fewer than 100, or on another kind of surface.

    Notes
    -----
    Each dot of a solvent-excluded surface (Connolly, J. Appl. Cryst. 16:548, 1983) has the centre of its probe at p +
    probe_radius n, and this probe touches one atom (contact dot), two (saddle) or three (concave) and holds none. So an atom of
    radius r is the centre of a sphere of radius r + probe_radius that passes through probe centres and holds none. Three dots, or
    a contact dot and another, determine it. No earlier method that does this was found.

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> atoms = sparsurf.infer_atoms(dots[sparsurf.sample(dots, n_dots=1500)])
    >>> from scipy.spatial import cKDTree
    >>> distance = cKDTree(dots.molecule.xyz[0]).query(atoms.centres)[0]
    >>> bool((distance < 0.001).mean() > 0.8)
    True
    """
    dots = as_dots(cast("DotsLike", points if normals is None else (points, normals)))
    probe = None if probe_radius == AUTO_PROBE else cast("float | None", probe_radius)
    table = _radii(radii)
    if probe is not None and table is not None:
        model = known_model(dots.points, dots.normals, probe, table)
    else:
        model = vote(dots.points, dots.normals, probe, table)
    if len(model.radii) == 0:
        reason = f"there are {len(dots)}, and {MIN_DOTS} are needed" if len(dots) < MIN_DOTS else ""
        reason = (
            reason
            or "their normals and positions agree with none, as on a surface of another kind or with noise"
        )
        raise InputError(
            f"infer_atoms: the dots do not tell the probe radius and the radii of the atoms: {reason}; give probe_radius and "
            "radii if you know them."
        )
    return infer(dots.points, dots.normals, model, available_cores())


def _radii(radii: object) -> str | np.ndarray | None:
    """Return a table or radii of the user, None where the dots vote; raise InputError for anything else."""
    if radii is None or isinstance(radii, str):
        if radii not in (None, AUTO_PROBE, *RADII):
            raise InputError(
                f"radii is {radii!r}; it must be one of {', '.join(RADII)}, 'auto', or a list of radii in Å."
            )
        return None if radii == AUTO_PROBE else cast("str | None", radii)
    is_list = radii.ndim == 1 if isinstance(radii, np.ndarray) else isinstance(radii, Sequence)
    if not is_list or len(cast("Sequence", radii)) == 0:
        raise InputError(
            f"radii is {radii!r}; it must be one of {', '.join(RADII)}, 'auto', or a list of radii in Å."
        )
    return np.array([LENGTH.check(radius, "radii") for radius in cast("Sequence", radii)])
