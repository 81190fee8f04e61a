"""The solvent-excluded surface of atoms as dots: our own, or those of the program DMS."""

import logging
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from sparsurf import InputError
from sparsurf.patches import SPARSE, build_index, spacing
from sparsurf.placement import LATTICE, lay_dots
from sparsurf.surface import Surface, read_surface

log = logging.getLogger("sparsurf")

FARTHEST = 1e6  # Å, largest coordinate
# Dots per Å^2 that count as DMS's `-d 1.0`; A1 of TDP-43 gets 20045 dots on 3742 Å^2.
DENSITY = 5.35
RESERVE = 1.02  # by how much an automatic density exceeds what D_link needs


def fitting_density(xyz, radii, settings, d_link, name):
    """Dots per Å^2 of the config's `surface`: the number given, or for `auto` the least from DENSITY on that suits D_link.

    Atoms without hydrogens have wider spheres, on which the same density lays dots farther apart.

    Parameters
    ----------
    xyz, radii : (A, 3) and (A,), Å
    settings : dict
        The config's `surface`.
    d_link : float
        Å; must be at least `patches.SPARSE` times the median spacing of the dots.
    name : str
        Conformation, for the log.
    """
    if settings["density"] != "auto":
        return settings["density"]
    first = molecular_surface(xyz, radii, settings["probe_radius"], DENSITY, settings["reentrant"])
    gap = spacing(build_index(first.points, first.normals, d_link))
    if not d_link < SPARSE * gap:
        return DENSITY
    density = DENSITY * (RESERVE * SPARSE * gap / d_link) ** 2
    log.warning(
        "%s: %.2f dots per Å^2 instead of %.2f, so that D_link = %g Å is %.1f times the median spacing of the dots; d under "
        "'kept' depends on it",
        name, density, DENSITY, d_link, SPARSE,
    )  # fmt: skip
    return density


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
    xyz, radii = np.asarray(xyz, dtype=float), np.asarray(radii, dtype=float)
    if xyz.ndim != 2 or xyz.shape[1] != 3 or len(xyz) == 0 or radii.shape != (len(xyz),):
        raise InputError(f"surface: needs (A, 3) centres and (A,) radii, not {xyz.shape} and {radii.shape}.")
    if not (np.abs(xyz) < FARTHEST).all():
        raise InputError(f"surface: coordinates must be numbers below {FARTHEST:.0f} Å.")
    if not (np.isfinite(radii) & (radii > 0)).all():
        raise InputError("surface: atomic radii must be positive numbers.")
    for name, value in (("probe_radius", probe), ("density", density)):
        if not 0 < value < np.inf:
            raise InputError(f"surface.{name} is {value}; it must be a positive number.")
    if reentrant not in ("exact", "dms"):
        raise InputError(f"surface.reentrant is {reentrant!r}; it must be 'exact' or 'dms'.")
    kept = _distinct(xyz, radii)
    lattice = LATTICE * (density / DENSITY)
    exact = reentrant == "exact"
    points, normals, area, kind, atom = lay_dots(xyz[kept], radii[kept], float(probe), lattice, exact)
    return Surface(points, normals, area, kind, kept[atom])


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


def surface_by_dms_program(path_to_pdb, probe=1.4, density=DENSITY, program="dms"):
    """Surface by UCSF's program DMS, if there is one.

    Parameters
    ----------
    path_to_pdb : PDB file of one model, all of whose atoms are used
    probe : Å
    density : dots per Å^2, as for `molecular_surface`
    program : name looked up on the PATH

    Returns
    -------
    Surface; `atom` counts the atoms of the PDB file

    Raises
    ------
    InputError : no such program, or it fails
    """
    executable = shutil.which(program)
    if executable is None:
        raise InputError(f"surface.method dms needs the program {program} on the PATH; else use analytic.")
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(path_to_pdb, Path(folder, "in.pdb"))
        command = [executable, "in.pdb", "-a", "-n", "-d", f"{density / DENSITY:.6g}"]
        command += ["-w", f"{probe:.6g}", "-o", "out.dms"]
        run = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace")
        output = Path(folder, "out.dms")
        if run.returncode != 0 or not output.is_file():
            reason = (run.stderr.strip().splitlines() or [f"exit status {run.returncode}"])[-1]
            raise InputError(f"{program} made no surface of {path_to_pdb}: {reason}")
        return read_surface(output)
