"""Reconstruct a surface from few dots by the atoms that follow from them, and interpolate it where no atom explains them.

A probe rolls over the inferred atoms where the probe centres of the dots lie. Dots that no atom explains and places inside keep
it out. Around these, between dots that were not chosen for this, points of the interpolant take the place of the rolled surface,
since they do not depend on an atom that is missing. Every gate leads back to the interpolant, to the byte.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from sparsurf.kernels import njit
from sparsurf.patches.index import PatchIndex, ball, build_grid, select_separated
from sparsurf.recovery.interpolated_surface import MIN_INTERPOLATED, NEWTON_STEPS, REACH, interpolate_surface
from sparsurf.recovery.spheres.atoms import Atoms, infer
from sparsurf.recovery.spheres.explanations import UNEXPLAINED, completed, explain, touched_atoms
from sparsurf.recovery.spheres.inside import Inside
from sparsurf.recovery.spheres.rolled import RolledSurface, rolled_surface
from sparsurf.recovery.spheres.votes import SphereModel, model_of
from sparsurf.surfaces.dot_placement import Dots
from sparsurf.surfaces.grid import columns_around, in_column
from sparsurf.surfaces.spacing import DENSITY, estimated_areas, nearest_distances
from sparsurf.surfaces.surface import CONTACT
from sparsurf.surfaces.vectors import dot, point, squared_distance
from sparsurf.threads import parallel_map

MIN_ATOMS = 4
# A kept dot that lies deep inside the probe of another: never among exact dots, one of a hundred among those of DMS, three
# where positions have a noise of 0.01 Å, and more on a surface of another kind.
DEEP, MAX_DEEP_SHARE = 0.01, 0.02  # Å; share of the kept dots
SUNK = 0.05  # Å: deeper than noise, so that the program did not trim concave parts where probes overlap, as DMS does not
MIN_DOTS_EXPLAINED = (
    0.3  # share of the kept dots that atoms explain; surfaces of another kind have less than 0.06
)
# Dots per Å^2 of the guide, and distance below which it uses fewer neighbours, Å: it only tells inside from outside
GUIDE_DENSITY, GUIDE_CLOSE = 1.0, 0.5
INSIDE_OF_ATOM = 0.5  # winding number of the centre of an atom, at least
SUNKEN = 1.0  # Å, below each kept dot, where the winding number is that of the inside
# Dots were not chosen for the spheres if the 5 % of them with the nearest neighbours have these at this share of the median
# distance or farther: chosen dots at 0.20 to 0.45, farthest points at 0.91; random ones, at 0.46 to 0.51, then err more.
# If more of them are explained than `NEARLY_ALL`, as of 0.6 evenly spread dots per Å^2, the rolled surface alone errs less than
# with points of the interpolant, in a third of the time.
CLOSEST, EVENNESS, NEARLY_ALL = 0.05, 0.6, 0.955
# Between such dots: Å around dots of the rolled surface whose probe touches a ball, in which points of the interpolant
# take their place, and by which these overlap with the rest; and around these, kept dots from which the interpolant is made
BAND_OF_SLICES, OVERLAP, AROUND_SLICES = 0.6, 0.4, 6.0
TOUCH_OF_BALL = 1e-4  # Å, far above rounding
# Dots per Å^2 of the rolled surface onto which points of the interpolant move, at least
ROLLED_DENSITY = 20.0
# Nearest kept dots of a point, which all must be explained. With two, the mean error is a tenth smaller, but parts
# that are not there reach half as far again (99 % of the way back); with five, the mean error is a third larger.
KEPT_AROUND = 3
# Å, of a point of the interpolant onto the rebuilt surface. Between dots that touch every atom the interpolant errs by so much:
# at 0.3 Å their mean error is half as large again or twice as large; beyond 0.6 Å no error changes by much.
MAX_MOVE = 0.6
SAME_SIDE = 0.3  # cosine of the normals of a point and of the rebuilt surface
# The nearest dot is first looked for within this share of the distance where it may lie: dense dots have one there
NEARER = 0.3
PUSHES = 3  # out of the probe balls of kept dots
# In 1 / sqrt(density): between points of the interpolant, so that they are as dense as placed dots; within which a kept dot
# takes the place of a placed one, which the six around it all reach
SEPARATION, PLACE = 0.8, 1.0
POINTS_PER_TASK = 16384


class Rebuilt(NamedTuple):
    """A reconstructed surface and what its kept dots say of their spheres."""

    points: np.ndarray  # (N, 3) float64, Å, kept dots first
    normals: np.ndarray  # (N, 3) float64
    share: float = (
        0.0  # of the kept dots that inferred atoms explain; 0 where the interpolant is used everywhere
    )
    model: SphereModel | None = None  # None where atoms are not asked for
    atoms: Atoms | None = None
    exact_area: np.ndarray | None = (
        None  # (N,) float64, Å^2, NaN where it is not known; None where all are interpolated
    )

    @property
    def area(self) -> np.ndarray:
        """Area of each dot, (N,) float64, Å^2: that of the rolled surface, and where it is interpolated, an estimate."""
        area = np.full(len(self.points), np.nan) if self.exact_area is None else self.exact_area.copy()
        unknown = np.flatnonzero(np.isnan(area))
        if len(unknown):
            area[unknown] = estimated_areas(self.points, unknown)
        return area


class _Dots(NamedTuple):
    """Dots with areas, Å^2, NaN where these are not known."""

    points: np.ndarray
    normals: np.ndarray
    area: np.ndarray


def rebuild(
    points: np.ndarray,
    normals: np.ndarray,
    density: float = DENSITY,
    reach: float = REACH,
    steps: int = NEWTON_STEPS,
    threads: int = 1,
    probe_radius: float | None = None,
    radii: str | Sequence[float] | None = None,
    chosen: bool = False,
) -> Rebuilt:
    """Reconstruct the surface of dots (n, 3), with their spheres where these hold and the interpolant elsewhere.

    Other arguments are those of `interpolate_surface`, the probe radius (Å) and the radii where they are known, and
    whether the dots were chosen so that the atoms follow from them, which their distances tell otherwise.
    """
    model = model_of(points, normals, probe_radius, radii)
    return KeptDots(points, normals, model, threads).rebuilt(density, reach, steps, chosen)


class KeptDots:
    """Kept dots (n, 3) with normals, and the atoms that explain them: inferred once for surfaces of any density."""

    def __init__(self, points: np.ndarray, normals: np.ndarray, model: SphereModel, threads: int) -> None:
        """Infer the atoms, unless the dots say that they lie on none."""
        self.given = np.ascontiguousarray(points, float), np.ascontiguousarray(normals, float)
        points = self.given[0]
        normals = self.given[1] / np.linalg.norm(self.given[1], axis=1, keepdims=True)
        self.points, self.normals, self.model, self.threads = points, normals, model, threads
        self.atoms: Atoms | None = None
        self.share, self.explained = 0.0, np.zeros(len(points), bool)
        if len(model.radii) == 0:
            return
        self.probes = points + model.probe * normals
        self.grid_of_probes = build_grid(self.probes)
        self.depth = model.probe - _distances_to_nearest(self.grid_of_probes, points, model.probe)
        self.has_deep, self.exact = bool((self.depth > DEEP).any()), not (self.depth > SUNK).any()
        if (self.depth > DEEP).mean() >= MAX_DEEP_SHARE:
            return
        self.atoms = infer(points, normals, model, threads)
        if len(self.atoms.radii) < MIN_ATOMS:
            return
        self.centres, self.radii, found = completed(
            self.probes, normals, self.atoms.centres, self.atoms.radii, model
        )
        self.explained = found.kind != UNEXPLAINED
        self.share = float(self.explained.mean())

    @property
    def lie_on_spheres(self) -> bool:
        """Whether the dots lie on the spheres of atoms."""
        return self.share >= MIN_DOTS_EXPLAINED

    @property
    def need_slices(self) -> bool:
        """Whether few dots have a much nearer neighbour than the others have, and some are not explained."""
        if self.share > NEARLY_ALL:
            return False
        nearest = nearest_distances(self.points)
        return bool(np.quantile(nearest, CLOSEST) > EVENNESS * np.median(nearest))

    def rebuilt(self, density: float, reach: float, steps: int, chosen: bool) -> Rebuilt:
        """Reconstruct the surface as `rebuild` does."""
        points, normals = self.given
        if not self.lie_on_spheres:
            guide = interpolate_surface(points, normals, density, reach, steps, self.threads)
            return Rebuilt(*guide, 0.0, self.model, self.atoms)
        rolled = self.rolled
        dots = rolled.place(density)
        if self.need_slices and not chosen:
            between = self.with_slices(rolled, dots, density, reach, steps)
        else:
            on_ball = (dots.atom >= rolled.n_atoms) & (dots.kind == CONTACT)
            between = _Dots(*dots.take(~on_ball)[:3])
        kept = _Dots(points, normals, np.full(len(points), np.nan))
        found = _with_kept(kept, between, density, self.threads)
        return Rebuilt(found.points, found.normals, self.share, self.model, self.atoms, found.area)

    @cached_property
    def rolled(self) -> RolledSurface:
        """The probe, rolled over the atoms."""
        guide = interpolate_surface(
            self.points, self.normals, GUIDE_DENSITY, threads=self.threads, close=GUIDE_CLOSE
        )
        inside = Inside(*guide, self.probes, self.points - SUNKEN * self.normals)
        lies_inside = inside.winding_numbers(self.centres, self.threads) > INSIDE_OF_ATOM
        if not lies_inside.all():  # with noise, a place outside agrees with a dot by chance
            self.centres, self.radii = self.centres[lies_inside], self.radii[lies_inside]
            found = explain(self.probes, self.normals, self.centres, self.radii, self.model)
            self.explained = found.kind != UNEXPLAINED
        balls = ~self.explained
        return rolled_surface(
            self.probes, self.centres, self.radii, self.points[balls], self.depth[balls], self.model.probe, inside, guide[0],
            self.exact, self.threads,
        )  # fmt: skip

    def with_slices(
        self, rolled: RolledSurface, dots: Dots, density: float, reach: float, steps: int
    ) -> _Dots:
        """Return dots of the rolled surface, around balls replaced by points of the interpolant that move onto it."""
        from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

        at_ball, dense = self._at_balls(rolled, dots), dots
        at_ball_of_dense = at_ball
        if density < ROLLED_DENSITY:
            dense = rolled.place(ROLLED_DENSITY)
            at_ball_of_dense = self._at_balls(rolled, dense)
        surface = _Dots(*dots.take(~at_ball)[:3])
        if not at_ball_of_dense.any():
            return surface
        replaced = cKDTree(dense.points[at_ball_of_dense])
        stays = (
            np.asarray(replaced.query(surface.points, distance_upper_bound=BAND_OF_SLICES)[0])
            > BAND_OF_SLICES
        )
        surface = _Dots(*(column[stays] for column in surface))
        around = np.flatnonzero(
            np.asarray(replaced.query(self.points, distance_upper_bound=AROUND_SLICES)[0]) < AROUND_SLICES
        )
        if len(around) < MIN_INTERPOLATED:
            return surface
        guide = interpolate_surface(
            self.points[around], self.normals[around], density, reach, steps, self.threads
        )
        target = dense.take(~at_ball_of_dense)
        points, normals = self._moved(guide, around, target)
        outer = BAND_OF_SLICES + OVERLAP
        near = np.asarray(replaced.query(points, distance_upper_bound=outer)[0]) < outer
        points, normals = points[near], normals[near]
        # Points of the interpolant apart from one another and from the dots of the rolled surface
        n, all_points = len(surface.points), np.concatenate([surface.points, points])
        gap = SEPARATION / math.sqrt(density)
        chosen = select_separated(build_grid(all_points), np.arange(len(all_points)), gap, len(all_points), n)
        added = chosen[n:] - n
        return _Dots(
            np.concatenate([surface.points, points[added]]),
            np.concatenate([surface.normals, normals[added]]),
            np.append(surface.area, np.full(len(added), np.nan)),
        )

    def _at_balls(self, rolled: RolledSurface, dots: Dots) -> np.ndarray:
        """Return which dots have a probe that touches a ball, (N,) bool."""
        balls, n = slice(rolled.n_atoms, None), len(dots.points)
        if rolled.n_atoms == len(rolled.radii):
            return np.zeros(n, bool)
        probes = dots.points + self.model.probe * dots.normals
        reach = rolled.radii[balls] + self.model.probe
        start, _ = touched_atoms(probes, rolled.centres[balls], reach, TOUCH_OF_BALL)
        return np.diff(start) > 0

    def _moved(
        self, guide: tuple[np.ndarray, np.ndarray], around: np.ndarray, target: Dots
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return points and normals of the guide of some dots, those between explained dots moved onto the rolled surface."""
        n, probe, threads = len(around), self.model.probe, self.threads
        points, normals = guide[0][n:].copy(), guide[1][n:].copy()
        if not self.has_deep:
            parallel_map(
                lambda begin, end: _push_out(self.grid_of_probes, begin, end, probe, points, normals),
                len(points),
                threads,
                POINTS_PER_TASK,
            )
        trusted = np.full(len(points), True)
        explained = self.explained[around]
        if not explained.all():
            from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

            near = np.asarray(
                cKDTree(self.points[around]).query(points, k=min(KEPT_AROUND, n), workers=threads)[1]
            )
            trusted = np.all(explained[near].reshape(len(points), -1), axis=1)
        index = build_grid(target.points, target.normals, side=MAX_MOVE)
        nearest = _nearest_facing(index, points, normals, MAX_MOVE, SAME_SIDE, threads)
        moves = trusted & (nearest >= 0)
        onto = target.take(index.dot[nearest[moves]])
        points[moves], normals[moves] = _onto_sphere(points[moves], onto, self.radii, probe)
        # Between explained dots, a point of the guide without any of the rolled surface nearby lies where there is none
        stays = moves | ~trusted
        return points[stays], normals[stays]


