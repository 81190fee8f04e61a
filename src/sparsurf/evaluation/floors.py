"""The noise floor: Z between two sets of dots of the same surface.

A Z below that of fresh dots does not mean a better description of the surface: the subset contains some of the very dots with
which it is compared. All dots are used on both sides.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from sparsurf import progress
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import estimate
from sparsurf.patches import descriptors
from sparsurf.patches.index import build_index
from sparsurf.recovery.interpolated_surface import interpolate_surface
from sparsurf.surfaces.surface import Surface

if TYPE_CHECKING:
    import pandas as pd

SETS_OF_FRESH_DOTS = 10  # sets of fresh dots
ROTATION_DECIMALS = 12  # Rotation matrices are rounded to so many decimals.
FRESH = "fresh dots"


def fresh_dots(
    prepared: PreparedSurface,
    n_tests: int,
    generate_surface: Callable[[np.ndarray], Surface] | None = None,
    atoms: np.ndarray | None = None,
    draws: int = SETS_OF_FRESH_DOTS,
) -> np.ndarray:
    """Measure the distances between the descriptors of the dots and of other dots of the same surface, (draws, T).

    `generate_surface` makes a Surface of positions of atoms, (A, 3) Å; without it, the other dots are placed on the surface
    that is reconstructed from all dots. They are placed on the turned molecule, and turned back.
    """
    tests = prepared.draw_tests(n_tests)
    test_points, centre = prepared.points[tests], prepared.points.mean(axis=0)
    rng, patches = prepared.stream("floors"), prepared.patches
    z_tot, _ = prepared.describe(tests)
    distances = []
    for _ in progress.progress_bar(range(draws), "noise floor"):
        rotation = random_rotation(rng)
        points, normals = _other_dots(prepared, generate_surface, atoms, centre, rotation)
        index = build_index(rotate(points, rotation) + centre, rotate(normals, rotation), patches.d_link)
        z, _ = descriptors.describe_patches(
            index, test_points, patches.r_zernike, True, prepared.threads, patches.descriptor
        )
        distances.append(np.linalg.norm(z - z_tot, axis=1))
    return np.array(distances)


def floors_table(distances: np.ndarray) -> pd.DataFrame:
    """Tabulate what `fresh_dots` measured: floor, Z, se, low, high (95 %), draws, test_dots."""
    import pandas as pd  # here: it takes long to load

    draws, test_dots = distances.shape
    mean = estimate(distances)
    ends = {"Z": mean.mean, "se": mean.error, "low": mean.low, "high": mean.high}
    return pd.DataFrame([{"floor": FRESH, **ends, "draws": draws, "test_dots": test_dots}])


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    """Draw a rotation matrix, (3, 3), uniformly; rounded, since the last bits of LAPACK depend on the processor."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return (q * np.sign(np.linalg.det(q))).round(ROTATION_DECIMALS)


def rotate(points: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Compute points @ rotation, (n, 3), with the same bits everywhere, unlike BLAS: dots at equal distances need them."""
    return sum((points[:, k : k + 1] * rotation[k] for k in (1, 2)), points[:, :1] * rotation[0])


def _other_dots(
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
    return interpolate_surface(points, normals, prepared.density, threads=prepared.threads, keep=False)
