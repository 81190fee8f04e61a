"""`surface` and `mesh`: from a molecule to its surface."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

from sparsurf import InputError
from sparsurf.cli.inputs import (
    DENSITY,
    LENGTH,
    PROBE,
    agreed,
    arrays,
    as_molecule,
    as_surface,
    check_frame,
    is_file_of_dots,
    origin_of,
    placed_already,
    same_atoms,
)
from sparsurf.molecules.molecule import Molecule
from sparsurf.patches.index import D_LINK
from sparsurf.surfaces.components import table_of_components
from sparsurf.surfaces.molecular_surface import components_of_frame, surface_for_d_link
from sparsurf.surfaces.radii import radii as atomic_radii
from sparsurf.surfaces.spacing import DENSITY as PUBLISHED
from sparsurf.surfaces.surface import Origin, Surface
from sparsurf.threads import available_cores

CAVITIES = ["keep", "remove"]  # a list: what a user gives may have no hash


def surface(molecule, *, frame=0, probe=1.4, density="auto", radii="dms", d_link=D_LINK, cavities="keep"):
    """Solvent-excluded surface of a molecule as dots with normals.

    Parameters
    ----------
    molecule : path of a structure, what `read_molecule` gave, or mdtraj.Trajectory;
        or the pair (xyz, radii) of (A, 3) centres and (A,) radii in Å
    frame : int
        Position of the frame, from 0.
    probe : float
        Radius of the probe in Å.
    density : float or 'auto'
        Dots per Å^2; 'auto' is 5.35, or as many more as `d_link` needs.
    radii : {'dms', 'bondi'}
        Table of atomic radii.
    d_link : float
        Å, distance below which two dots of a patch will count as linked.
    cavities : {'keep', 'remove'}
        Whether the dots of closed cavities inside the molecule count.

    Returns
    -------
    Surface
        With `points` and `normals` (N, 3), `area` (N,) in Å^2, `kind` (N,) (0 contact, 1 saddle, 2 concave) and
        `atom` (N,), the index of the atom that each dot belongs to; the dots know their molecule.

    Raises
    ------
    InputError : one sentence on what is wrong

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> len(dots), dots.points.shape, round(dots.area.sum())
    (24600, (24600, 3), 4560)

    A trajectory that mdtraj holds; nanometres become Å:

    >>> import mdtraj
    >>> trajectory = mdtraj.load("data/tdp43/trajectory.xtc", top="data/tdp43/topology.pdb", stride=500)
    >>> [len(sparsurf.surface(trajectory, frame=f)) for f in range(2)]
    [24600, 23274]

    Two spheres of one's own:

    >>> len(sparsurf.surface(([[0, 0, 0], [3, 0, 0]], [1.5, 1.5])))
    364
    """
    probe, d_link = PROBE.check(probe, "probe"), LENGTH.check(d_link, "d_link")
    density = DENSITY.check(density, "density", "auto")
    molecule, frame, values = _spheres(molecule, frame, radii)
    rules = rules_of(probe, density, cavities)
    dots = surface_for_d_link(molecule, frame, values, rules, d_link, "surface")[0]
    how = {"probe": probe, "density": density, "radii": radii, "d_link": d_link, "cavities": cavities}
    if not isinstance(molecule, Molecule):
        return dots
    search = partial(components_of_frame, molecule=molecule, position=frame, atom_radii=values, probe=probe)
    return replace(dots, origin=Origin(molecule, frame, how, search, dots.points))


def components(molecule, dots=None, *, frame=0, probe=1.4, radii="dms"):
    """Connected components of a surface: the outside of each molecule, and the closed cavities inside.

    Parameters
    ----------
    molecule, frame, probe, radii : as for `surface`
    dots : what `surface` gave for the same; in place of the molecule, where they know theirs

    Returns
    -------
    component : (N,) int, of each dot; 0 has most dots
    table : DataFrame with component, dots, area (Å^2), volume (Å^3) and cavity (bool)

    Raises
    ------
    InputError : one sentence on what is wrong

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> component, table = sparsurf.components(dots)
    >>> table["dots"].tolist(), table["cavity"].tolist()
    ([24376, 224], [False, True])
    """
    if isinstance(molecule, Surface) and dots is None:
        dots, origin = molecule, origin_of(molecule, "components")
        molecule, frame, rules, *_ = agreed(origin, "components", frame=frame, probe=probe, radii=radii)
        probe, radii = rules["probe"], rules["radii"]
    elif dots is None:
        dots = surface(molecule, frame=frame, probe=probe, radii=radii)
    elif getattr(dots, "origin", None) is not None:
        rules = agreed(dots.origin, "components", probe=probe, radii=radii).rules
        probe, radii = rules["probe"], rules["radii"]
    probe, dots = PROBE.check(probe, "probe"), as_surface(dots)
    molecule, frame, values = _spheres(molecule, frame, radii)
    if isinstance(molecule, Molecule):
        same_atoms(dots, molecule, frame, "components")
    if dots.origin and not dots.placed:
        raise InputError("components: these are not all dots of their surface; give all that surface() gave.")
    if not 0 <= dots.atom.min() <= dots.atom.max() < len(values):
        raise InputError(
            "components: the dots are not those of the molecule; give what surface() gave for it."
        )
    component = components_of_frame(dots, molecule, frame, values, probe)
    return component, table_of_components(dots, component)


def mesh(molecule, *, frame=0, probe=1.4, density=PUBLISHED, radii="dms", cavities="keep"):
    """Solvent-excluded surface of a molecule, or the surface that a few dots give back, as closed triangles.

    Parameters
    ----------
    molecule, frame, probe, radii, cavities : as for `surface`; instead of a molecule its dots, or what `minimal` gave, or
        the path of a file of dots, from which the surface is recovered
    density : float
        Dots per Å^2 that are as fine as the triangles.

    Returns
    -------
    Mesh
        `vertices` (a Surface), `triangles` (F, 3), counterclockwise from outside, and `volume` in Å^3.

    Raises
    ------
    InputError : one sentence on what is wrong

    Examples
    --------
    >>> import sparsurf
    >>> found = sparsurf.mesh("data/tdp43/topology.pdb")
    >>> round(found.volume, -2)
    7900.0
    >>> few = sparsurf.minimal("data/tdp43/topology.pdb", percent=10)
    >>> round(sparsurf.mesh(few).volume, -2)
    7900.0
    """
    from sparsurf.surfaces.mesh import (  # here: dots need none of its kernels
        grid_step_for_density,
        molecular_mesh,
        outer_mesh,
    )

    density, probe = DENSITY.check(density, "density"), PROBE.check(probe, "probe")
    _check_cavities(cavities)
    if isinstance(molecule, Surface) and molecule.placed:
        wishes = {"frame": frame, "probe": probe, "radii": radii, "cavities": cavities}
        molecule, frame, rules, *_ = agreed(molecule.placed, "mesh", **wishes)
        probe, radii, cavities = rules["probe"], rules["radii"], rules["cavities"]
    if isinstance(molecule, Surface) or hasattr(molecule, "weight") or is_file_of_dots(molecule):
        from sparsurf.recovery.mesh import recovered_mesh

        placed_already("mesh", frame=frame, probe=probe, radii=radii)
        few = as_surface(molecule)
        how = {"density": density, "threads": available_cores()}
        found = recovered_mesh(few.points, few.normals, grid_step_for_density(density), **how)
    else:
        molecule, frame, values = _spheres(molecule, frame, radii)
        places = molecule.xyz[frame].round(3)
        found = molecular_mesh(places, values, probe, grid_step_for_density(density), available_cores())
    return outer_mesh(found) if cavities == "remove" else found


def _spheres(molecule, frame, table):
    """A molecule, a frame of it, and the radii of its atoms, from all that `surface` takes."""
    if isinstance(molecule, tuple) and len(molecule) == 2:
        xyz, values = arrays(molecule, "molecule")
        return SimpleNamespace(xyz=xyz[None]), 0, values
    molecule = as_molecule(molecule)
    check_frame(molecule, frame, "the molecule")
    return molecule, frame, atomic_radii(molecule, table)


def rules_of(probe, density, cavities):
    """The config's `surface` of what the functions and commands make; a density or 'auto'."""
    _check_cavities(cavities)
    rules = {"method": "analytic", "probe_radius": probe, "density": density, "reentrant": "exact"}
    return rules | {"cavities": cavities}


def _check_cavities(cavities):
    if cavities not in CAVITIES:
        raise InputError(f"cavities is {cavities!r}; it must be {' or '.join(CAVITIES)}.")