def _onto_sphere(
    points: np.ndarray, dots: Dots, radii: np.ndarray, probe: float
) -> tuple[np.ndarray, np.ndarray]:
    """Project each point onto the sphere of an atom, of radii (A,), or of a probe, on which a dot of the rolled surface lies."""
    contact = dots.kind == CONTACT
    radius = np.where(contact, -radii[np.where(contact, dots.atom, 0)], probe)
    centre = dots.points + radius[:, None] * dots.normals
    outward = (centre - points) * np.sign(radius)[:, None]
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    return centre - radius[:, None] * outward, outward


def _with_kept(kept: _Dots, dots: _Dots, density: float, threads: int) -> _Dots:
    """Put kept dots in front of dots: each takes the place and the area of the nearest, which several share."""
    index = build_grid(dots.points, dots.normals, side=0.5)
    nearest = _nearest_facing(
        index, kept.points, kept.normals, PLACE / math.sqrt(density), SAME_SIDE, threads
    )
    takes = nearest >= 0
    replaced = index.dot[nearest[takes]]
    area = kept.area.copy()
    area[takes] = dots.area[replaced] / np.bincount(replaced, minlength=len(dots.area))[replaced]
    stays = np.full(len(dots.area), True)
    stays[replaced] = False
    return _Dots(
        np.concatenate([kept.points, dots.points[stays]]),
        np.concatenate([kept.normals, dots.normals[stays]]),
        np.append(area, dots.area[stays]),
    )


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


