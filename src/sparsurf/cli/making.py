"""`surface` and `mesh`: from a molecule to its surface."""

from types import SimpleNamespace

from sparsurf.cli.inputs import DENSITY, LENGTH, PROBE, arrays, as_molecule, check_frame
from sparsurf.patches.index import D_LINK
from sparsurf.surfaces.molecular_surface import fitting_surface
from sparsurf.surfaces.radii import radii as atomic_radii
from sparsurf.surfaces.spacing import DENSITY as PUBLISHED
from sparsurf.threads import available_cores


def surface(molecule, *, frame=0, probe=1.4, density="auto", radii="dms", d_link=D_LINK):
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

    Returns
    -------
    Surface
        With `points` and `normals` (N, 3), `area` (N,) in Å^2, `kind` (N,) (0 contact, 1 saddle, 2 concave) and
        `atom` (N,), the index of the atom that each dot belongs to.

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
    return fitting_surface(molecule, frame, values, rules_of(probe, density), d_link, "surface")[0]


def mesh(molecule, *, frame=0, probe=1.4, density=PUBLISHED, radii="dms"):
    """Solvent-excluded surface of a molecule as closed triangles.

    Parameters
    ----------
    molecule, frame, probe, radii : as for `surface`
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
    """
    from sparsurf.surfaces.mesh import molecular_mesh, step_of  # here: dots need none of its kernels

    density, probe = DENSITY.check(density, "density"), PROBE.check(probe, "probe")
    molecule, frame, values = _spheres(molecule, frame, radii)
    return molecular_mesh(molecule.xyz[frame].round(3), values, probe, step_of(density), available_cores())


def _spheres(molecule, frame, table):
    """A molecule, a frame of it, and the radii of its atoms, from all that `surface` takes."""
    if isinstance(molecule, tuple) and len(molecule) == 2:
        xyz, values = arrays(molecule, "molecule")
        return SimpleNamespace(xyz=xyz[None]), 0, values
    molecule = as_molecule(molecule)
    check_frame(molecule, frame, "the molecule")
    return molecule, frame, atomic_radii(molecule, table)


def rules_of(probe, density):
    """The config's `surface` of what the functions and commands make; a density or 'auto'."""
    return {"method": "analytic", "probe_radius": probe, "density": density, "reentrant": "exact"}
