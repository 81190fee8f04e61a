"""Choose few dots that determine the atoms under a surface, and more where the surface that follows from them would err.

`recovery.spheres` infers the atoms under few dots. A contact dot of an exposed atom, and one more probe that touches it,
determine the atom, so that such dots determine the surface. They serve this reconstruction alone: the interpolant errs by 20
to 40 % more with them than with the same number of farthest points, and if a tenth of them is lost at random, the mean error
grows from 0.002 to 0.06 to 0.1 Å.

Since the true atoms are known here, the error of a choice follows from the atoms that are inferred from it, without any
reconstruction: a dot lies on the reconstructed surface if its probe touches the same atoms and holds none inside.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from sparsurf.errors import InputError
from sparsurf.patches.index import build_grid, select_separated
from sparsurf.recovery.spheres.atoms import (
    MAX_ANGLE,
    MIN_ACROSS,
    TOUCHES_OF_CONTACT,
    TOUCHES_OF_SADDLE,
    TOUCHES_OF_TRIPLE,
    infer,
)
from sparsurf.recovery.spheres.explanations import UNEXPLAINED, completed
from sparsurf.recovery.spheres.votes import known_model
from sparsurf.sampling.farthest_point import farthest_after, farthest_point_sampling
from sparsurf.sampling.published import SampledSurface
from sparsurf.sampling.touches import Touches, set_cover, touches_of
from sparsurf.surfaces.exact_distance import exact_distance
from sparsurf.surfaces.grid import nearest_of
from sparsurf.surfaces.molecular_surface import RolledFrame, roll_spheres, rolled_atoms
from sparsurf.surfaces.surface import CONTACT, SADDLE, Surface, SurfaceOrigin

DECIMALS = 4  # Positions and normals have so many decimals in a file.
# If a share of the exposed atoms, those that touch least area, is given up, the mean error grows with the power of 2.2 of this
# share and is 0.02 Å at a fifth of them; 99 % of the surface lies within 20 times as much (three structures).
GIVEN_UP, MEAN_ERROR, TAIL, POWER = 0.2, 0.02, 20.0, 1 / 2.2
# Å, of the mean error, which the atoms that are not inferred take up: room for them where nothing is measured
OF_INFERENCE = 0.0025
TRUE_ATOM = 0.01  # Å, of an inferred atom from a true one: ten times the error of positions with `DECIMALS`
BALL = 1e-4  # Å, radius of a kept dot that no atom explains, over which the probe rolls like over an atom: rounding
# Å, between dots that are added in one round: a dot mends the surface around it, so that one for each bad place is enough. At 1 Å
# 3 % more dots are kept for the same errors, at 2.5 Å further rounds are needed.
APART_FROM_KEPT = 1.5
# Share of the surface that may lie beyond the 99 % error by prediction, and to which added dots reduce it, since a few of them
# mislead the inference: with more reduction more dots are kept, and with less the measured surface needs more of them later
BEYOND, REDUCED = 0.009, 0.005
# Where a number of dots is requested: Å, from which on dots are added, and how often; they mend nearly all that is predicted
LEAST_ERROR, MAX_ROUNDS_OF_DOTS = 0.02, 2


class SurfaceOnAtoms(SampledSurface, Protocol):
    """A surface from which dots are chosen that may have been placed on atoms."""

    surface: Surface
    threads: int


class AtomCover:
    """The choice of dots, of a surface that was placed on atoms, that determine these atoms."""

    def __init__(self, surface: Surface, atoms: SurfaceOrigin, rolled: RolledFrame, threads: int = 1) -> None:
        """Find what the probe at each dot touches; `rolled` are the atoms with the probe rolled over them."""
        self.surface, self.atoms, self.threads = surface, atoms, threads
        self.touches, self.component = touches_of(surface, atoms), rolled.components(surface)
        self.touched_area = self.touches.areas(surface, len(atoms.xyz))

    def dots(self, share_given_up: float = 0.0) -> np.ndarray:
        """Return the dots that determine the exposed atoms, without the given share of them, those that touch least area.

        There is a dot on each component, also on a cavity whose atoms are touched from outside: the probe rolls where dots lie.
        """
        exposed = np.asarray(np.flatnonzero(self.touched_area))
        least = exposed[np.argsort(self.touched_area[exposed], kind="stable")]
        given_up = np.zeros(len(self.touched_area), bool)
        given_up[least[: int(share_given_up * len(exposed))]] = True
        chosen = cover_dots(self.surface, self.atoms, self.touches, given_up)
        other_dots = np.flatnonzero(~np.isin(self.component, self.component[chosen]))
        best = _best_of_each(self.component[other_dots], np.diff(self.touches.start)[other_dots])
        return np.append(chosen, other_dots[best])

    def for_error(self, error: float, error_99: float) -> np.ndarray:
        """Return few dots whose reconstructed surface has a mean and a 99 % error, Å, by prediction."""
        chosen, area = self.dots(share_to_give_up(error, error_99)), self.surface.area
        if math.isinf(error_99):
            return chosen
        errors = self.predicted_errors(chosen)
        beyond = area * (errors > error_99)
        if beyond.sum() > BEYOND * area.sum():
            added = self.to_add(chosen, errors, beyond, REDUCED * area.sum())
        elif (area * errors).sum() > error * area.sum():
            added = self.to_add(chosen, errors, area * errors, REDUCED / BEYOND * error * area.sum())
        else:
            return chosen
        return np.concatenate([chosen, added])

    def predicted_errors(self, chosen: np.ndarray) -> np.ndarray:
        """Predict how far each dot will lie from the surface that is reconstructed from the chosen ones, (N,) float64, Å.

        A dot whose probe touches the same inferred atoms as true ones has no error. For the others it is the distance from the
        surface of the inferred atoms and of the chosen dots that these do not explain, over which the probe rolls as well.
        """
        surface, atoms, probe = self.surface, self.atoms, self.atoms.rules.probe_radius
        points, normals = surface.points[chosen].round(DECIMALS), surface.normals[chosen].round(DECIMALS)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        model = known_model(
            points, normals, probe, np.unique(atoms.radii) if atoms.table is None else atoms.table
        )
        inferred = infer(points, normals, model, self.threads)
        centres, radii, found = completed(
            points + probe * normals, normals, inferred.centres, inferred.radii, model
        )
        nearest, distance = nearest_of(atoms.xyz, centres)
        is_true = (distance < TRUE_ATOM) & (np.abs(atoms.radii[nearest] - radii) < TRUE_ATOM)
        missing = np.full(len(atoms.xyz), True)
        missing[nearest[is_true]] = False
        errs = self.touches.dots_of(missing)
        if not is_true.all():
            places, reach = surface.points + probe * surface.normals, radii.max() + probe
            errs |= nearest_of(centres[~is_true], places)[1] < reach
        balls = points[found.kind == UNEXPLAINED]
        spheres = np.concatenate([centres, balls])
        rolled = roll_spheres(spheres, np.append(radii, np.full(len(balls), BALL)), probe)
        errors = np.zeros(len(surface))
        errors[errs] = np.abs(exact_distance(surface.points[errs], rolled, threads=self.threads))
        return errors

    def to_add(
        self, chosen: np.ndarray, errors: np.ndarray, weight: np.ndarray, remaining: float
    ) -> np.ndarray:
        """Return dots to add so that weights (N,) sum to about `rest` where no added dot is the nearest, the most useful first.

        A dot is added where the error is the largest around; of these places, those with the largest weight come first.
        """
        points, bad = self.surface.points, np.flatnonzero(weight)
        candidates = bad[~np.isin(bad, chosen)]
        candidates = candidates[np.argsort(-errors[candidates], kind="stable")]
        if len(candidates) == 0:
            return candidates
        grid = build_grid(points[candidates])
        worst = candidates[
            select_separated(grid, np.arange(len(candidates)), APART_FROM_KEPT, len(candidates), 0)
        ]
        nearest = nearest_of(points[worst], points[bad])[0]
        mended = np.bincount(nearest, weight[bad], len(worst))
        order = np.argsort(-mended, kind="stable")
        return worst[order[: np.searchsorted(np.cumsum(mended[order]), mended.sum() - remaining) + 1]]


def share_to_give_up(error: float, error_99: float) -> float:
    """Return the share of the exposed atoms that need not be determined for a mean and a 99 % error, Å; it may exceed 1."""
    if math.isinf(error_99):
        error = max(error - OF_INFERENCE, 0.0)
    return GIVEN_UP * (min(error, error_99 / TAIL) / MEAN_ERROR) ** POWER


def cover_dots(
    surface: Surface, atoms: SurfaceOrigin, touches: Touches, given_up: np.ndarray | None
) -> np.ndarray:
    """Return few dots, (n,) int64, that determine each exposed atom, but for those that are given up, (A,) bool.

    The contact dot of an atom is the one nearest to the middle of its exposed part, and another probe confirms it. An atom
    without a contact dot is fixed by a saddle dot that also touches an atom with one, and confirmed by two other probes; where
    there is no such dot, it gets five probes. The confirming dots follow greedily (set cover): the dot that touches most atoms
    that lack one, first among those of atoms without a contact dot, whose probes are then near one another, and last among those
    that touch an atom which is given up, since these do not lie on the surface of the others.
    """
    n_atoms = len(atoms.xyz)
    wanted, given_up = np.zeros(n_atoms, bool), np.zeros(n_atoms, bool) if given_up is None else given_up
    wanted[touches.atom] = True
    wanted &= ~given_up
    contact = np.flatnonzero(surface.kind == CONTACT)
    contact = contact[wanted[surface.atom[contact]]]
    atom = surface.atom[contact]
    middle = np.stack([np.bincount(atom, surface.normals[contact, k], n_atoms) for k in range(3)], axis=1)
    along = np.einsum("ij,ij->i", surface.normals[contact], middle[atom]).round(9)
    contact = contact[_best_of_each(atom, along)]
    located = np.zeros(n_atoms, bool)
    located[surface.atom[contact]] = True
    saddle, first_atom, second_atom = _saddles(surface, atoms, touches, located, wanted & ~located)
    lacks = np.where(wanted, TOUCHES_OF_TRIPLE, 0)
    lacks[located] = TOUCHES_OF_CONTACT - 1
    lacks[second_atom] = TOUCHES_OF_SADDLE - 1
    np.subtract.at(lacks, first_atom, 1)
    used = np.zeros(len(surface), bool)
    used[touches.first[saddle]] = True
    other_dots, avoided = np.flatnonzero(surface.kind != CONTACT), touches.dots_of(given_up)
    chosen = [contact, saddle]
    clusters = other_dots[touches.dots_of(wanted & ~located)[other_dots] & ~avoided[other_dots]]
    for candidates in (clusters, other_dots[~avoided[other_dots]], other_dots[avoided[other_dots]]):
        chosen.append(set_cover(candidates, touches, lacks, used))
    return np.concatenate(chosen)


def _saddles(
    surface: Surface, atoms: SurfaceOrigin, touches: Touches, located: np.ndarray, unknown: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a saddle dot for each unknown atom that shares one with a known atom, (n,), and its known and unknown atoms.

    It is the dot nearest to the middle of its arc, and `infer` can find the second atom from it.
    """
    saddle = np.flatnonzero((surface.kind == SADDLE) & (np.diff(touches.start) == 2))
    pair = touches.atom[touches.start[saddle][:, None] + np.arange(2)]
    pair = np.where(unknown[pair[:, :1]], pair[:, ::-1], pair)  # the unknown atom is the second
    helps = located[pair[:, 0]] & unknown[pair[:, 1]]
    saddle, pair = saddle[helps], pair[helps]
    inward = -surface.normals[saddle]
    towards = atoms.xyz[pair] - (surface.points[saddle] - atoms.rules.probe_radius * inward)[:, None]
    towards /= np.linalg.norm(towards, axis=2, keepdims=True)
    cosines = np.einsum("ij,ikj->ik", inward, towards)
    between = np.einsum("ij,ij->i", towards[:, 0], towards[:, 1])
    is_fixed = (between > np.cos(MAX_ANGLE)) & (cosines[:, 0] ** 2 < 1 - MIN_ACROSS**2)
    saddle, pair, cosines = saddle[is_fixed], pair[is_fixed], cosines[is_fixed]
    best = _best_of_each(pair[:, 1], cosines.min(axis=1).round(9))
    return saddle[best], pair[best, 0], pair[best, 1]


