"""Noise floors: Z between two descriptions of the same surface, or of nearly the same surface.

A Z below that of fresh dots does not mean a better description of the surface: the subset contains some of the very dots with
which it is compared. All dots are used on both sides.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from sparsurf import progress
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import estimate
from sparsurf.files import read_archive, read_bytes
from sparsurf.molecules.conformations import determines_rotation, superpose
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.patches import descriptors
from sparsurf.patches.index import build_index
from sparsurf.recovery.recovering import recover
from sparsurf.surfaces.surface import Surface

DRAWS = 10  # sets of fresh dots, and rotations: they determine the required numbers of dots
FEW_DRAWS = 3  # of displaced atoms; and of all floors if many proteins are measured, as those differ more
ATOM_DISPLACEMENTS = (0.1, 0.3)  # Å, rms: a good and a fair crystal structure
TIME_GAPS_PS = (1.0, 20.0, 100.0)  # between two frames
DECIMALS = 12  # of rotation matrices
FRESH = "fresh dots"
TURNED = "turned"


def floor_column(floor: str) -> str:
    """Return the name of the column with Z of a noise floor, in tables with one column per floor."""
    return "Z_resampled" if floor == FRESH else f"Z_{floor.replace(' ', '_')}"


def measure_floors(
    prepared: PreparedSurface,
    n_tests: int,
    generate_surface: Callable[[np.ndarray], Surface] | None = None,
    atoms: np.ndarray | None = None,
    frames: Mapping[float, Sequence[np.ndarray]] | None = None,
    moved: Sequence[float] = ATOM_DISPLACEMENTS,
    draws: int = DRAWS,
) -> dict[str, np.ndarray]:
    """Measure the noise floors of one surface: by name, (D, T) distances between descriptors for D draws at T test dots.

    `generate_surface` makes a Surface of positions of atoms, (A, 3) Å; without it, fresh dots are placed on the surface
    recovered from all dots, and atoms cannot be displaced. `frames` lists positions that much earlier or later (ps),
    superposed on `atoms`; `moved` are rms displacements of the atoms in Å. `turned` are fresh dots of the rotated molecule,
    described in that orientation.
    """
    tests = prepared.draw_tests(n_tests)
    test_points, centre = prepared.points[tests], prepared.points.mean(axis=0)
    rng, patches = prepared.stream("floors"), prepared.patches
    z_tot, _ = prepared.describe(tests)

    def distances(points: np.ndarray, normals: np.ndarray, centres: np.ndarray) -> np.ndarray:
        index = build_index(points, normals, patches.d_link)
        z, _ = descriptors.describe(
            index, centres, patches.r_zernike, True, prepared.threads, patches.descriptor
        )
        return np.linalg.norm(z - z_tot, axis=1)

    z_of_floor: dict[str, list[np.ndarray]] = {FRESH: [], TURNED: []}
    for _ in progress.progress_bar(range(draws), "noise floors"):
        rotation = random_rotation(rng)
        points, normals = _fresh_dots(prepared, generate_surface, atoms, centre, rotation)
        z_of_floor[FRESH].append(
            distances(rotate(points, rotation) + centre, rotate(normals, rotation), test_points)
        )
        z_of_floor[TURNED].append(distances(points, normals, rotate(test_points - centre, rotation.T)))
    if generate_surface is not None and atoms is not None:
        for rms in moved:
            displaced = [atoms + rms / np.sqrt(3) * rng.normal(size=atoms.shape) for _ in range(FEW_DRAWS)]
            z_of_floor[f"atoms moved {rms:g} Å"] = z = []
            for xyz in displaced:
                surface = generate_surface(xyz)
                z.append(distances(surface.points, surface.normals, test_points))
        test_atoms = prepared.surface.atom[tests]
        for gap, positions in (frames or {}).items():
            z_of_floor[f"frames {gap:g} ps apart"] = z = []
            for xyz in positions:
                surface = generate_surface(xyz)
                z.append(distances(surface.points, surface.normals, test_points + (xyz - atoms)[test_atoms]))
    return {name: np.array(z) for name, z in z_of_floor.items()}


def floors_table(distances: Mapping[str, np.ndarray]) -> pd.DataFrame:
    """Tabulate what `measure_floors` measured: floor, Z, se, low, high (95 %), draws, test_dots."""
    rows = []
    for name, z in distances.items():
        mean = estimate(z)
        ends = {"Z": mean.mean, "se": mean.error, "low": mean.low, "high": mean.high}
        rows.append({"floor": name, **ends, "draws": len(z), "test_dots": z.shape[1]})
    return pd.DataFrame(rows)


def write_distances(path: str | Path, distances: Mapping[str, np.ndarray]) -> None:
    """Write what `measure_floors` measured as npz."""
    with open(path, "wb") as stream:
        np.savez(stream, allow_pickle=False, **distances)


def read_distances(path: str | Path) -> dict[str, np.ndarray]:
    """Read what `write_distances` wrote; raise InputError if the file is damaged."""
    return read_archive(read_bytes(path), path, "is damaged: delete it, it will be computed again")


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    """Draw a rotation matrix, (3, 3), uniformly; rounded, since the last bits of LAPACK depend on the processor."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return (q * np.sign(np.linalg.det(q))).round(DECIMALS)


def rotate(points: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Compute points @ rotation, (n, 3), with the same bits everywhere, unlike BLAS: dots at equal distances need them."""
    return sum((points[:, k : k + 1] * rotation[k] for k in (1, 2)), points[:, :1] * rotation[0])


def _fresh_dots(
    prepared: PreparedSurface,
    generate_surface: Callable[[np.ndarray], Surface] | None,
    atoms: np.ndarray | None,
    centre: np.ndarray,
    rotation: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return points and normals of other dots of the same surface, rotated about the mean dot."""
    if generate_surface is not None and atoms is not None:
        surface = generate_surface(rotate(atoms - centre, rotation.T))
        return surface.points, surface.normals
    points, normals = rotate(prepared.points - centre, rotation.T), rotate(prepared.normals, rotation.T)
    return recover(points, normals, prepared.density, threads=prepared.threads, keep=False)


def read_frames_around(
    frames: str,
    conformation: str,
    structure: str,
    trajectory: str,
    options: Mapping[str, Any],
    atoms: np.ndarray,
) -> dict[float, list[np.ndarray]] | None:
    """Read the frames `TIME_GAPS_PS` before and after a conformation of the table `frames`; None if its time is unknown."""
    table = pd.read_csv(frames).set_index("conformation")
    time = float(table["time_ps"].loc[conformation])
    if not np.isfinite(time):
        return None
    times = [time, *(time + sign * gap for gap in TIME_GAPS_PS for sign in (-1, 1))]
    return frames_at_gaps(read_molecule(structure, trajectory, times=times, **options), atoms, time)


def frames_at_gaps(molecule: Molecule, atoms: np.ndarray, time: float) -> dict[float, list[np.ndarray]]:
    """Select frames before and after a time, superposed on the atoms then, (A, 3) Å by gap in ps; none for atoms on a line."""
    by_gap = {}
    for gap in TIME_GAPS_PS:
        frames = [
            frame
            for sign in (-1, 1)
            for frame in np.flatnonzero(np.abs(molecule.time_ps - time - sign * gap) < 1e-3)[:1]
        ]
        if frames and determines_rotation(molecule.xyz[frames], slice(None), atoms):
            by_gap[gap] = list(superpose(molecule.xyz[frames], slice(None), atoms))
    return by_gap
