"""Choose dots that touch every exposed atom, and more where the surface that is rebuilt from them errs.

`recovery.spheres` infers the atoms under few dots. A contact dot for each exposed atom, and one more probe that touches it,
determine the atom, so that such dots determine the surface. They serve this reconstruction alone: the interpolant errs by 20
to 40 % more with them than with the same number of farthest points, and if a tenth of them is lost at random, the mean error
grows from 0.002 to 0.06 to 0.1 Å.
"""

from __future__ import annotations

import heapq
from typing import Protocol

import numpy as np

from sparsurf.errors import InputError
from sparsurf.patches.index import build_grid, select_separated
from sparsurf.recovery.errors import distance_to_surface
from sparsurf.recovery.reconstructing import DENSITY_FOR_SPHERES
from sparsurf.recovery.spheres.rebuilding import Rebuilt, rebuild
from sparsurf.sampling.farthest_point import farthest_after, farthest_point_sampling
from sparsurf.sampling.published import SampledSurface
from sparsurf.surfaces.surface import CONTACT, Surface, SurfaceOrigin

# Of other dots that each exposed atom gets. A contact dot gives its radius' line to the centre, so that one probe fixes it;
# without one, three probes fix a sphere, and two more tell the atom from a sphere that touches three by chance.
TOUCHES, TOUCHES_WITHOUT_CONTACT = 1, 5
TOUCH = 1e-5  # Å, of a probe and an atom: rounding
SAME_PROBE = 0.05  # Å, between probe centres of which only one is chosen
DECIMALS = 4  # of positions and normals in a file
# Å, between dots that are added in one round: a dot mends the surface around it, which the next round measures
SPREAD = 1.5
# Å: dots are added where the true surface lies so far from the rebuilt one, the worst places first
ROUNDS = (0.12, 0.12, 0.12, 0.06, 0.06, 0.03)
# Å, of the rebuilt surface from the true one, and dots that are added for it in a round: few, since they mend less than others
OVERSHOOTS, MAX_OVERSHOOTS = 0.25, 40


class SurfaceOnAtoms(SampledSurface, Protocol):
    """A surface from which dots are chosen that may have been placed on atoms."""

    surface: Surface
    threads: int


def cover_dots(surface: Surface, atoms: SurfaceOrigin) -> np.ndarray:
    """Return dots, (n,) int64, of which a contact dot touches each exposed atom, and another dot touches it once more.

    An atom that is touched by saddle and concave dots alone gets five of them. The contact dot of an atom is the one nearest to
    the middle of its exposed part, and the others follow greedily: the dot that touches most atoms which lack one (set cover).
    """
    contact = np.flatnonzero(surface.kind == CONTACT)
    atom, n_atoms = surface.atom[contact], len(atoms.xyz)
    middle = np.stack([np.bincount(atom, surface.normals[contact, k], n_atoms) for k in range(3)], axis=1)
    along = np.einsum("ij,ij->i", surface.normals[contact], middle[atom]).round(9)
    order = np.lexsort((-along, atom))
    first = np.append(True, np.diff(atom[order]) != 0) if len(order) else np.zeros(0, bool)
    chosen = contact[order[first]].tolist()
    other = np.flatnonzero(surface.kind != CONTACT)
    probes = surface.points[other] + atoms.rules.probe_radius * surface.normals[other]
    touched = _touched(probes, atoms)
    lacks = np.zeros(n_atoms, int)
    lacks[np.concatenate([*touched, np.empty(0, int)]).astype(int)] = TOUCHES_WITHOUT_CONTACT
    lacks[atom] = TOUCHES
    chosen += other[_set_cover(probes, touched, lacks)].tolist() if len(other) else []
    return np.array(chosen, np.int64)


def atoms_of(surface: Surface) -> SurfaceOrigin:
    """Return the atoms that dots were placed on; raise InputError if they are not known."""
    if surface.origin is None or surface.kind.min() < 0 or surface.atom.min() < 0:
        raise InputError(
            "cover: this sampler takes dots that `surface` placed on atoms; choose another one, such as farthest."
        )
    return surface.origin