def _best_of_each(group: np.ndarray, score: np.ndarray) -> np.ndarray:
    """Return the position of the highest score of each group, (g,) int64; of equal ones, the first."""
    order = np.lexsort((-score, group))
    return order[np.flatnonzero(np.diff(group[order], prepend=-1))]


def atoms_of(surface: Surface) -> SurfaceOrigin:
    """Return the atoms that dots were placed on; raise InputError if they are not known."""
    if surface.origin is None or surface.kind.min() < 0 or surface.atom.min() < 0:
        raise InputError(
            "cover: this sampler takes dots that `surface` placed on atoms; choose another one, such as farthest."
        )
    return surface.origin


def cover(prepared: SurfaceOnAtoms, n: int, rng: np.random.Generator) -> np.ndarray:
    """Determine every exposed atom, then add dots where the surface would err, and at last farthest points.

    Of all rounds, the one with the smallest mean error stays: dots that are close together can agree by chance on an atom that
    is not there, so that more of them do not always err less.
    """
    surface = prepared.surface
    atoms = atoms_of(surface)
    search = AtomCover(surface, atoms, rolled_atoms(atoms), prepared.threads)
    chosen = best = search.dots()
    if n <= len(chosen):  # evenly spread ones of them
        return chosen[farthest_point_sampling(build_grid(surface.points[chosen]), n, rng)]
    least = np.inf
    for k in range(MAX_ROUNDS_OF_DOTS + 1):
        errors = search.predicted_errors(chosen)
        mean = float((surface.area * errors).sum())
        if mean < least:
            best, least = chosen, mean
        beyond = surface.area * (errors > LEAST_ERROR)
        if k == MAX_ROUNDS_OF_DOTS or len(chosen) == n or not beyond.any():
            break
        chosen = np.concatenate([chosen, search.to_add(chosen, errors, beyond, 0.0)])[:n]
    return farthest_after(prepared.index, best, n)
