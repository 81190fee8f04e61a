"""A few points with normals on the surface of a molecule, or of every structure of a folder, for whoever learns on surfaces."""

from __future__ import annotations

import logging
import multiprocessing
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.api.inputs import MoleculeLike
from sparsurf.api.surfaces import _spheres
from sparsurf.arguments import CAVITIES, DENSITY, NUMBER_OF_DOTS, PROBE, SEED, Limits, check_choice
from sparsurf.errors import InputError
from sparsurf.molecules.formats import STRUCTURES, stem, suffix
from sparsurf.patches.index import build_grid
from sparsurf.sampling.farthest_point import farthest_point_sampling
from sparsurf.streams import DEFAULT_SEED, stream
from sparsurf.suggestions import public
from sparsurf.surfaces.molecular_surface import MAX_DENSITY, RolledFrame, roll_spheres
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.spacing import DENSITY as PUBLISHED_DENSITY
from sparsurf.surfaces.surface import Surface

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

log = logging.getLogger("sparsurf")

N_POINTS = 1024
DOTS_PER_POINT = 2.0  # placed for each point that is chosen, at least
# of the positions that are compared: farther apart than rounding, far closer than dots
STEPS_PER_ANGSTROM = 2**16
JOBS = Limits(1, 1024, whole=True, open_low=False)
STRUCTURES_PER_JOB = 4  # that wait for their turn


@public()
def points(
    molecule: MoleculeLike | tuple[ArrayLike, ArrayLike],
    n_dots: int | None = None,
    *,
    density: float | None = None,
    seed: int = DEFAULT_SEED,
    frame: int = 0,
    probe_radius: float = PROBE_RADIUS,
    radii: str = "dms",
    cavities: str = "remove",
) -> tuple[np.ndarray, np.ndarray]:
    """Choose points with normals on the solvent-excluded surface of a molecule, as far from one another as possible.

    The points lie exactly on the surface, and their normals are analytic. The same molecule gives the same bytes on every
    machine.

    Parameters
    ----------
    molecule, frame, probe_radius, radii : as for `surface`
    n_dots : int
        Number of points; 1024 if there is no `density`.
    density : float
        Instead of `n_dots`: points per Å^2.
    seed : int
        Of the first point, from which the others follow.
    cavities : {'remove', 'keep'}
        Whether points lie in closed cavities inside the molecule, too.

    Returns
    -------
    points : (n_dots, 3) float32, Å
    normals : (n_dots, 3) float32, unit vectors, outward
        In the order of choice: the first m points are as far from one another as m points can be found to be.

    Raises
    ------
    InputError
        One sentence on what is wrong, such as more points than `n_dots` can be placed.

    Examples
    --------
    >>> import sparsurf
    >>> points, normals = sparsurf.points("data/tdp43/topology.pdb", n_dots=512)
    >>> points.shape, normals.dtype
    ((512, 3), dtype('float32'))
    >>> len(sparsurf.points("data/tdp43/topology.pdb", density=0.5)[0])
    2260
    """
    if n_dots is not None and density is not None:
        raise InputError("points: give either n_dots or density, not both.")
    probe_radius, seed = PROBE.check(probe_radius, "probe_radius"), SEED.check(seed, "seed")
    check_choice(cavities, CAVITIES, "cavities")
    if density is not None:
        density = DENSITY.check(density, "density")
    else:
        n_dots = NUMBER_OF_DOTS.check(N_POINTS if n_dots is None else n_dots, "n_dots")
    atoms, frame, atom_radii = _spheres(molecule, frame, radii)
    rolled = roll_spheres(atoms.xyz[frame].round(3), atom_radii, probe_radius, cavities=cavities)
    dots, n = _dense_dots(rolled, n_dots, density)
    # Positions that differ by rounding alone, on another machine, must not change the choice
    grid = build_grid(np.rint(dots.points * STEPS_PER_ANGSTROM) / STEPS_PER_ANGSTROM)
    chosen = farthest_point_sampling(grid, n, stream(seed, "points"))
    return dots.points[chosen].astype(np.float32), dots.normals[chosen].astype(np.float32)


