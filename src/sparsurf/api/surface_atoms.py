"""The atoms that determine a molecular surface, the surface that is placed on them, and their files."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sparsurf.api.inputs import MoleculeLike, as_spheres, refuse_dots
from sparsurf.arguments import D_LINK, Cavities, RadiiLike, public
from sparsurf.errors import InputError, argument
from sparsurf.surfaces.molecular_surface import surface_of_surface_atoms
from sparsurf.surfaces.radii import PROBE_RADIUS, check_radii
from sparsurf.surfaces.spheres import Spheres, write_pqr, write_spheres
from sparsurf.surfaces.surface import Placement, Surface
from sparsurf.surfaces.surface_atoms import SurfaceAtoms, atoms_of_surface

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

log = logging.getLogger("sparsurf")


@public()
def surface_atoms(
    molecule: MoleculeLike | tuple[ArrayLike, ArrayLike],
    *,
    frame: int = 0,
    probe_radius: float = PROBE_RADIUS,
    radii: RadiiLike = "dms",
    cavities: Cavities = "keep",
    plugs: bool = True,
) -> SurfaceAtoms:
    """Find the atoms that determine the solvent-excluded surface exactly: the smallest set of spheres, and a few plugs.

    The probe touches some of the atoms, and no sphere of these can be left out, since each has a part of the surface that no
    other one has. They determine the surface, but between them the probe would fit into the inside of the molecule. *Plugs* are
    inner atoms that close these voids. The probe then takes the same positions as on the whole molecule, which is computed
    (`is_exact`) and not assumed. Atoms that keep cavities also determine the surface of every larger probe.

    Parameters
    ----------
    molecule : path, Molecule, atoms of another library, or pair (xyz, radii)
        As in `surface`.
    frame, probe_radius, radii : as in `surface`
        With the same defaults. With another probe or other radii, the atoms determine another surface.
    cavities : {'keep', 'remove'}
        Whether the walls of closed cavities belong to the surface (default 'keep'). Without them, fewer atoms are needed, and the
        surface of these atoms must be computed with `cavities="remove"` as well.
    plugs : bool
        Whether plugs are added (default True). The touched atoms alone leave voids, which a reader must recognise.

    Returns
    -------
    SurfaceAtoms
        `centres` (n, 3) and `radii` (n,) in Å; `atom` (n,) int, their indices in the molecule; `touched` (n,) bool, False for
        plugs; `is_exact`; `write`, for .xyzr, .pqr and .pdb; and `to_frame`. `surface`, `recover` and `show` take them.

    Raises
    ------
    InputError
        The molecule cannot be read, or an argument is outside of its limits.

    Notes
    -----
    The touched atoms are the outer part of the dual shape of the balls of radius r + `probe_radius` (Edelsbrunner, Discrete
    Comput. Geom. 13:415, 1995). Cazals et al., Inria Research Report 8205 (2013), approximate such unions by few balls.

    Examples
    --------
    >>> import sparsurf
    >>> sparsurf.surface_atoms("data/tdp43/topology.pdb")
    SurfaceAtoms: 731 of 953 atoms, of which the probe touches 709
    """
    radii = check_radii(radii)
    refuse_dots("surface_atoms", molecule)
    atoms, xyz, sphere_radii = as_spheres(molecule, frame, radii)
    spheres = Spheres(xyz, sphere_radii, [])
    rules = Placement(probe_radius, radii=radii, cavities=cavities)
    return atoms_of_surface(spheres, rules, plugs, atoms, frame)


def surface_of_atoms(atoms: SurfaceAtoms, rules: Placement | None = None, d_link: float = D_LINK) -> Surface:
    """Place dots on the atoms that determine a surface, by default by their own rules; raise InputError for other surfaces."""
    rules = atoms.rules if rules is None else rules
    probe, cavities = atoms.probe_radius, atoms.cavities
    is_larger = cavities == "keep" and rules.probe_radius > probe
    if rules.probe_radius != probe and not is_larger:
        refused = "of a smaller probe" if cavities == "keep" else "of another probe"
        raise InputError(
            f"surface: these atoms were chosen for a probe of {probe:g} Å and do not determine the surface {refused}; pass "
            f"{argument('probe_radius')}={probe:g}, or choose atoms anew."
        )
    if cavities == "remove" and rules.cavities == "keep":
        raise InputError(
            f"surface: these atoms were chosen without the walls of cavities; pass {argument('cavities')}='remove', or choose "
            "atoms anew."
        )
    if not atoms.is_exact:
        log.warning(
            "surface: these atoms do not determine the surface of their molecule; the dots lie on another one."
        )
    return surface_of_surface_atoms(atoms, rules, d_link)


def header_of_atoms(atoms: SurfaceAtoms) -> list[str]:
    """Return what a file of the atoms says of them, in ASCII."""
    probes = "this probe and all larger ones" if atoms.cavities == "keep" else "this probe"
    exact = f"They determine the surface for {probes}, with these radii alone."
    return [
        f"Atoms of a solvent-excluded surface: {len(atoms)} of {len(atoms.spheres.radii)}, of which the probe touches "
        f"{int(atoms.touched.sum())}.",
        f"Probe radius {atoms.probe_radius:g} A, radii {atoms.table or 'as given'}, walls of cavities "
        f"{'kept' if atoms.cavities == 'keep' else 'removed'}.",
        exact if atoms.is_exact else "They do not determine the surface exactly.",
    ]


def writers_of_atoms(atoms: SurfaceAtoms) -> dict[str, Callable[[Path], Any]]:
    """Return what writes the atoms in each format, by suffix; labels need a molecule."""
    molecule, header = atoms.molecule, header_of_atoms(atoms)
    writers: dict[str, Callable[[Path], Any]] = {
        ".xyzr": lambda path: write_spheres(path, atoms.centres, atoms.radii, header=header)
    }
    if molecule is None:
        return writers
    from sparsurf.molecules.pdb import write_pdb  # here: it loads gemmi

    chosen = molecule.take(atoms.atom)
    note = "The B factor of each atom is its radius in A."
    writers[".pqr"] = lambda path: write_pqr(path, atoms.centres, atoms.radii, chosen, header)
    writers[".pdb"] = lambda path: write_pdb(path, atoms.centres, chosen, atoms.radii, [*header, note])
    return writers