@njit()
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
        centre, normal = point(points, i), point(normals, i)
        found = -1
        for within in (NEARER * radius, radius):
            best = within * within
            columns = columns_around(index.lattice, centre, within)
            for c in range(columns.n):
                for q in in_column(index.start, columns, c):
                    d2 = squared_distance(point(index.xyz, q), centre)
                    if d2 < best and dot(normal, point(index.normals, q)) > cosine:
                        best, found = d2, q
            if found >= 0:
                break
        out[i] = found


@njit()
def _distances_to_nearest(index: PatchIndex, points: np.ndarray, radius: float) -> np.ndarray:
    """Return the distance of each point from the nearest dot of the index, (m,), at most `radius` Å."""
    out, nearby = np.full(len(points), radius), np.empty(len(index.dot) + 1, np.int32)
    for i in range(len(points)):
        centre = point(points, i)
        for e in range(ball(index, centre, radius, nearby)):
            d2 = squared_distance(point(index.xyz, nearby[e]), centre)
            out[i] = min(out[i], math.sqrt(d2))
    return out


@njit()
def _push_out(
    centres: PatchIndex, begin: int, end: int, probe: float, points: np.ndarray, normals: np.ndarray
) -> None:
    """Push the points of a slice, in place, out of the probe balls of the kept dots, which are empty."""
    nearby = np.empty(len(centres.dot) + 1, np.int32)
    for i in range(begin, end):
        for _ in range(PUSHES):
            centre = point(points, i)
            best, found = (probe - 1e-6) ** 2, -1
            for e in range(ball(centres, centre, probe, nearby)):
                q = nearby[e]
                d2 = squared_distance(point(centres.xyz, q), centre)
                if d2 < best:
                    best, found = d2, q
            if found < 0:
                break
            distance = max(math.sqrt(best), 1e-9)
            for c in range(3):
                outward = (points[i, c] - centres.xyz[found, c]) / distance
                points[i, c] = centres.xyz[found, c] + probe * outward
                normals[i, c] = -outward
