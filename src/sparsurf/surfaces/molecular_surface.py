"""The solvent-excluded surface of atoms as dots."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.arguments import Auto, Cavities, Reentrant
from sparsurf.errors import InputError, argument
from sparsurf.surfaces.areas import areas_by_kind
from sparsurf.surfaces.components import components_of_rolled, without_cavities
from sparsurf.surfaces.dot_placement import (
    LATTICE,
    Rolled,
    lattice_spacing,
    place_dots,
    roll_checked,
)
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.radii import radii as radii_of
from sparsurf.surfaces.spacing import DENSITY, MIN_D_LINK_PER_SPACING, spacing
from sparsurf.surfaces.surface import Surface, SurfaceOrigin

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from sparsurf.molecules.molecule import Molecule
    from sparsurf.surfaces.surface import Rules
    from sparsurf.surfaces.surface_atoms import SurfaceAtoms

log = logging.getLogger("sparsurf")

DENSITY_RESERVE = 1.02  # an automatic density exceeds what d_link needs by this factor
JUST_BELOW = 0.999  # It brings a number below a limit, beyond rounding.
# Dots per Å^2 on which a link of 0.5 Å is 1.3 median spacings: 5.35 to 5.74 on 106 proteins without hydrogens, 4.65 to 4.91 on
# six of which half of the atoms are hydrogens. On smaller molecules the dots of `DENSITY` are measured first.
HEAVY_DENSITY, FEWER_WITH_HYDROGENS, AUTO_LINK = 5.8, 1.2, 0.5
# Between the radius of hydrogen, 1.2 Å, and those of the other atoms of proteins, 1.4 Å and more
MAX_HYDROGEN_RADIUS = 1.3  # Å
MIN_ATOMS_TO_ESTIMATE = 300
MAX_DENSITY = 100  # dots per Å^2, also of a density that the config sets


def surface_of_molecule(
    molecule: Molecule, settings: Rules, d_link: float, name: str, frame: int = 0
) -> Surface:
    """Place dots on one frame of a molecule with a density that suits d_link (Å); they carry the molecule."""
    dots = surface_of_spheres(molecule.xyz[frame], radii_of(molecule, settings.radii), settings, d_link, name)
    assert dots.origin is not None
    return dots.with_origin(replace(dots.origin, molecule=molecule, frame=frame))


def surface_of_spheres(
    xyz: np.ndarray, radii: np.ndarray, settings: Rules, d_link: float, name: str
) -> Surface:
    """Place dots on spheres at `xyz` (A, 3) with `radii` (A,), Å, with a density that suits d_link (Å)."""
    xyz = xyz.round(3)
    rolled = roll_frame(xyz, radii, settings)
    dots, _ = rolled.surface_for_d_link(settings.density, d_link, name)
    return dots.with_origin(_origin_of(dots, rolled, xyz, radii, settings, d_link))


def as_placed(dots: Surface, molecule: Molecule, settings: Rules, d_link: float) -> Surface:
    """Return dots of a file as `surface_of_molecule` returned them: with their molecule, and what follows from its atoms."""
    xyz, radii = molecule.xyz[0].round(3), radii_of(molecule, settings.radii)
    origin = _origin_of(dots, roll_frame(xyz, radii, settings), xyz, radii, settings, d_link)
    return dots.with_origin(replace(origin, molecule=molecule))


def _origin_of(
    dots: Surface, rolled: RolledFrame, xyz: np.ndarray, radii: np.ndarray, settings: Rules, d_link: float
) -> SurfaceOrigin:
    """Return the origin of all dots that were placed on spheres."""
    generator = partial(surface_generator, xyz, radii, settings, d_link, "surface")
    return SurfaceOrigin(None, 0, xyz, settings, d_link, radii, rolled, dots.points.copy(), generator)


def accessible_surface(
    xyz: np.ndarray, radii: np.ndarray, settings: Rules, d_link: float, name: str
) -> Surface:
    """Place dots on the solvent-accessible surface of spheres: where the centre of a probe that touches them can be."""
    rolled = roll_frame(xyz, radii, settings)
    centres = rolled._replace(radii=rolled.rolling.atoms.reach, probe=0.0)
    return centres.surface_for_d_link(settings.density, d_link, name)[0]


def surface_of_surface_atoms(atoms: SurfaceAtoms, settings: Rules, d_link: float) -> Surface:
    """Place dots on the atoms that determine a surface; where these are exact, the dots carry all atoms of the molecule."""
    rolled = roll_frame(atoms.centres, atoms.radii, settings)
    rolled = rolled._replace(atom=atoms.atom[rolled.atom])
    dots, _ = rolled.surface_for_d_link(settings.density, d_link, "surface")
    if not atoms.is_exact:
        return dots
    xyz, radii = atoms.spheres.xyz, atoms.spheres.radii
    generator = partial(surface_generator, xyz, radii, settings, d_link, "surface")
    origin = SurfaceOrigin(
        atoms.molecule, atoms.frame, xyz, settings, d_link, radii, rolled, dots.points.copy(), generator
    )
    return dots.with_origin(origin)


class RolledFrame(Rolled):
    """One frame with the probe rolled over its atoms: places dots of any density, and finds their components."""

    def surface(self, density: float) -> Surface:
        """Place dots of a density."""
        surface = Surface.of_placed(*place_dots(self, lattice_of_density(density)))
        return without_cavities(surface, self.components(surface)) if self.cavities == "remove" else surface

    def components(self, surface: Surface) -> np.ndarray:
        """Return the component of every dot of a surface that was placed here; see `components.components_of`."""
        return components_of_rolled(surface, self)

    def areas_by_kind(self, n_atoms: int) -> np.ndarray:
        """Return the exact contact, saddle and concave area of each atom of the molecule, (A, 3), Å^2."""
        return areas_by_kind(self, n_atoms)

    def surface_for_d_link(
        self, density: float | Auto, d_link: float, name: str, published: Surface | None = None
    ) -> tuple[Surface, float]:
        """Place dots with a density that suits d_link (Å), and return them and the density, dots per Å^2.

        `auto` is `DENSITY`, or more where d_link needs it. How closely dots lie depends on the molecule, so that the density is
        estimated from the share of hydrogens, and the dots are measured once they are placed. Few molecules need more than that:
        their dots are placed again. `name` is for the log, and `published` holds the dots of `DENSITY` where they are placed
        already.
        """
        if not isinstance(density, str):
            return self.surface(density), density
        near = JUST_BELOW * d_link / MIN_D_LINK_PER_SPACING  # a median spacing that suits need not be exact
        density = _below_limit(self._estimate(d_link), d_link, name)
        surface = self.surface(density) if published is None or density != DENSITY else published
        gap = spacing(surface.points, lattice_spacing(lattice_of_density(density)), near)
        # The spacing falls with the root of the density, in about one attempt; measured again, since it need not do so exactly
        while d_link < (least := MIN_D_LINK_PER_SPACING * gap):
            density = _below_limit(density * (DENSITY_RESERVE * least / d_link) ** 2, d_link, name)
            surface = self.surface(density)
            gap = spacing(surface.points, lattice_spacing(lattice_of_density(density)), near)
        if density > DENSITY:
            log.info(
                "%s: %.2f dots per Å^2, so that neighbouring dots lie within d_link = %g Å of one another",
                name, density, d_link,
            )  # fmt: skip
        return surface, density

    def _estimate(self, d_link: float) -> float:
        """Return a density that suits d_link (Å) on nearly all molecules like this one."""
        if len(self.radii) < MIN_ATOMS_TO_ESTIMATE:
            return DENSITY
        hydrogens = float(np.mean(self.radii <= MAX_HYDROGEN_RADIUS))
        return max(DENSITY, (HEAVY_DENSITY - FEWER_WITH_HYDROGENS * hydrogens) * (AUTO_LINK / d_link) ** 2)


def _below_limit(density: float, d_link: float, name: str) -> float:
    """Return a density that suits d_link, Å; raise InputError if it is too high."""
    if density > MAX_DENSITY:
        raise InputError(
            f"{name}: {argument('patches.d_link')} = {d_link:g} Å is so short that it needs more than {MAX_DENSITY:g} dots per "
            f"Å^2; give a larger {argument('patches.d_link')}."
        )
    return density


def roll_frame(xyz: np.ndarray, atom_radii: np.ndarray, settings: Rules) -> RolledFrame:
    """Roll the probe over atoms (A, 3) with radii (A,), Å; positions get the decimals of a PDB file."""
    # A structure gives the same dots before and after it is written to a PDB file
    return roll_spheres(
        xyz.round(3), atom_radii, settings.probe_radius, settings.reentrant, settings.cavities
    )


def roll_spheres(
    xyz: ArrayLike,
    radii: ArrayLike,
    probe: float,
    reentrant: Reentrant = "exact",
    cavities: Cavities = "keep",
) -> RolledFrame:
    """Roll the probe over spheres; arguments are those of `molecular_surface`, and whether to keep or remove cavities."""
    if reentrant not in ("exact", "dms"):
        raise InputError(f"{argument('surface.reentrant')} is {reentrant!r}; it must be 'exact' or 'dms'.")
    return RolledFrame(*roll_checked(xyz, radii, probe, reentrant == "exact", cavities))


def rolled_atoms(atoms: SurfaceOrigin) -> RolledFrame:
    """Return the probe rolled over the atoms of dots: as they were placed, or anew by the rules of their origin."""
    rules = atoms.rules
    if atoms.rolled is not None:
        return atoms.rolled
    return roll_spheres(atoms.xyz, atoms.radii, rules.probe_radius, rules.reentrant, rules.cavities)


def density_for_d_link(
    xyz: np.ndarray, atom_radii: np.ndarray, settings: Rules, d_link: float, name: str
) -> float:
    """Return the density on atoms (A, 3), Å, that suits d_link (Å); where the config sets it, no surface is generated."""
    if not isinstance(settings.density, str):
        return settings.density
    return roll_frame(xyz, atom_radii, settings).surface_for_d_link(settings.density, d_link, name)[1]


def surface_generator(
    xyz: np.ndarray, atom_radii: np.ndarray, settings: Rules, d_link: float, name: str
) -> tuple[Callable[[np.ndarray], Surface], np.ndarray]:
    """Return how dots are placed on moved atoms (A, 3), Å, at the density for their positions `xyz`, and these positions."""
    density = density_for_d_link(xyz, atom_radii, settings, d_link, name)
    return lambda moved: roll_frame(moved, atom_radii, settings).surface(density), xyz.round(3)


def molecular_surface(
    xyz: ArrayLike,
    radii: ArrayLike,
    probe: float = PROBE_RADIUS,
    density: float = DENSITY,
    reentrant: Reentrant = "exact",
) -> Surface:
    """Generate the solvent-excluded surface of spheres `xyz` (A, 3) and `radii` (A,), Å; dots are grouped by atom, in order.

    `DENSITY`, in dots per Å^2, gives the dots of DMS at `-d 1.0`. `reentrant` 'dms' gives them with its concave dots inside other
    probes, its uncovered narrow saddles and, on a few buried atoms, dots that no probe can touch.
    """
    return roll_spheres(xyz, radii, probe, reentrant).surface(density)


def lattice_of_density(density: float) -> float:
    """Return the dots per Å^2 of the lattice for a density of the surface."""
    if not 0 < density < np.inf:
        raise InputError(f"{argument('surface.density')} is {density}; it must be a positive number.")
    return LATTICE * (density / DENSITY)
