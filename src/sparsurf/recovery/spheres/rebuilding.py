"""Rebuild a surface from few dots with the spheres that they lie on, where these dots say so; elsewhere it is interpolated.

The interpolant guides: the probe never rolls freely over the inferred atoms, since it would leak through missing ones and cut
the outer wall from inside. Points of the interpolant move onto the surface of the inferred atoms only between dots that lie on
it. Every gate leads back to the interpolant, to the byte.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sparsurf.kernels import njit
from sparsurf.patches.index import PatchIndex, ball, build_grid, cells_within, select_separated
from sparsurf.recovery.recovering import CELL, NEWTON_STEPS, REACH, interpolate_surface
from sparsurf.recovery.spheres.atoms import Atoms, infer
from sparsurf.recovery.spheres.votes import SphereModel, vote
from sparsurf.surfaces.molecular_surface import roll_spheres
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.surfaces.surface import CONTACT, Surface
from sparsurf.threads import parallel_map

MIN_ATOMS = 4
# A kept dot that lies deep inside the probe of another: never among exact dots, one of a hundred among those of DMS, three
# where positions have a noise of 0.01 Å, and more on a surface of another kind.
DEEP, MAX_DEEP_SHARE = 0.01, 0.02  # Å; share of the kept dots
SUNK = 0.05  # Å: deeper than noise, so that the program did not trim concave parts where probes overlap, as DMS does not
# Of a kept dot on the rebuilt surface: height, distance to the nearest dot there, and cosine of both normals
MAX_HEIGHT, MAX_GAP, MIN_COSINE = 0.02, 0.3, 0.9
MIN_SHARE_ON = 0.3  # of the kept dots, on the rebuilt surface; surfaces of another kind have less than 0.06
# Dots per Å^2 of the surface of the inferred atoms, at least; twice as many change the mean error by less than 0.001 Å
ROLLED_DENSITY = 40.0
# Nearest kept dots of a point, which all must lie on the rebuilt surface. With two, the mean error is a tenth smaller, but parts
# that are not there reach half as far again (99 % of the way back); with five, the mean error is a third larger.
KEPT_AROUND = 3
# Å, of a point of the interpolant onto the rebuilt surface. Between dots that touch every atom the interpolant errs by so much:
# at 0.3 Å their mean error is half as large again or twice as large; beyond 0.6 Å no error changes by much.
MAX_MOVE = 0.6
# Å around moved points in which dots of the rebuilt surface close holes. At 1 Å the mean error is a tenth smaller with 0.25 dots
# per Å^2, but 99 % of the way back grows by a third there and by three quarters with 0.6.
FILL = 0.7
SAME_SIDE = 0.3  # cosine of the normals of a point and of the rebuilt surface
EITHER_SIDE = -2.0  # below every cosine
# The nearest dot is first looked for within this share of the distance where it may lie: dense dots have one there
NEARER = 0.3
PUSHES = 3  # out of the probe balls of kept dots
# Distance of a new dot from all others, in 1 / sqrt(density), which makes up to a third more dots than requested
SEPARATION = 0.72
POINTS_PER_TASK = 16384


class Rebuilt(NamedTuple):
    """A reconstructed surface and what its kept dots say of their spheres."""

    points: np.ndarray  # (N, 3) float64, Å, kept dots first
    normals: np.ndarray  # (N, 3) float64
    share: float  # of the kept dots that lie on the surface of the inferred atoms; 0 where the interpolant is used everywhere
    model: SphereModel
    atoms: Atoms | None = None


def rebuild(
    points: np.ndarray,
    normals: np.ndarray,
    density: float = DENSITY,
    reach: float = REACH,
    steps: int = NEWTON_STEPS,
    threads: int = 1,
    probe_radius: float | None = None,
    radii: str | Sequence[float] | None = None,
) -> Rebuilt:
    """Reconstruct the surface of dots (n, 3), with their spheres where these hold and the interpolant elsewhere.

    Other arguments are those of `recovering.interpolate_surface`, and the probe radius (Å) and the radii where they are known.
    """
    return rebuild_at(points, normals, (density,), reach, steps, threads, probe_radius, radii)[0]


def rebuild_at(
    points: np.ndarray,
    normals: np.ndarray,
    densities: Sequence[float],
    reach: float = REACH,
    steps: int = NEWTON_STEPS,
    threads: int = 1,
    probe_radius: float | None = None,
    radii: str | Sequence[float] | None = None,
) -> list[Rebuilt]:
    """Reconstruct the surface of dots (n, 3) like `rebuild`, at each of several densities; the atoms are inferred once."""
    model = vote(points, normals, probe_radius, radii)
    points, normals = np.ascontiguousarray(points, float), np.ascontiguousarray(normals, float)
    guides = [interpolate_surface(points, normals, density, reach, steps, threads) for density in densities]
    interpolated = [Rebuilt(*guide, 0.0, model) for guide in guides]
    if len(model.radii) == 0:
        return interpolated
    centres = build_grid(points + model.probe * normals)
    depth = model.probe - _distances_to_nearest(centres, points, model.probe)
    deep = float((depth > DEEP).mean())
    if deep >= MAX_DEEP_SHARE:
        return interpolated
    atoms = infer(points, normals, model, threads)
    interpolated = [found._replace(atoms=atoms) for found in interpolated]
    if len(atoms.radii) < MIN_ATOMS:
        return interpolated
    reentrant = "dms" if (depth > SUNK).any() else "exact"
    rolled = roll_spheres(atoms.centres, atoms.radii, model.probe, reentrant)
    placed: dict[float, tuple[Surface, PatchIndex, np.ndarray]] = {}
    rebuilt = []
    for density, guide, without_spheres in zip(densities, guides, interpolated, strict=True):
        rolled_density = max(ROLLED_DENSITY, density)
        if rolled_density not in placed:
            surface = rolled.surface(rolled_density)
            index = build_grid(surface.points, surface.normals, side=MAX_MOVE)
            placed[rolled_density] = surface, index, _lies_on(index, points, normals, threads)
        surface, index, lies_on = placed[rolled_density]
        share = float(lies_on.mean())
        if share < MIN_SHARE_ON:
            rebuilt.append(without_spheres)
            continue
        moved = _moved(
            guide, len(points), lies_on, points, centres, surface, index, atoms, model.probe, deep == 0, threads
        )  # fmt: skip
        filled = _filled(*moved, len(points), surface, density, threads)
        rebuilt.append(Rebuilt(*filled, share, model, atoms))
    return rebuilt


def _lies_on(index: PatchIndex, points: np.ndarray, normals: np.ndarray, threads: int) -> np.ndarray:
    """Return which dots lie on the rebuilt surface, with the same normal, (n,) bool."""
    nearest = _nearest_facing(index, points, normals, MAX_GAP, MIN_COSINE, threads)
    height = np.einsum("ij,ij->i", points - index.xyz[nearest], index.normals[nearest])
    return (nearest >= 0) & (np.abs(height) < MAX_HEIGHT)


def _moved(
    guide: tuple[np.ndarray, np.ndarray],
    n_kept: int,
    lies_on: np.ndarray,
    kept: np.ndarray,
    centres: PatchIndex,
    surface: Surface,
    index: PatchIndex,
    atoms: Atoms,
    probe: float,
    push: bool,
    threads: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points and normals of the guide, those between dots on the rebuilt surface moved onto it, and which these are."""
    points, normals = guide[0].copy(), guide[1].copy()
    if push:
        parallel_map(
            lambda begin, end: _push_out(centres, max(begin, n_kept), end, probe, points, normals),
            len(points),
            threads,
            POINTS_PER_TASK,
        )
    trusted = np.full(len(points), True)
    if not lies_on.all():
        from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

        around = min(KEPT_AROUND, n_kept)
        near = np.asarray(cKDTree(kept).query(points, k=around, workers=threads)[1])
        trusted = np.all(lies_on[near].reshape(len(points), -1), axis=1)
    nearest = _nearest_facing(index, points, normals, MAX_MOVE, SAME_SIDE, threads)
    moves = trusted & (nearest >= 0)
    new = moves.copy()
    new[:n_kept] = False
    target = nearest[new]
    points[new], normals[new] = _onto_sphere(points[new], index.dot[target], surface, atoms, probe)
    # Between dots on the rebuilt surface, a point of the guide without any of it nearby lies where there is no surface
    stays = moves | ~trusted
    stays[:n_kept] = True
    return points[stays], normals[stays], moves[stays]