def _dense_dots(rolled: RolledFrame, n_dots: int | None, density: float | None) -> tuple[Surface, int]:
    """Place dots from which points can be chosen, and return the number of points."""
    placed = max(PUBLISHED_DENSITY, DOTS_PER_POINT * (density or 0.0))
    while True:
        placed = min(placed, float(MAX_DENSITY))
        dots = rolled.surface(placed)
        n = max(1, round(density * float(dots.area.sum()))) if density else n_dots
        assert n is not None  # one of both is given
        if len(dots) >= DOTS_PER_POINT * n or (placed == MAX_DENSITY and len(dots) >= n):
            return dots, n
        if placed == MAX_DENSITY:
            raise InputError(
                f"points: {n:,} points on {dots.area.sum():,.0f} Å^2 are more than {MAX_DENSITY} per Å^2; ask for fewer."
            )
        placed *= 1.05 * DOTS_PER_POINT * n / len(dots)


@public()
def points_of(
    folder: str | Path,
    n_dots: int | None = None,
    *,
    density: float | None = None,
    seed: int = DEFAULT_SEED,
    probe_radius: float = PROBE_RADIUS,
    radii: str = "dms",
    cavities: str = "remove",
    jobs: int = 1,
) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Choose points with normals on the surface of every structure of a folder.

    Parameters
    ----------
    folder : path of a folder; its .pdb, .ent, .cif and .mmcif files are read, also .gz
    n_dots, density, seed, probe_radius, radii, cavities : as for `points`, the same for every structure
    jobs : int
        Number of processes; the result does not depend on it.

    Yields
    ------
    name : str, name of the file without its suffixes
    points, normals : (n_dots, 3) float32
        One structure after the other, by name. One that fails is left out with a warning.

    Raises
    ------
    InputError
        The folder holds no structure, or two of the same name.

    Examples
    --------
    >>> import sparsurf
    >>> for name, points, normals in sparsurf.points_of("data/tdp43", n_dots=256):
    ...     print(name, points.shape)
    topology (256, 3)
    """
    jobs, files = JOBS.check(jobs, "jobs"), structures_in(folder)
    settings: dict[str, Any] = {"density": density, "seed": seed, "probe_radius": probe_radius}
    settings |= {"radii": radii, "cavities": cavities}
    choose = partial(_points_or_reason, n_dots=n_dots, settings=settings)
    results = map(choose, files.values()) if jobs == 1 else _in_processes(choose, files.values(), jobs)
    for name, result in zip(files, results, strict=True):
        if isinstance(result, str):
            log.warning("%s is left out: %s", name, result)
        else:
            yield name, *result


def structures_in(folder: str | Path) -> dict[str, Path]:
    """Return the structures of a folder by name, which is that of the file without its suffixes."""
    if not Path(folder).is_dir():
        raise InputError(f"{folder} is not a folder; give one with structures.")
    files: dict[str, Path] = {}
    for path in sorted(Path(folder).iterdir()):
        if suffix(path) in STRUCTURES and path.is_file():
            name = stem(path)
            if name in files:
                raise InputError(
                    f"{folder} holds {files[name].name} and {path.name}, which have one name; rename one."
                )
            files[name] = path
    if not files:
        raise InputError(f"{folder} holds no structure ({', '.join(STRUCTURES)}, also .gz).")
    return files


def _points_or_reason(
    path: Path, n_dots: int | None, settings: dict[str, Any]
) -> tuple[np.ndarray, np.ndarray] | str:
    """Return the points and normals of a structure, or why there are none."""
    try:
        return points(path, n_dots, **settings)
    except InputError as error:
        return str(error)
    except MemoryError:
        return f"{path} needs more memory than there is."


def _in_processes(choose: Any, paths: Any, jobs: int) -> Iterator[Any]:
    """Yield the results of a function of a path in order; few of them wait at a time."""
    methods = multiprocessing.get_all_start_methods()
    context = multiprocessing.get_context("fork" if "fork" in methods else None)
    waiting: deque[Future] = deque()
    with ProcessPoolExecutor(jobs, context) as pool:
        for path in paths:
            waiting.append(pool.submit(choose, path))
            if len(waiting) >= STRUCTURES_PER_JOB * jobs:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
