"""The solvent-excluded surface of atoms as dots: our own, or those of the program DMS."""

import logging
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from sparsurf import InputError
from sparsurf.surfaces.formats.dms import surface_by_dms_program
from sparsurf.surfaces.placing_dots import LATTICE, place_dots
from sparsurf.surfaces.spacing import DENSITY, SPARSE, spacing
from sparsurf.surfaces.surface import Surface

log = logging.getLogger("sparsurf")

FARTHEST = 1e6  # Å, largest coordinate
LARGEST = 100  # Å, atomic radius
RESERVE = 1.02  # by how much an automatic density exceeds what D_link needs
MOST_DENSITY = 100  # dots per Å^2, also of a density that is given
_told = set()  # names and D_link whose raised density the log has told of: once for all calls


def fitting_surface(molecule, position, atom_radii, settings, d_link, name, tell=True):
    """Surface of one frame with the density of the config's `surface`, `auto` being the least from DENSITY on that suits D_link.

    Atoms without hydrogens have wider spheres, on which the same density places dots farther apart. How much closer
    more dots lie depends on the molecule, so the density grows until they lie close enough.

    Parameters
    ----------
    molecule, position, atom_radii, settings : as for `surface_of`
    d_link : float
        Å; must be at least `spacing.SPARSE` times the median spacing of the dots.
    name : str
        Conformation, for the log.
    tell : bool
        Whether the log tells of a density above DENSITY, once for a name and a D_link.

    Returns
    -------
    Surface, and its density in dots per Å^2

    Raises
    ------
    InputError : D_link wants more than MOST_DENSITY
    """

    def of_density(density):
        return surface_of(molecule, position, atom_radii, settings | {"density": density})

    if settings["density"] != "auto":
        return of_density(settings["density"]), settings["density"]
    density = DENSITY
    while d_link < (least := SPARSE * spacing((surface := of_density(density)).points)):
        density *= (RESERVE * least / d_link) ** 2
        if density > MOST_DENSITY:
            raise InputError(
                f"{name}: D_link = {d_link:g} Å is so short that it needs more than {MOST_DENSITY:g} dots per Å^2; "
                "give a larger patches.D_link."
            )
    if tell and density > DENSITY and (name, d_link) not in _told:
        _told.add((name, d_link))
        log.warning(
            "%s: %.2f dots per Å^2 instead of %.2f, so that D_link = %g Å is %.1f times the median spacing of the dots; "
            "d under 'as_coded' depends on it",
            name, density, DENSITY, d_link, SPARSE,
        )  # fmt: skip
    return surface, density


def fitting_density(molecule, position, atom_radii, settings, d_link, name, tell=True):
    """The density alone of `fitting_surface`; one that is given is taken as it is, and no surface made."""
    if settings["density"] != "auto":
        return settings["density"]
    return fitting_surface(molecule, position, atom_radii, settings, d_link, name, tell)[1]


def layer(molecule, position, atom_radii, settings, d_link, name):
    """What `study.floors` needs of the atoms of one frame: a function that lays dots on them elsewhere, and their places.

    Parameters
    ----------
    molecule, position, atom_radii, settings, d_link, name : as for `fitting_surface`

    Returns
    -------
    dict: lay, places (A, 3) -> their Surface at the density of this frame; atoms, (A, 3), Å
    """
    density = fitting_density(molecule, position, atom_radii, settings, d_link, name, tell=False)
    rules = settings | {"density": density}

    def lay(xyz):
        return surface_of(replace(molecule, xyz=xyz[None]), 0, atom_radii, rules)

    return {"lay": lay, "atoms": molecule.xyz[position].round(3)}


def surface_of(molecule, position, atom_radii, settings):
    """Surface of one frame of a molecule, as the config's `surface` wants it, the density being a number.

    The atoms stand where a PDB file has them, so that a frame and the file made of it have the same surface.

    Parameters
    ----------
    molecule : Molecule
    position : int
        Of the frame.
    atom_radii : (A,), Å
    settings : dict

    Returns
    -------
    Surface
    """
    probe, density = settings["probe_radius"], settings["density"]
    if settings["method"] == "dms":
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "frame.pdb")
            molecule.write_pdb(path, position)
            return surface_by_dms_program(path, probe, density)
    xyz = molecule.xyz[position].round(3)  # Å, the decimals of a PDB file
    return molecular_surface(xyz, atom_radii, probe, density, settings["reentrant"])


def molecular_surface(xyz, radii, probe=1.4, density=DENSITY, reentrant="exact"):
    """Solvent-excluded surface of a set of spheres (Connolly, J. Appl. Cryst. 16:548, 1983).

    Parameters
    ----------
    xyz : (A, 3), centres of the atoms, Å
    radii : (A,), Å
    probe : radius of the probe, Å
    density : dots per Å^2; DENSITY gives the dots of DMS at `-d 1.0`
    reentrant : 'exact' for the surface itself; 'dms' for the dots that DMS gives, with its concave dots inside
        other probes, its uncovered narrow saddles and, on a few buried atoms, dots that no probe can touch

    Returns
    -------
    Surface, dots grouped by atom in the order of `xyz`

    Raises
    ------
    InputError
    """
    xyz, radii, kept = spheres(xyz, radii, probe)
    if not 0 < density < np.inf:
        raise InputError(f"surface.density is {density}; it must be a positive number.")
    if reentrant not in ("exact", "dms"):
        raise InputError(f"surface.reentrant is {reentrant!r}; it must be 'exact' or 'dms'.")
    lattice = LATTICE * (density / DENSITY)
    exact = reentrant == "exact"
    points, normals, area, kind, atom = place_dots(xyz, radii, float(probe), lattice, exact)
    return Surface(points, normals, area, kind, kept[atom])


def spheres(xyz, radii, probe):
    """Centres and radii of distinct atoms, checked, and which of the given ones these are; see `molecular_surface`."""
    xyz, radii = np.asarray(xyz, dtype=float), np.asarray(radii, dtype=float)
    if xyz.ndim != 2 or xyz.shape[1] != 3 or len(xyz) == 0 or radii.shape != (len(xyz),):
        raise InputError(f"surface: needs (A, 3) centres and (A,) radii, not {xyz.shape} and {radii.shape}.")
    if not (np.abs(xyz) < FARTHEST).all():
        raise InputError(f"surface: coordinates must be numbers below {FARTHEST:.0f} Å.")
    if not ((radii > 0) & (radii <= LARGEST)).all():
        raise InputError(f"surface: atomic radii must be positive numbers of at most {LARGEST} Å.")
    if not 0 < probe < np.inf:
        raise InputError(f"surface.probe_radius is {probe}; it must be a positive number.")
    kept = _distinct(xyz, radii)
    return xyz[kept], radii[kept], kept


def _distinct(xyz, radii):
    """Indices of the atoms without those at the place of another (to 0.001 Å); the largest of each stays."""
    _, place = np.unique(np.round(xyz - xyz[0], 3), axis=0, return_inverse=True)
    by_place = np.lexsort((-radii, place))
    first = np.append(True, np.diff(place[by_place]) != 0)
    left_out = np.sort(by_place[~first])
    if len(left_out):
        message = "surface: %d atoms lie at the place of another and are left out, the first is number %d"
        log.warning(message, len(left_out), left_out[0] + 1)
    return np.sort(by_place[first])