def _onto_sphere(
    points: np.ndarray, dots: np.ndarray, surface: Surface, atoms: Atoms, probe: float
) -> tuple[np.ndarray, np.ndarray]:
    """Project points onto the sphere of an atom, or of a probe, on which a dot of the rebuilt surface lies."""
    contact = surface.kind[dots] == CONTACT
    radius = np.where(contact, -atoms.radii[surface.atom[dots]], probe)
    centre = surface.points[dots] + radius[:, None] * surface.normals[dots]
    outward = (centre - points) * np.sign(radius)[:, None]
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    return centre - radius[:, None] * outward, outward


def _filled(
    points: np.ndarray,
    normals: np.ndarray,
    moved: np.ndarray,
    n_kept: int,
    surface: Surface,
    density: float,
    threads: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Add the dots of the rebuilt surface around moved points, which close holes, before the guide, and thin what overlaps."""
    index = build_grid(points[moved], normals[moved], side=FILL)
    nearest = _nearest_facing(index, surface.points, surface.normals, FILL, EITHER_SIDE, threads)
    near = np.flatnonzero(nearest >= 0)
    cosine = np.einsum("ij,ij->i", surface.normals[near], index.normals[nearest[near]])
    fill = near[cosine > SAME_SIDE]
    points = np.concatenate([points[:n_kept], surface.points[fill], points[n_kept:]])
    normals = np.concatenate([normals[:n_kept], surface.normals[fill], normals[n_kept:]])
    n, gap = len(points), SEPARATION / math.sqrt(density)
    chosen = select_separated(build_grid(points, side=CELL), np.arange(n), gap, n, n_kept)
    return points[chosen], normals[chosen]


def _nearest_facing(
    index: PatchIndex, points: np.ndarray, normals: np.ndarray, radius: float, cosine: float, threads: int
) -> np.ndarray:
    """Return the position of the nearest dot within `radius` Å of each point that faces the same way, (m,), or -1."""
    out = np.empty(len(points), np.int64)
    parallel_map(
        lambda begin, end: _write_nearest_facing(index, points, normals, begin, end, radius, cosine, out),
        len(points),
        threads,
        POINTS_PER_TASK,
    )
    return out


@njit(cache=True, nogil=True)
def _write_nearest_facing(
    index: PatchIndex,
    points: np.ndarray,
    normals: np.ndarray,
    begin: int,
    end: int,
    radius: float,
    cosine: float,
    out: np.ndarray,
) -> None:
    """Write the position of the nearest dot that faces the same way, for a slice of points; the lowest of equally near ones."""
    for i in range(begin, end):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        u, v, w = normals[i, 0], normals[i, 1], normals[i, 2]
        found = -1
        for within in (NEARER * radius, radius):
            best = within * within
            a0, a1 = cells_within(x, within, index.origin[0], index.side, index.shape[0])
            b0, b1 = cells_within(y, within, index.origin[1], index.side, index.shape[1])
            c0, c1 = cells_within(z, within, index.origin[2], index.side, index.shape[2])
            for a in range(a0, a1 + 1):
                for b in range(b0, b1 + 1):
                    if c1 < c0:
                        continue
                    row = (a * index.shape[1] + b) * index.shape[2]
                    for q in range(index.start[row + c0], index.start[row + c1 + 1]):
                        d2 = (
                            (index.xyz[q, 0] - x) ** 2
                            + (index.xyz[q, 1] - y) ** 2
                            + (index.xyz[q, 2] - z) ** 2
                        )
                        if d2 < best:
                            along = (
                                u * index.normals[q, 0] + v * index.normals[q, 1] + w * index.normals[q, 2]
                            )
                            if along > cosine:
                                best, found = d2, q
            if found >= 0:
                break
        out[i] = found


@njit(cache=True, nogil=True)
def _distances_to_nearest(index: PatchIndex, points: np.ndarray, radius: float) -> np.ndarray:
    """Return the distance of each point from the nearest dot of the index, (m,), at most `radius` Å."""
    out, nearby = np.full(len(points), radius), np.empty(len(index.dot) + 1, np.int32)
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        for e in range(ball(index, x, y, z, radius, nearby)):
            q = nearby[e]
            d2 = (index.xyz[q, 0] - x) ** 2 + (index.xyz[q, 1] - y) ** 2 + (index.xyz[q, 2] - z) ** 2
            out[i] = min(out[i], math.sqrt(d2))
    return out


@njit(cache=True, nogil=True)
def _push_out(
    centres: PatchIndex, begin: int, end: int, probe: float, points: np.ndarray, normals: np.ndarray
) -> None:
    """Push the points of a slice, in place, out of the probe balls of the kept dots, which are empty."""
    nearby = np.empty(len(centres.dot) + 1, np.int32)
    for i in range(begin, end):
        for _ in range(PUSHES):
            x, y, z = points[i, 0], points[i, 1], points[i, 2]
            best, found = (probe - 1e-6) ** 2, -1
            for e in range(ball(centres, x, y, z, probe, nearby)):
                q = nearby[e]
                d2 = (
                    (centres.xyz[q, 0] - x) ** 2 + (centres.xyz[q, 1] - y) ** 2 + (centres.xyz[q, 2] - z) ** 2
                )
                if d2 < best:
                    best, found = d2, q
            if found < 0:
                break
            distance = max(math.sqrt(best), 1e-9)
            for c in range(3):
                outward = (points[i, c] - centres.xyz[found, c]) / distance
                points[i, c] = centres.xyz[found, c] + probe * outward
                normals[i, c] = -outward
