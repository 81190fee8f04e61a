"""The solvent-excluded surface of atoms as dots: our own, or those of the program DMS."""

import logging
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from sparsurf import InputError
from sparsurf.surfaces.components import components_of, without_cavities
from sparsurf.surfaces.formats.dms import surface_by_dms_program
from sparsurf.surfaces.placing_dots import LATTICE, place_dots, spheres
from sparsurf.surfaces.spacing import DENSITY, SPARSE, spacing
from sparsurf.surfaces.surface import Surface

log = logging.getLogger("sparsurf")

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
            "%s: %.2f dots per Å^2 instead of %.2f, as patches of fewer fall apart at D_link = %g Å; "
            "a density that is given stays",
            name, density, DENSITY, d_link,
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
            surface = surface_by_dms_program(path, probe, density)
    else:
        surface = molecular_surface(
            _places(molecule, position), atom_radii, probe, density, settings["reentrant"]
        )
    if settings.get("cavities") != "remove":
        return surface
    return without_cavities(surface, components_in(surface, molecule, position, atom_radii, probe))


def components_in(surface, molecule, position, atom_radii, probe):
    """Component of every dot of the surface of one frame, (N,), see `components.components_of`."""
    return components_of(surface, _places(molecule, position), atom_radii, probe)


def _places(molecule, position):
    """Centres of the atoms of a frame as a PDB file has them, (A, 3), Å."""
    return molecule.xyz[position].round(3)


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
