"""Noise floors: Z between two descriptions of the same surface, or of one that hardly differs.

A Z below that of fresh dots tells that a subset holds the very dots it is measured against, not that it describes
the surface better. All dots take part on both sides.
"""

import numpy as np
import pandas as pd

from sparsurf import progress
from sparsurf.molecules.conformations import superpose
from sparsurf.patches import descriptors
from sparsurf.patches.index import build_index
from sparsurf.recovery.recovering import recover
from sparsurf.study.statistics import estimate

DRAWS = 10  # sets of fresh dots and turns: what is enough rests on them
FEW_DRAWS = 3  # of moved atoms; and of all where many proteins are measured, which scatter more
ATOM_DISPLACEMENTS = (0.1, 0.3)  # Å, rms displacement of the atoms: a good and a fair crystal structure
TIME_GAPS_PS = (1.0, 20.0, 100.0)  # ps between two frames
FRESH = "fresh dots"
TURNED = "turned"


def noise_floors(
    evaluator, n_tests, lay=None, atoms=None, frames=None, moved=ATOM_DISPLACEMENTS, draws=DRAWS
):
    """Table of the floors of one surface.

    Parameters
    ----------
    evaluator : Evaluator
    n_tests : int
    lay : callable, optional
        Places of the atoms (A, 3), Å -> their Surface; without it, fresh dots are laid on the surface recovered from
        all dots, and atoms cannot be moved.
    atoms : (A, 3) float64, Å, where the atoms are
    frames : dict, optional
        ps -> list of places of the atoms (A, 3) so much earlier or later, superposed on `atoms`.
    moved : sequence of float
        Å, rms displacements of the atoms.
    draws : int
        Sets of fresh dots, and turns.

    Returns
    -------
    DataFrame: floor, Z, se, low, high (95 %), draws, test_dots; a row for each floor that can be had. `turned` are the
    fresh dots of the turned molecule, described as it lies; `fresh dots` the same turned back.
    """
    tests = evaluator.draw_tests(n_tests)
    place, around = evaluator.points[tests], evaluator.points.mean(axis=0)
    rng = evaluator.stream("floors")
    found = {FRESH: [], TURNED: []}
    z_tot, _ = evaluator.describe(tests)

    def against(surface, place):
        index = build_index(*surface, evaluator.d_link)
        z, _ = descriptors.describe(
            index, place, evaluator.r_zernike, True, evaluator.threads, evaluator.descriptor
        )
        return np.linalg.norm(z - z_tot, axis=1)

    for _ in progress.each(range(draws), "noise floors"):
        turn = random_rotation(rng)
        points, normals = _fresh(evaluator, lay, atoms, around, turn)
        found[FRESH].append(against(((points @ turn) + around, normals @ turn), place))
        found[TURNED].append(against((points, normals), (place - around) @ turn.T))
    own = evaluator.surface.atom[tests] if lay else None
    for rms in moved if lay else ():
        others = [atoms + rms / np.sqrt(3) * rng.normal(size=atoms.shape) for _ in range(FEW_DRAWS)]
        found[f"atoms moved {rms:g} Å"] = [against(_laid(lay(xyz)), place) for xyz in others]
    for gap, others in (frames or {}).items():
        found[f"frames {gap:g} ps apart"] = [
            against(_laid(lay(xyz)), place + (xyz - atoms)[own]) for xyz in others
        ]
    return pd.DataFrame([_row(name, np.array(z)) for name, z in found.items()])


def random_rotation(rng):
    """A random rotation, (3, 3), every one equally likely."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


def _fresh(evaluator, lay, atoms, around, turn):
    """Other dots of the same surface, in a turned frame around the mean dot."""
    if lay:
        return _laid(lay((atoms - around) @ turn.T))
    points, normals = (evaluator.points - around) @ turn.T, evaluator.normals @ turn.T
    return recover(points, normals, evaluator.density, threads=evaluator.threads, keep=False)


def _laid(surface):
    return surface.points, surface.normals


def _row(name, z):
    """One floor from its distances (D, T)."""
    found = estimate(z)
    value, se, (low, high) = found.mean, found.error, (found.low, found.high)
    return {
        "floor": name,
        "Z": value,
        "se": se,
        "low": low,
        "high": high,
        "draws": len(z),
        "test_dots": z.shape[1],
    }


def frames_at_gaps(molecule, atoms, time):
    """Frames before and after a time, superposed on the atoms of that time.

    Parameters
    ----------
    molecule : Molecule, the frames of a trajectory at such times, or all, with the atoms of `atoms`
    atoms : (A, 3) float64, Å
    time : float, ps

    Returns
    -------
    dict: ps -> list of (A, 3); no entry where the trajectory has no such frame.
    """
    found = {}
    for gap in TIME_GAPS_PS:
        at = [
            k
            for sign in (-1, 1)
            for k in np.flatnonzero(np.abs(molecule.time_ps - time - sign * gap) < 1e-3)[:1]
        ]
        if at:
            found[gap] = list(superpose(molecule.xyz[at], slice(None), atoms))
    return found
