"""The atoms that the probe at each dot touches, and the fewest dots that touch atoms often enough."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sparsurf.kernels import njit
from sparsurf.recovery.spheres.explanations import touched_atoms
from sparsurf.surfaces.surface import Surface, SurfaceOrigin
from sparsurf.surfaces.vectors import slots

TOUCH = 1e-5  # Å, of a probe and an atom: rounding
SAME_PROBE = 1e-3  # Å, between centres of one probe: far above rounding, and far below the distance between lattice points


class Touches(NamedTuple):
    """The atoms that the probe at each of N dots touches: those of dot i are `atom[start[i]:start[i + 1]]`."""

    start: np.ndarray  # (N + 1,) int64
    atom: np.ndarray  # (T,) int64
    # (N,) int64, the first of the dots with the same probe, which follow one another
    first: np.ndarray

    @property
    def dot(self) -> np.ndarray:
        """The dot of each touch, (T,) int64."""
        return np.repeat(np.arange(len(self.first)), np.diff(self.start))

    def dots_of(self, atoms: np.ndarray) -> np.ndarray:
        """Return which dots touch one of some atoms, (N,) bool, given which atoms these are, (A,) bool."""
        found = np.zeros(len(self.first), bool)
        found[self.dot[atoms[self.atom]]] = True
        return found

    def areas(self, surface: Surface, n_atoms: int) -> np.ndarray:
        """Return the area of the dots that touch each atom, (A,) float64, Å^2; 0 where the probe cannot touch it."""
        return np.bincount(self.atom, surface.area[self.dot], n_atoms)


def touches_of(surface: Surface, atoms: SurfaceOrigin) -> Touches:
    """Find the atoms that the probe at each dot touches."""
    probe = atoms.rules.probe_radius
    probes = surface.points + probe * surface.normals
    is_first = np.append(True, np.abs(np.diff(probes, axis=0)).sum(axis=1) > SAME_PROBE)
    start, touched = touched_atoms(probes[is_first], atoms.xyz, atoms.radii + probe, TOUCH)
    place = np.cumsum(is_first) - 1  # of the probe of each dot among the different ones
    n = np.diff(start)[place]
    start_of_dot = np.append(0, np.cumsum(n))
    slot = np.arange(start_of_dot[-1]) + np.repeat(start[place] - start_of_dot[:-1], n)
    return Touches(start_of_dot, touched[slot], np.flatnonzero(is_first)[place])


@njit()
def set_cover(candidates: np.ndarray, touches: Touches, lacks: np.ndarray, used: np.ndarray) -> np.ndarray:
    """Return candidates, (n,) int64, each of which touches most atoms that lack a touch when it is chosen (greedy set cover).

    Of equally good ones, it is the one that stands first. `lacks` (A,), how many touches each atom lacks, and `used` (N,), by
    the first dot of a probe, whether the probe was chosen, are updated. Candidates are visited by falling gain: the gain of a
    dot never grows, so that one whose gain fell waits at its new level.
    """
    level, highest, n = np.empty(len(candidates), np.int64), 0, 0
    for e in range(len(candidates)):
        level[e] = touches.start[candidates[e] + 1] - touches.start[candidates[e]]
        highest = max(highest, level[e])
    out = np.empty(len(candidates), np.int64)
    for gain in range(highest, 0, -1):
        for e in range(len(candidates)):
            if level[e] != gain:
                continue
            i, now = candidates[e], 0
            if not used[touches.first[i]]:
                for k in slots(touches.start, i):
                    now += 1 if lacks[touches.atom[k]] > 0 else 0
            if now < gain:
                level[e] = now
                continue
            level[e] = 0
            out[n] = i
            n += 1
            used[touches.first[i]] = True
            for k in slots(touches.start, i):
                lacks[touches.atom[k]] -= 1
    return out[:n].copy()