def cover(prepared: SurfaceOnAtoms, n: int, rng: np.random.Generator) -> np.ndarray:
    """Touch every exposed atom, then add dots where the surface rebuilt from them errs, and at last farthest points.

    Of all rounds, the one with the smallest largest error stays: dots that are close together can agree by chance on an atom
    that is not there, so that more of them do not always err less.
    """
    surface, threads = prepared.surface, prepared.threads
    atoms = atoms_of(surface)
    chosen = best = cover_dots(surface, atoms)
    if n <= len(chosen):  # evenly spread ones of them
        return chosen[farthest_point_sampling(build_grid(surface.points[chosen]), n, rng)]
    least = np.inf
    for errs in (*ROUNDS, None):
        rebuilt = rebuilt_from(surface, atoms, chosen, threads)
        errors = errors_of_dots(surface, rebuilt, threads)
        if errors.max() < least:
            best, least = chosen, errors.max()
        if errs is None or len(chosen) == n:
            break
        added = dots_to_add(surface, chosen, rebuilt, errors, errs, threads)
        chosen = np.concatenate([chosen, added])[:n]
    return farthest_after(prepared.index, best, n)


def rebuilt_from(surface: Surface, atoms: SurfaceOrigin, dots: np.ndarray, threads: int = 1) -> Rebuilt:
    """Reconstruct the surface from some of its dots, with the decimals that a file gives them."""
    points, normals = surface.points[dots].round(DECIMALS), surface.normals[dots].round(DECIMALS)
    return rebuild(
        points,
        normals,
        DENSITY_FOR_SPHERES,
        threads=threads,
        probe_radius=atoms.rules.probe_radius,
        radii=atoms.table,
    )


def errors_of_dots(surface: Surface, rebuilt: Rebuilt, threads: int = 1) -> np.ndarray:
    """Measure how far each dot lies from the surface that was rebuilt from some of them, (N,) float64, Å."""
    return distance_to_surface(surface.points, rebuilt.points, rebuilt.normals, threads)


def dots_to_add(
    surface: Surface, chosen: np.ndarray, rebuilt: Rebuilt, errors: np.ndarray, errs: float, threads: int = 1
) -> np.ndarray:
    """Return dots, the worst first, whose `errors` exceed `errs` Å, or above which the rebuilt surface overshoots."""
    from scipy.spatial import cKDTree

    overshoots = distance_to_surface(rebuilt.points, surface.points, surface.normals, threads)
    worst = _worst(surface.points, errors, errs, len(errors))
    over = _worst(rebuilt.points, overshoots, max(OVERSHOOTS, errs), MAX_OVERSHOOTS)
    under = np.asarray(cKDTree(surface.points).query(rebuilt.points[over])[1], np.int64)
    dots = np.concatenate([worst, under])
    order = np.argsort(-np.concatenate([errors[worst], overshoots[over]]), kind="stable")
    _, first = np.unique(dots[order], return_index=True)
    dots = dots[order][np.sort(first)]
    return dots[~np.isin(dots, chosen)]


def _worst(points: np.ndarray, errors: np.ndarray, least: float, n_points: int) -> np.ndarray:
    """Return the points with the largest errors above `least` Å that are apart from one another, at most so many."""
    order = np.argsort(-errors, kind="stable")[: np.count_nonzero(errors > least)]
    if len(order) == 0:
        return order
    return order[select_separated(build_grid(points[order]), np.arange(len(order)), SPREAD, n_points, 0)]


def _touched(probes: np.ndarray, atoms: SurfaceOrigin) -> list[np.ndarray]:
    """Return the atoms that each probe touches."""
    from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

    if len(probes) == 0:
        return []
    reach = atoms.radii + atoms.rules.probe_radius
    pairs = cKDTree(probes).sparse_distance_matrix(
        cKDTree(atoms.xyz), reach.max() + TOUCH, output_type="ndarray"
    )
    pairs = pairs[np.abs(pairs["v"] - reach[pairs["j"]]) < TOUCH]
    pairs = pairs[np.lexsort((pairs["j"], pairs["i"]))]
    return np.split(pairs["j"], np.searchsorted(pairs["i"], np.arange(1, len(probes))))


def _set_cover(probes: np.ndarray, touched: list[np.ndarray], lacks: np.ndarray) -> list[int]:
    """Return probes, in the order of choice, each of which touches most atoms that lack a touch; `lacks` is used up."""
    from scipy.spatial import cKDTree

    tree, used, chosen = cKDTree(probes), np.zeros(len(probes), bool), []
    heap = [(-len(atoms), i) for i, atoms in enumerate(touched)]
    heapq.heapify(heap)
    while heap:
        gain, i = heapq.heappop(heap)
        now = 0 if used[i] else int((lacks[touched[i]] > 0).sum())
        if 0 < now < -gain:
            heapq.heappush(heap, (-now, i))
        elif now:
            chosen.append(i)
            lacks[touched[i]] -= 1
            used[tree.query_ball_point(probes[i], SAME_PROBE)] = True
    return chosen
